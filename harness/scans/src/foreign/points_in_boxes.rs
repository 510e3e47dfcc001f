//! The points in each of many boxes.

use detector::{OrientedBox, PointCloud};

/// The most points that all boxes of a scan together may hold: boxes with more are no detections of objects, and would fill
/// the memory.
const MOST_POINTS: usize = 50_000_000;

/// The points of a scan in the order of x, so that a box is compared with few of them.
pub struct PointsAlongX {
    sorted: Vec<(f32, u32)>,
    n_found: usize,
}

impl PointsAlongX {
    /// Sorts the points of `cloud`.
    pub fn of(cloud: &PointCloud) -> Self {
        let mut sorted: Vec<(f32, u32)> = cloud.x_m().iter().copied().zip(0..).collect();
        sorted.sort_unstable_by(|first, second| first.0.total_cmp(&second.0));
        Self { sorted, n_found: 0 }
    }

    /// Whether any point of `cloud`, which must be the same, is inside or on `bounding_box`.
    pub fn is_any_inside(&self, cloud: &PointCloud, bounding_box: &OrientedBox) -> bool {
        self.near(bounding_box).any(|it| bounding_box.contains(cloud.position_m(it as usize)))
    }

    /// Indices of the points of `cloud`, which must be the same, inside or on `bounding_box`, ascending.
    pub fn inside(&mut self, cloud: &PointCloud, bounding_box: &OrientedBox) -> Result<Vec<u32>, String> {
        let is_inside = |it: &u32| bounding_box.contains(cloud.position_m(*it as usize));
        let mut inside: Vec<u32> = self.near(bounding_box).filter(is_inside).collect();
        inside.sort_unstable();
        self.n_found += inside.len();
        if self.n_found > MOST_POINTS {
            return Err(format!("its boxes hold more than {MOST_POINTS} points together"));
        }
        Ok(inside)
    }

    /// Indices of the points whose x may be in a box.
    fn near(&self, bounding_box: &OrientedBox) -> impl Iterator<Item = u32> + '_ {
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        // A little more than half of the diagonal, so that rounding loses no point.
        let reach_m = 0.5 * length_m.hypot(width_m) * 1.001 + 0.001;
        let (low_m, high_m) = (bounding_box.center_m[0] - reach_m, bounding_box.center_m[0] + reach_m);
        let first = self.sorted.partition_point(|it| it.0 < low_m);
        self.sorted[first..].iter().take_while(move |it| it.0 <= high_m).map(|(_, point_idx)| *point_idx)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotation::points_inside;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_points_are_those_that_a_look_at_all_finds(
            positions_m in prop::collection::vec(prop::array::uniform3(-20.0_f32..20.0), 0..200),
            center_m in prop::array::uniform3(-20.0_f32..20.0),
            length_width_height_m in prop::array::uniform3(0.1_f32..30.0),
            yaw_rad in -4.0_f32..4.0,
        ) {
            let cloud: PointCloud = positions_m.into_iter().collect();
            let bounding_box = OrientedBox { center_m, length_width_height_m, yaw_rad };
            let found = PointsAlongX::of(&cloud).inside(&cloud, &bounding_box).unwrap();
            prop_assert_eq!(found, points_inside(&cloud, &bounding_box));
        }
    }

    #[test]
    fn boxes_that_hold_everything_are_refused_in_time() {
        let cloud: PointCloud = (0..100_000).map(|it| [it as f32 / 10_000.0, 0.0, 0.0]).collect();
        let all = OrientedBox { center_m: [0.0; 3], length_width_height_m: [1000.0; 3], yaw_rad: 0.0 };
        let mut points = PointsAlongX::of(&cloud);
        let problem = (0..MOST_POINTS).find_map(|_| points.inside(&cloud, &all).err());
        assert!(problem.is_some_and(|it| it.contains("50000000 points")));
    }
}
