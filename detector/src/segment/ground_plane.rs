//! The plane through blocks of known ground.

/// Added to the sums of squared offsets, in square metres: so planes lean towards the level.
const LEVELLING_M2: f32 = 2.0;

/// A block that a plane goes through.
#[derive(Debug, Clone, Copy, Default)]
pub struct KnownBlock {
    /// Offset from the block in question on the ground plan, in metres.
    pub offset_m: [f32; 2],
    /// Elevation of its ground, in metres.
    pub elevation_m: f32,
    /// Its weight.
    pub weight: f32,
}

/// The plane in which the ground goes on.
#[derive(Debug, Clone, Copy)]
pub struct GroundPlane {
    middle_m: [f32; 3],
    slope: [f32; 2],
}

impl GroundPlane {
    /// The plane with the least squares to `known`, no steeper than `max_slope`; `None` if they have no weight.
    pub fn through(known: &[KnownBlock], max_slope: f32) -> Option<Self> {
        let (mut weight_sum, mut sums_m) = (0.0, [0.0; 3]);
        for it in known {
            let [x_m, y_m] = it.offset_m;
            weight_sum += it.weight;
            for (sum_m, value_m) in sums_m.iter_mut().zip([x_m, y_m, it.elevation_m]) {
                *sum_m += it.weight * value_m;
            }
        }
        if weight_sum <= 0.0 {
            return None;
        }
        let middle_m = sums_m.map(|it| it / weight_sum);
        let (mut xx, mut yy, mut xy, mut xz, mut yz) = (LEVELLING_M2, LEVELLING_M2, 0.0, 0.0, 0.0);
        for it in known {
            let (x_m, y_m) = (it.offset_m[0] - middle_m[0], it.offset_m[1] - middle_m[1]);
            let z_m = it.elevation_m - middle_m[2];
            xx += it.weight * x_m * x_m;
            yy += it.weight * y_m * y_m;
            xy += it.weight * x_m * y_m;
            xz += it.weight * x_m * z_m;
            yz += it.weight * y_m * z_m;
        }
        let determinant = xx * yy - xy * xy;
        let slope = [(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant];
        let steepness = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
        let share = if steepness > max_slope { max_slope / steepness } else { 1.0 };
        Some(Self { middle_m, slope: slope.map(|it| share * it) })
    }

    /// Its elevation at this offset from the block in question, in metres.
    pub fn elevation_m(&self, offset_m: [f32; 2]) -> f32 {
        let [x_m, y_m] = [0, 1].map(|axis| offset_m[axis] - self.middle_m[axis]);
        self.middle_m[2] + self.slope[0] * x_m + self.slope[1] * y_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(slope: f32, weight: f32) -> Vec<KnownBlock> {
        let steps = || [-6.0_f32, -3.0, 0.0, 3.0, 6.0];
        let at = |x_m, y_m| KnownBlock { offset_m: [x_m, y_m], elevation_m: slope * x_m - 1.7, weight };
        steps().into_iter().flat_map(|x_m| steps().map(|y_m| at(x_m, y_m))).collect()
    }

    #[test]
    fn it_goes_on_as_blocks_do_and_no_steeper_than_roads() {
        let beyond_m =
            |slope: f32| GroundPlane::through(&blocks(slope, 1.0), 0.2).unwrap().elevation_m([10.0, 0.0]);
        // It leans a little towards the level.
        assert!((beyond_m(0.1) + 0.7).abs() < 0.01, "{}", beyond_m(0.1));
        assert!((beyond_m(0.5) - 0.3).abs() < 1e-5, "{}", beyond_m(0.5));
    }

    #[test]
    fn blocks_that_do_not_count_have_none() {
        assert!(GroundPlane::through(&[], 0.2).is_none());
        assert!(GroundPlane::through(&blocks(0.1, 0.0), 0.2).is_none());
    }
}
