//! At what height above the ground points lie.

use detector::PointCloud;
use detector::grid::hierarchical_grid::NO_CELL;
use detector::pipeline::frame::Frame;
use reports::numbers::curve_pair::{CurveBin, CurvePair, Measured, Sides};

/// The lowest bin begins this far above the ground, in metres.
const LOWEST_M: f32 = -1.0;
/// Height of a bin in metres.
const BIN_M: f32 = 0.25;
/// Number of bins; the last ends at 5 m.
const N_BINS: usize = 24;
/// Fewest points of a bin on the right: its share is then known to a tenth.
const LEAST_POINTS: u64 = 100;

/// The points of one scan by their height.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeightCounts {
    /// Points in every bin.
    n_in_bin: [u64; N_BINS],
    /// Points of the gridded square, at whatever height.
    n_points: u64,
}

impl HeightCounts {
    /// Counts the points of `cloud`, the latest scan of `frame`, by their height above the terrain below their cells.
    pub fn of<C>(cloud: &PointCloud, frame: &Frame<C>) -> Self {
        let mut counts = Self { n_in_bin: [0; N_BINS], n_points: 0 };
        let Frame { grid, terrain, .. } = frame;
        for (&z_m, &cell_idx) in cloud.z_m().iter().zip(grid.cell_of_point()) {
            if cell_idx == NO_CELL {
                continue;
            }
            counts.n_points += 1;
            let height_m = z_m - terrain.elevation_m(grid.column_and_row(cell_idx));
            let bin = ((height_m - LOWEST_M) / BIN_M).floor();
            if (0.0..N_BINS as f32).contains(&bin) {
                counts.n_in_bin[bin as usize] += 1;
            }
        }
        counts
    }
}

/// Share of the points in every bin of height, over all scans together.
pub fn height_histogram(counts: &Sides<Vec<HeightCounts>>) -> CurvePair {
    let bin = |bin_idx: usize| {
        let from_m = f64::from(LOWEST_M + BIN_M * bin_idx as f32);
        let to_m = from_m + f64::from(BIN_M);
        CurveBin {
            name: format!("{from_m}..{to_m} m"),
            ends_m: Some([from_m, to_m]),
            measured: counts.as_ref().map(|scans| {
                let n: u64 = scans.iter().map(|it| it.n_in_bin[bin_idx]).sum();
                let n_points: u64 = scans.iter().map(|it| it.n_points).sum();
                Measured { value: (n_points > 0).then(|| 100.0 * n as f64 / n_points as f64), n }
            }),
        }
    };
    CurvePair {
        statistic: "height_histogram",
        title: "share of the points",
        bins_of: Some("height above the ground"),
        focus_m: None,
        unit: "%",
        counted: "points",
        least_n: Sides { left: 0, right: LEAST_POINTS },
        bins: (0..N_BINS).map(bin).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realism::drawn_scan;

    #[test]
    fn the_drawn_scan_has_its_road_at_height_0_and_a_car_above() {
        let counts = HeightCounts::of(&drawn_scan::scan().cloud, &drawn_scan::frame());
        assert_eq!(counts.n_points, drawn_scan::N_POINTS);
        // Rounding may put the road in the bin below 0 or above.
        assert_eq!(counts.n_in_bin[3] + counts.n_in_bin[4], drawn_scan::N_ROAD);
        let n_above: u64 = counts.n_in_bin[5..].iter().sum();
        assert_eq!(n_above, drawn_scan::N_POINTS - drawn_scan::N_ROAD);
    }

    #[test]
    fn shares_are_of_all_points_of_the_square() {
        let scan = |n_low, n_points| {
            let mut n_in_bin = [0; N_BINS];
            n_in_bin[0] = n_low;
            HeightCounts { n_in_bin, n_points }
        };
        let curves =
            height_histogram(&Sides { left: vec![scan(1, 10), scan(2, 10)], right: vec![scan(300, 1000)] });
        assert_eq!(curves.bins[0].name, "-1..-0.75 m");
        assert_eq!((curves.bins[0].measured.left.value, curves.ratio(0)), (Some(15.0), Some(0.5)));
        assert_eq!(curves.bins[23].ends_m, Some([4.75, 5.0]));
    }
}
