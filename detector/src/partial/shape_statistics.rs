//! Shape statistics of the seen part of an object, from all of its points.

use super::level_spread::LevelSpread;
use super::seen_extents::SeenExtents;

/// Shape statistics of the seen part of an object: lengths in metres, shares, and how much it leans. All points count,
/// because thinning would take the edge off thin things.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShapeStatistics {
    /// Its extents.
    pub extents: SeenExtents,
    /// How its points spread on the ground plan.
    pub spread: LevelSpread,
    /// Height of the mean of its points above its bottom, in metres.
    pub mean_height_m: f64,
    /// Standard deviation of their heights, in metres.
    pub deviation_up_m: f64,
    /// How far it goes aside for each metre upward, by the line that fits its points best.
    pub tilt: f64,
    /// Level slices that its height is cut into, from the lowest to the highest.
    pub slices: [ShapeSlice; N_SLICES],
}

/// The points within a sixth of the height.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShapeSlice {
    /// Its share of all points.
    pub share: f64,
    /// How its points spread on the ground plan; all 0 for fewer than three.
    pub spread: LevelSpread,
}

/// Number of level slices.
pub const N_SLICES: usize = 6;
/// Slices with fewer points have no spread.
const LEAST_POINTS: usize = 3;
/// Lower objects count as this high, in metres.
const LEAST_HEIGHT_M: f64 = 1e-3;
/// Added to the squares of heights, so that level objects have no tilt, in square metres.
const LEVEL_M2: f64 = 1e-6;

impl ShapeStatistics {
    /// Height of the seen part, from its bottom to its top, in metres.
    pub fn height_m(&self) -> f64 {
        self.extents.top_m - self.extents.bottom_m
    }
}

/// A buffer for the statistics of one object after another.
#[derive(Debug, Clone, Default)]
pub struct ShapeMeter {
    by_slice: Vec<[f64; 3]>,
}

impl ShapeMeter {
    /// The shape statistics of these points; all 0 without points. A point where two slices meet belongs to the upper one.
    /// Not in the papers.
    pub fn measure(&mut self, points_m: impl Iterator<Item = [f64; 3]> + Clone) -> ShapeStatistics {
        let spread = LevelSpread::of(points_m.clone());
        let extents = SeenExtents::with_spread(spread, points_m.clone());
        let UpwardSums { n_points, mean_z_m, deviation_up_m, tilt } = UpwardSums::of(points_m.clone());
        ShapeStatistics {
            extents,
            spread,
            mean_height_m: mean_z_m - extents.bottom_m,
            deviation_up_m,
            tilt,
            slices: self.slices(points_m, &extents, n_points),
        }
    }

    fn slices(
        &mut self,
        points_m: impl Iterator<Item = [f64; 3]> + Clone,
        extents: &SeenExtents,
        n_points: usize,
    ) -> [ShapeSlice; N_SLICES] {
        let slices_per_m = N_SLICES as f64 / (extents.top_m - extents.bottom_m).max(LEAST_HEIGHT_M);
        let slice_of = |z: f64| (((z - extents.bottom_m) * slices_per_m) as usize).min(N_SLICES - 1);
        let mut counts = [0; N_SLICES];
        for [_, _, z] in points_m.clone() {
            counts[slice_of(z)] += 1;
        }
        let mut starts = [0; N_SLICES];
        for slice in 1..N_SLICES {
            starts[slice] = starts[slice - 1] + counts[slice - 1];
        }
        let mut next = starts;
        self.by_slice.clear();
        self.by_slice.resize(n_points, [0.0; 3]);
        for point_m in points_m {
            let index = &mut next[slice_of(point_m[2])];
            self.by_slice[*index] = point_m;
            *index += 1;
        }
        std::array::from_fn(|slice| {
            let inside = &self.by_slice[starts[slice]..starts[slice] + counts[slice]];
            let share = inside.len() as f64 / n_points.max(1) as f64;
            let spread = if inside.len() < LEAST_POINTS {
                LevelSpread::default()
            } else {
                LevelSpread::of(inside.iter().copied())
            };
            ShapeSlice { share, spread }
        })
    }
}

/// Mean and deviation of heights, and the tilt of the main axis.
struct UpwardSums {
    n_points: usize,
    mean_z_m: f64,
    deviation_up_m: f64,
    tilt: f64,
}

impl UpwardSums {
    fn of(points_m: impl Iterator<Item = [f64; 3]> + Clone) -> Self {
        let (mut n_points, mut sum_z) = (0, 0.0);
        for [_, _, z] in points_m.clone() {
            n_points += 1;
            sum_z += z;
        }
        let [first_x, first_y, _] = points_m.clone().next().unwrap_or_default();
        let n = n_points.max(1) as f64;
        let mean_z_m = sum_z / n;
        let (mut with_x, mut with_y, mut squares) = (0.0, 0.0, 0.0);
        for [x, y, z] in points_m {
            let z = z - mean_z_m;
            with_x += z * (x - first_x);
            with_y += z * (y - first_y);
            squares += z * z;
        }
        let tilt = (with_x * with_x + with_y * with_y).sqrt() / (squares + LEVEL_M2);
        Self { n_points, mean_z_m, deviation_up_m: (squares / n).sqrt(), tilt }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board 1 m wide at the foot and 3 m at the head, 6 m high, which moves aside by `tilt` metres a metre.
    fn board(tilt: f64) -> Vec<[f64; 3]> {
        let row = |z: u32| {
            let half_m = if z >= 50 { 1.5 } else { 0.5 };
            [-1.0, 0.0, 1.0].map(|side| [7.0 + half_m * side, tilt * f64::from(z) * 0.1, f64::from(z) * 0.1])
        };
        (0..60).flat_map(row).chain([[7.0, tilt * 6.0, 6.0]]).collect()
    }

    fn shape(points_m: &[[f64; 3]]) -> ShapeStatistics {
        ShapeMeter::default().measure(points_m.iter().copied())
    }

    #[test]
    fn slices_are_measured_by_themselves() {
        let shape = shape(&board(0.0));
        let lengths_m = shape.slices.map(|it| it.spread.length_m);
        assert_eq!(lengths_m, [1.0, 1.0, 1.0, 1.0, 1.0, 3.0]);
        assert!((shape.height_m() - 6.0).abs() < 1e-12 && shape.spread.width_m == 0.0);
        assert!((shape.slices[0].spread.deviation_along_m - (0.25_f64 / 1.5).sqrt()).abs() < 1e-12);
        assert!((shape.slices.iter().map(|it| it.share).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(shape.slices[..5].iter().all(|it| (it.share - 30.0 / 181.0).abs() < 1e-9), "{shape:?}");
    }

    #[test]
    fn heights_have_a_mean_above_the_bottom_and_a_deviation() {
        let shape = shape(&[[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 4.0], [5.0, 0.0, 4.0]]);
        assert_eq!((shape.mean_height_m, shape.deviation_up_m), (1.0, 1.0));
    }

    #[test]
    fn what_goes_aside_leans() {
        for tilt in [0.0, 0.1, 0.5] {
            let found = shape(&board(tilt)).tilt;
            assert!((found - tilt).abs() < 1e-6, "{found} {tilt}");
        }
    }

    #[test]
    fn slices_of_few_points_have_no_spread_and_nothing_has_no_form() {
        let slices = shape(&[[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 5.0]]).slices;
        assert!(slices.iter().all(|it| it.spread == LevelSpread::default()), "{slices:?}");
        assert_eq!(shape(&[]), ShapeStatistics::default());
    }
}
