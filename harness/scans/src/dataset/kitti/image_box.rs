//! The part of the image that shows a box.

use detector::OrientedBox;
use nalgebra::{Matrix3x4, Vector4};

/// The rectangle of the image, in pixels, around the corners of a box, cut to the image: left, top, right and bottom. `None`
/// if the box lies beside the image, or not wholly before the camera.
pub fn image_box(
    bounding_box: &OrientedBox,
    image_from_velodyne: &Matrix3x4<f64>,
    image_size_px: [u32; 2],
) -> Option<[f64; 4]> {
    let half_height_m = f64::from(bounding_box.length_width_height_m[2]) / 2.0;
    let center_z_m = f64::from(bounding_box.center_m[2]);
    let mut around_px = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for corner_m in bounding_box.footprint_m() {
        for z_m in [center_z_m - half_height_m, center_z_m + half_height_m] {
            let [x_m, y_m] = corner_m.map(f64::from);
            let projected = image_from_velodyne * Vector4::new(x_m, y_m, z_m, 1.0);
            if projected.z <= 0.0 {
                return None;
            }
            let (right_px, down_px) = (projected.x / projected.z, projected.y / projected.z);
            around_px = [
                around_px[0].min(right_px),
                around_px[1].min(down_px),
                around_px[2].max(right_px),
                around_px[3].max(down_px),
            ];
        }
    }
    // The index of the last pixel is one less than the size.
    let [last_right_px, last_down_px] = image_size_px.map(|it| f64::from(it) - 1.0);
    let [left_px, top_px, right_px, bottom_px] = around_px;
    let is_seen = right_px > 0.0 && left_px < last_right_px && bottom_px > 0.0 && top_px < last_down_px;
    is_seen.then(|| {
        [left_px.max(0.0), top_px.max(0.0), right_px.min(last_right_px), bottom_px.min(last_down_px)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::kitti::calibration::parse_calibration;
    use crate::dataset::kitti::calibration::tests::FORWARD_CAMERA;
    use std::path::Path;

    #[track_caller]
    fn check(center_m: [f32; 3], expected_px: Option<[f64; 4]>) {
        let calibration = parse_calibration(Path::new("c.txt"), FORWARD_CAMERA).unwrap();
        let cube = OrientedBox { center_m, length_width_height_m: [2.0; 3], yaw_rad: 0.0 };
        assert_eq!(image_box(&cube, &calibration.image_from_velodyne, [1242, 375]), expected_px);
    }

    #[test]
    fn the_rectangle_is_around_the_nearest_corners_and_within_the_image() {
        // The near side is 10 m ahead, where 700 px are 10 m.
        check([11.0, 0.0, 0.0], Some([551.0, 117.0, 691.0, 257.0]));
        check([11.0, 8.5, 0.0], Some([0.0, 117.0, 621.0 - 700.0 * 7.5 / 12.0, 257.0]));
    }

    #[test]
    fn what_the_camera_does_not_see_has_no_rectangle() {
        check([-11.0, 0.0, 0.0], None);
        check([0.5, 0.0, 0.0], None);
        check([11.0, 30.0, 0.0], None);
        check([11.0, 0.0, 9.0], None);
    }
}
