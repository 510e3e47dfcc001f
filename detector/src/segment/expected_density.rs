//! How many points dense cells are expected to hold, by their range.

use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::portable_math::single;

/// Expected density of dense cells at one range.
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    /// Points of a dense cell on an upright object.
    pub object_points: f32,
    /// Most steps between occupied dense cells without a gap between them.
    pub max_steps: u32,
}

impl Expected {
    /// Fewest points of a dense cell that is not near-empty: `low_density_share` of those it could be expected to hold, on an
    /// upright object and as the others of its coarse cell, whose numbers of points are `n_points`.
    pub fn least_points(&self, low_density_share: f32, n_points: impl Iterator<Item = u32>) -> f32 {
        let (n_occupied, sum) =
            n_points.filter(|&it| it > 0).fold((0, 0), |(n_occupied, sum), it| (n_occupied + 1, sum + it));
        let mean = sum as f32 / n_occupied.max(1) as f32;
        (low_density_share * mean.min(self.object_points)).max(1.0)
    }
}

/// Expected density of dense cells at every range.
///
/// The density falls with about the cube of the range, over level ground, where the sensor's rays fan out in proportion to
/// the range: so its cube root gives how far apart neighbouring points of one surface may lie.
///
/// Paper: HG section 4.
#[derive(Debug, Clone)]
pub struct ExpectedDensity {
    by_metre: Vec<Expected>,
}

impl ExpectedDensity {
    /// For grids of the geometry `grid`. Upright objects hold `object_density_ratio` times the points that all points
    /// together put into a dense cell at their range; where the latter are `single_gap_points`, a single empty dense cell is
    /// a gap.
    pub fn new(
        object_density_ratio: f32,
        single_gap_points: f32,
        grid: &GridParams,
        weighting: &DensityWeighting,
    ) -> Self {
        let dense_size_m = grid.cell_size_m / grid.xi as f32;
        let points_at_weight_1 = weighting.peak_points_per_m2() * dense_size_m * dense_size_m;
        // Multiplying the expected points by the weight is dividing all counts by it.
        let expected = |weight: &f32| Expected {
            object_points: object_density_ratio * points_at_weight_1 * weight,
            max_steps: single::cbrt(single_gap_points / (points_at_weight_1 * weight)).ceil().max(1.0) as u32,
        };
        Self { by_metre: weighting.weight_by_metre().iter().map(expected).collect() }
    }

    /// The expected density of the dense cells of a coarse cell.
    pub fn of_cell(&self, grid: &HierarchicalGrid, cell_idx: u32) -> Expected {
        let [x_m, y_m] = grid.center_m(cell_idx);
        let metre = (x_m * x_m + y_m * y_m).sqrt() as usize;
        self.by_metre[metre.min(self.by_metre.len() - 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_the_mean_counts_only_up_to_what_an_object_holds() {
        let least = |n_points: &[u32], object_points| {
            let expected = Expected { object_points, max_steps: 1 };
            expected.least_points(0.3, n_points.iter().copied())
        };
        // The mean of the occupied ones is 11.
        assert_eq!(least(&[20, 2, 0, 0, 0], 100.0), 0.3 * 11.0);
        assert_eq!(least(&[20, 2, 0, 0, 0], 5.0), 0.3 * 5.0);
        // One point suffices where few are expected, and an empty cell holds too few.
        assert_eq!(least(&[1, 0, 0, 0], 1e-6), 1.0);
        assert_eq!(least(&[0, 0], 5.0), 1.0);
    }
}
