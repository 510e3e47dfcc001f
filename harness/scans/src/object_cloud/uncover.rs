//! Objects that are seen strip by strip, as from a vehicle that approaches.

use std::ops::RangeInclusive;

use detector::PointCloud;
use reports::vocabulary::named::named;

/// The steps in which an object is uncovered: at the last one everything is seen.
pub const UNCOVER_STEPS: RangeInclusive<u32> = 1..=10;

named! {
    /// Which end of an object is seen first.
    pub enum UncoverFrom {
        /// The foot, as by a scanner that is tilted down: what it hits of an object rises as the vehicle comes nearer.
        Below = "below",
        /// The top, as by a scanner that is tilted up: what it hits of an object sinks as the vehicle comes nearer.
        Above = "above",
    }
}

/// The part of `cloud`, one object, that is seen at `step` of [`UNCOVER_STEPS`]: each step adds a level strip as high as a
/// tenth of the largest extent of the object.
///
/// The extents are those of the box along the axes, and strips begin at its bottom or top. If the height is the largest
/// extent, as for trees, poles and people, `step` tenths of the height are seen. A car 4.5 m long and 1.5 m high is
/// uncovered 0.45 m at a time, and nothing is hidden from step 4 on: the paper relates steps to the largest extent and
/// uncovers from below or from above.
///
/// Points keep their order; those without a position are left out.
///
/// # Panics
///
/// If `step` is none of [`UNCOVER_STEPS`].
///
/// Paper: BG section 4, where 40 % more at each step is a misprint: step 5 of 10 is said to show 50 %.
pub fn uncover(cloud: &PointCloud, from: UncoverFrom, step: u32) -> PointCloud {
    assert!(UNCOVER_STEPS.contains(&step), "{step} is a step of {UNCOVER_STEPS:?}");
    let Some([least_m, greatest_m]) = bounds_m(cloud) else { return PointCloud::default() };
    let largest_extent_m = (0..3).map(|axis| greatest_m[axis] - least_m[axis]).fold(0.0_f64, f64::max);
    let n_steps = f64::from(*UNCOVER_STEPS.end());
    let mut seen = PointCloud::with_capacity(cloud.len());
    for (position_m, intensity) in cloud.positions_m().zip(cloud.intensity()) {
        let z_m = f64::from(position_m[2]);
        let from_end_m = match from {
            UncoverFrom::Below => z_m - least_m[2],
            UncoverFrom::Above => greatest_m[2] - z_m,
        };
        // Multiplied, not divided, so that no point of the last strip is lost by rounding.
        if is_finite(position_m) && from_end_m * n_steps <= largest_extent_m * f64::from(step) {
            seen.push(position_m, *intensity);
        }
    }
    seen
}

/// Least and greatest coordinates of the points that have a position, in metres; `None` if there are none.
fn bounds_m(cloud: &PointCloud) -> Option<[[f64; 3]; 2]> {
    let positions_m = cloud.positions_m().filter(|it| is_finite(*it)).map(|it| it.map(f64::from));
    positions_m.map(|it| [it, it]).reduce(|[least, greatest], [it, _]| {
        [[0, 1, 2].map(|axis| least[axis].min(it[axis])), [0, 1, 2].map(|axis| greatest[axis].max(it[axis]))]
    })
}

fn is_finite(position_m: [f32; 3]) -> bool {
    position_m.iter().all(|it| it.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A point at each of these heights, and two to either side of the lowest, `width_m` apart.
    fn column(heights_m: &[f32], width_m: f32) -> PointCloud {
        let sides = [-width_m / 2.0, width_m / 2.0].map(|x_m| [x_m, 0.0, heights_m[0]]);
        sides.into_iter().chain(heights_m.iter().map(|z_m| [0.0, 0.0, *z_m])).collect()
    }

    #[track_caller]
    fn check(cloud: &PointCloud, from: UncoverFrom, expected_n_points: [usize; 10]) {
        let found: Vec<usize> = UNCOVER_STEPS.map(|step| uncover(cloud, from, step).len()).collect();
        assert_eq!(found, expected_n_points, "{from:?}");
    }

    #[test]
    fn what_is_tallest_is_uncovered_by_tenths_of_its_height() {
        let pole = column(&[0.0, 0.15, 0.25, 1.0, 1.05, 2.0], 0.2);
        check(&pole, UncoverFrom::Below, [4, 5, 5, 5, 6, 7, 7, 7, 7, 8]);
        check(&pole, UncoverFrom::Above, [1, 1, 1, 1, 3, 3, 3, 3, 4, 8]);
    }

    #[test]
    fn a_car_is_whole_when_the_strips_have_passed_its_roof() {
        let car = column(&[0.0, 0.4, 0.5, 1.3, 1.5], 4.5);
        check(&car, UncoverFrom::Below, [4, 5, 6, 7, 7, 7, 7, 7, 7, 7]);
        check(&car, UncoverFrom::Above, [2, 2, 4, 7, 7, 7, 7, 7, 7, 7]);
    }

    #[test]
    fn heights_count_from_the_foot_of_the_object() {
        let hanging = column(&[3.0, 3.05, 3.95, 4.0], 0.1);
        check(&hanging, UncoverFrom::Below, [4, 4, 4, 4, 4, 4, 4, 4, 4, 6]);
    }

    #[test]
    fn without_extent_everything_is_seen_at_once() {
        check(&[[1.0, 2.0, 3.0]; 4].into_iter().collect(), UncoverFrom::Below, [4; 10]);
        check(&PointCloud::default(), UncoverFrom::Above, [0; 10]);
        let nowhere = [[f32::NAN, 0.0, 0.0], [1.0, f32::INFINITY, 0.0], [1.0, 2.0, 3.0]];
        check(&nowhere.into_iter().collect(), UncoverFrom::Above, [1; 10]);
    }

    proptest! {
        #[test]
        fn each_step_adds_to_the_one_before_and_the_last_shows_all(
            positions_m in proptest::collection::vec([-30.0_f32..30.0, -30.0_f32..30.0, -2.0_f32..30.0], 0..60),
        ) {
            let cloud: PointCloud = positions_m.into_iter().collect();
            for from in UncoverFrom::ALL {
                let counts: Vec<usize> = UNCOVER_STEPS.map(|step| uncover(&cloud, from, step).len()).collect();
                prop_assert!(counts.is_sorted());
                prop_assert_eq!(&uncover(&cloud, from, 10), &cloud);
            }
        }
    }
}
