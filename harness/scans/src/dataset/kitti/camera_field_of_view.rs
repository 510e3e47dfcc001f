//! The region of KITTI's labels: the image of the left colour camera without its `DontCare` parts.

use detector::PointCloud;
use nalgebra::{Matrix3x4, Vector4};

use super::label::ImageBox;
use crate::annotation::{Annotation, LabeledArea, PointRegion};

/// The camera and the labelled part of its image.
#[derive(Debug, Clone, Copy)]
pub struct CameraFieldOfView<'a> {
    /// From homogeneous velodyne coordinates to homogeneous pixels.
    pub image_from_velodyne: &'a Matrix3x4<f64>,
    /// Width and height of the image in pixels.
    pub image_size_px: [u32; 2],
    /// Parts of the image in which objects were not labelled.
    pub dont_care: &'a [ImageBox],
}

impl CameraFieldOfView<'_> {
    /// The positions that the camera sees. `DontCare` is about points alone: a rectangle of the image is no position.
    pub fn labeled_area(&self) -> LabeledArea {
        LabeledArea::CameraImage {
            image_from_sensor: *self.image_from_velodyne,
            image_size_px: self.image_size_px,
        }
    }
}

/// For every point of `cloud`, whether the labels say anything about it.
///
/// Points behind the camera or projected beside the image are outside. Points projected into a `DontCare` rectangle are
/// unscorable, unless they belong to one of `annotations`: a rectangle also covers objects before and behind the unlabelled
/// ones. Points that something hides from the camera, which sits beside the sensor, are treated like others.
pub fn point_regions(
    cloud: &PointCloud,
    annotations: &[Annotation],
    view: &CameraFieldOfView<'_>,
) -> Vec<PointRegion> {
    let mut regions: Vec<PointRegion> =
        cloud.positions_m().map(|position_m| region_of(position_m, view)).collect();
    for point_idx in annotations.iter().flat_map(|annotation| &annotation.point_indices) {
        let region = &mut regions[*point_idx as usize];
        if *region == PointRegion::Unscorable {
            *region = PointRegion::Labeled;
        }
    }
    regions
}

/// The region of a point that belongs to no annotation.
fn region_of(position_m: [f32; 3], view: &CameraFieldOfView<'_>) -> PointRegion {
    let [x, y, z] = position_m.map(f64::from);
    let projected = view.image_from_velodyne * Vector4::new(x, y, z, 1.0);
    let [width_px, height_px] = view.image_size_px.map(f64::from);
    // Multiplied by the depth instead of divided by it: most points are behind the camera or beside the image.
    let depth = projected.z;
    let in_image = depth > 0.0
        && projected.x >= 0.0
        && projected.y >= 0.0
        && projected.x < width_px * depth
        && projected.y < height_px * depth;
    if !in_image {
        return PointRegion::Outside;
    }
    let (column_px, row_px) = (projected.x / depth, projected.y / depth);
    let in_dont_care = view.dont_care.iter().any(|it| {
        let [left_px, top_px, right_px, bottom_px] = it.left_top_right_bottom_px;
        (left_px..=right_px).contains(&column_px) && (top_px..=bottom_px).contains(&row_px)
    });
    if in_dont_care { PointRegion::Unscorable } else { PointRegion::Labeled }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::kitti::calibration::parse_calibration;
    use crate::dataset::kitti::calibration::tests::FORWARD_CAMERA;
    use reports::vocabulary::class::AnnotationClass;
    use std::path::Path;

    /// One point, with an image of 1242 × 375 pixels whose left half down to the horizon is `DontCare`.
    #[track_caller]
    fn check(position_m: [f32; 3], annotations: &[Annotation], expected: PointRegion) {
        let calibration = parse_calibration(Path::new("c.txt"), FORWARD_CAMERA).unwrap();
        let view = CameraFieldOfView {
            image_from_velodyne: &calibration.image_from_velodyne,
            image_size_px: [1242, 375],
            dont_care: &[ImageBox { left_top_right_bottom_px: [0.0, 0.0, 620.0, 187.0] }],
        };
        let cloud = PointCloud::from_iter([position_m]);
        assert_eq!(point_regions(&cloud, annotations, &view), [expected]);
    }

    fn annotation_of_the_point() -> Annotation {
        Annotation { point_indices: vec![0], ..Annotation::of(AnnotationClass::Car) }
    }

    #[test]
    fn what_is_ahead_is_labeled() {
        check([10.0, -1.0, -1.0], &[], PointRegion::Labeled);
    }

    #[test]
    fn what_is_behind_is_outside() {
        check([-10.0, 1.0, 1.0], &[], PointRegion::Outside);
        check([0.0, 0.0, 0.0], &[], PointRegion::Outside);
    }

    #[test]
    fn what_projects_beside_the_image_is_outside() {
        check([10.0, -9.0, 0.0], &[], PointRegion::Outside);
        check([10.0, 9.0, 0.0], &[], PointRegion::Outside);
        check([10.0, 0.0, 3.0], &[], PointRegion::Outside);
        check([10.0, 0.0, -3.0], &[], PointRegion::Outside);
    }

    #[test]
    fn what_projects_into_dont_care_is_unscorable() {
        check([10.0, 1.0, 1.0], &[], PointRegion::Unscorable);
    }

    #[test]
    fn an_annotated_point_in_dont_care_is_labeled() {
        check([10.0, 1.0, 1.0], &[annotation_of_the_point()], PointRegion::Labeled);
    }

    #[test]
    fn an_annotated_point_beside_the_image_is_outside() {
        check([10.0, 9.0, 0.0], &[annotation_of_the_point()], PointRegion::Outside);
    }
}
