//! The points of each box.

use detector::{OrientedBox, PointCloud};

use crate::annotation::Annotation;

/// Gives every annotation with a box the points in it, as [`points_of_boxes`] finds them; others keep theirs.
pub fn assign_points_in_boxes(cloud: &PointCloud, annotations: &mut [Annotation]) {
    let mut boxed: Vec<&mut Annotation> =
        annotations.iter_mut().filter(|it| it.bounding_box.is_some()).collect();
    let boxes: Vec<_> = boxed.iter().filter_map(|it| it.bounding_box).collect();
    for (annotation, points) in boxed.iter_mut().zip(points_of_boxes(cloud, &boxes)) {
        annotation.point_indices = points;
    }
}

/// For every box, the indices of its points, ascending.
///
/// A point belongs to the box that contains it; if several do, to the one of least volume, since a small box around a
/// person beside a car says more about the point than the car's; among equals, to the first. Hence no point belongs to
/// two boxes.
pub fn points_of_boxes(cloud: &PointCloud, boxes: &[OrientedBox]) -> Vec<Vec<u32>> {
    let mut point_indices = vec![Vec::new(); boxes.len()];
    let squares = squares_by_volume(boxes);
    // Most points are near no box; one comparison with the square around all boxes rules them out.
    let Some(around_all) = squares.iter().map(|(_, square)| *square).reduce(Square::join) else {
        return point_indices;
    };
    for (point_idx, (&x_m, &y_m)) in (0_u32..).zip(cloud.x_m().iter().zip(cloud.y_m())) {
        if !around_all.contains(x_m, y_m) {
            continue;
        }
        let position_m = [x_m, y_m, cloud.z_m()[point_idx as usize]];
        let owner = squares
            .iter()
            .find(|(box_idx, square)| square.contains(x_m, y_m) && boxes[*box_idx].contains(position_m));
        if let Some((box_idx, _)) = owner {
            point_indices[*box_idx].push(point_idx);
        }
    }
    point_indices
}

/// An upright rectangle on the ground plan, along the axes of the sensor.
#[derive(Clone, Copy)]
struct Square {
    min_m: [f32; 2],
    max_m: [f32; 2],
}

impl Square {
    /// A rectangle around `bounding_box` for any yaw.
    fn around(bounding_box: &OrientedBox) -> Self {
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        // A little larger than half the diagonal, so that rounding never loses a point that the box contains.
        let reach_m = 0.501 * length_m.hypot(width_m) + 1e-3;
        let [x_m, y_m, _] = bounding_box.center_m;
        Self { min_m: [x_m - reach_m, y_m - reach_m], max_m: [x_m + reach_m, y_m + reach_m] }
    }

    fn join(self, other: Self) -> Self {
        Self {
            min_m: [self.min_m[0].min(other.min_m[0]), self.min_m[1].min(other.min_m[1])],
            max_m: [self.max_m[0].max(other.max_m[0]), self.max_m[1].max(other.max_m[1])],
        }
    }

    fn contains(&self, x_m: f32, y_m: f32) -> bool {
        x_m >= self.min_m[0] && x_m <= self.max_m[0] && y_m >= self.min_m[1] && y_m <= self.max_m[1]
    }
}

/// Indices of the boxes with their rectangles, the smallest box first.
fn squares_by_volume(boxes: &[OrientedBox]) -> Vec<(usize, Square)> {
    let volume_m3 = |box_idx: usize| boxes[box_idx].length_width_height_m.iter().product::<f32>();
    let mut by_volume: Vec<usize> = (0..boxes.len()).collect();
    by_volume.sort_by(|&a, &b| volume_m3(a).total_cmp(&volume_m3(b)).then(a.cmp(&b)));
    by_volume.into_iter().map(|box_idx| (box_idx, Square::around(&boxes[box_idx]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotation::points_inside;
    use proptest::prelude::*;

    fn cube(x_m: f32, side_m: f32) -> OrientedBox {
        OrientedBox { center_m: [x_m, 0.0, 0.0], length_width_height_m: [side_m; 3], yaw_rad: 0.0 }
    }

    /// Points on the x axis.
    #[track_caller]
    fn check(points_x_m: &[f32], boxes: &[OrientedBox], expected: &[&[u32]]) {
        let cloud: PointCloud = points_x_m.iter().map(|&x_m| [x_m, 0.0, 0.0]).collect();
        assert_eq!(points_of_boxes(&cloud, boxes), expected);
    }

    #[test]
    fn without_boxes_there_are_no_points() {
        check(&[1.0, 2.0], &[], &[]);
    }

    #[test]
    fn a_point_in_two_boxes_belongs_to_the_smaller() {
        check(&[-1.5, 0.5, 1.5], &[cube(0.0, 4.0), cube(1.0, 2.0)], &[&[0], &[1, 2]]);
    }

    #[test]
    fn a_point_in_two_equal_boxes_belongs_to_the_first() {
        check(&[0.5], &[cube(0.0, 2.0), cube(1.0, 2.0)], &[&[0], &[]]);
    }

    #[test]
    fn nan_belongs_to_no_box() {
        check(&[f32::NAN, 0.0], &[cube(0.0, 2.0)], &[&[1]]);
    }

    fn any_box() -> impl Strategy<Value = OrientedBox> {
        (prop::array::uniform3(-5.0_f32..5.0), prop::array::uniform3(0.1_f32..6.0), -7.0_f32..7.0).prop_map(
            |(center_m, length_width_height_m, yaw_rad)| OrientedBox {
                center_m,
                length_width_height_m,
                yaw_rad,
            },
        )
    }

    proptest! {
        #[test]
        fn a_single_box_has_the_points_inside_it(
            positions_m in prop::collection::vec(prop::array::uniform3(-6.0_f32..6.0), 0..200),
            bounding_box in any_box(),
        ) {
            let cloud: PointCloud = positions_m.into_iter().collect();
            let found = points_of_boxes(&cloud, &[bounding_box]);
            prop_assert_eq!(&found[0], &points_inside(&cloud, &bounding_box));
        }

        #[test]
        fn every_point_inside_some_box_belongs_to_exactly_one(
            positions_m in prop::collection::vec(prop::array::uniform3(-6.0_f32..6.0), 0..200),
            boxes in prop::collection::vec(any_box(), 0..6),
        ) {
            let cloud: PointCloud = positions_m.into_iter().collect();
            let mut owned = points_of_boxes(&cloud, &boxes).concat();
            owned.sort_unstable();
            let mut inside: Vec<u32> = boxes.iter().flat_map(|it| points_inside(&cloud, it)).collect();
            inside.sort_unstable();
            inside.dedup();
            prop_assert_eq!(owned, inside);
        }
    }
}
