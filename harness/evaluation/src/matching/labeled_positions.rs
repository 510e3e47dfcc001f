//! Whether objects were labelled at a position, even if the sensor saw nothing there.

use nalgebra::{Matrix3x4, Vector4};
use scans::annotation::{LabeledArea, LabeledScan, PointRegion};

/// Number of distinguished directions if only the points show the labelled area: one for each degree.
const N_DIRECTIONS: usize = 360;

/// Positions in a direction count as labelled if at least this share of its points is inside the labelled region. Not a
/// half: a camera sees nothing of the ground near the sensor, in whatever direction it looks.
const MIN_LABELED_SHARE: f64 = 0.25;

/// The positions of a scan at which objects were labelled.
#[derive(Debug, Clone, PartialEq)]
pub struct LabeledPositions {
    area: LabeledArea,
    // One entry for each direction if the area is known only from the points; else empty.
    is_outside: Vec<bool>,
}

impl LabeledPositions {
    /// Those of `scan`.
    ///
    /// If the labelled area is known only from the points, positions are judged by direction, in steps of a degree: labelled
    /// regions are what a camera or a person saw from the sensor. A position is outside if fewer than a quarter of the
    /// points in its direction are inside the region; a direction without points is judged as the nearest one with points,
    /// and in a scan without points every position is outside.
    pub fn of(scan: &LabeledScan) -> Self {
        let is_outside = match scan.labeled_area {
            LabeledArea::AsPoints => outside_directions(scan),
            LabeledArea::Everywhere | LabeledArea::CameraImage { .. } | LabeledArea::Ahead { .. } => {
                Vec::new()
            }
        };
        Self { area: scan.labeled_area, is_outside }
    }

    /// Whether nothing was labelled at `position_m`, x and y in metres.
    pub fn is_outside(&self, position_m: [f32; 2]) -> bool {
        match &self.area {
            LabeledArea::Everywhere => false,
            LabeledArea::CameraImage { image_from_sensor, image_size_px } => {
                !is_seen(position_m, image_from_sensor, *image_size_px)
            }
            LabeledArea::Ahead { to_either_side_deg } => {
                position_m[1].atan2(position_m[0]).abs().to_degrees() > *to_either_side_deg
            }
            LabeledArea::AsPoints => self.is_outside[direction_of(position_m)],
        }
    }
}

/// Whether a point at this position projects into the image at some height.
fn is_seen([x_m, y_m]: [f32; 2], image_from_sensor: &Matrix3x4<f64>, image_size_px: [u32; 2]) -> bool {
    let level = image_from_sensor * Vector4::new(f64::from(x_m), f64::from(y_m), 0.0, 1.0);
    let per_metre = image_from_sensor.column(2);
    let [width_px, height_px] = image_size_px.map(f64::from);
    // Each side of the image, and the plane of the camera, leaves a half-line of heights: where a + b z is above 0.
    let sides: [[f64; 3]; 5] =
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [-1.0, 0.0, width_px], [0.0, 1.0, 0.0], [0.0, -1.0, height_px]];
    let (mut lowest_m, mut highest_m) = (f64::NEG_INFINITY, f64::INFINITY);
    for side in sides {
        let along = |of: [f64; 3]| side[0] * of[0] + side[1] * of[1] + side[2] * of[2];
        let a = along([level.x, level.y, level.z]);
        let b = along([per_metre.x, per_metre.y, per_metre.z]);
        if b > 0.0 {
            lowest_m = lowest_m.max(-a / b);
        } else if b < 0.0 {
            highest_m = highest_m.min(-a / b);
        } else if a < 0.0 {
            return false;
        }
    }
    lowest_m < highest_m
}

fn outside_directions(scan: &LabeledScan) -> Vec<bool> {
    let mut n_points = [0_u32; N_DIRECTIONS];
    let mut n_inside = [0_u32; N_DIRECTIONS];
    let columns = scan.cloud.x_m().iter().zip(scan.cloud.y_m());
    for ((&x_m, &y_m), region) in columns.zip(&scan.point_regions) {
        if x_m.is_finite() && y_m.is_finite() {
            let direction = direction_of([x_m, y_m]);
            n_points[direction] += 1;
            n_inside[direction] += u32::from(*region != PointRegion::Outside);
        }
    }
    let is_outside = |direction: usize| {
        f64::from(n_inside[direction]) < MIN_LABELED_SHARE * f64::from(n_points[direction])
    };
    // The nearest direction with points, to the left first.
    let with_points = |direction: usize| {
        let turned = (0..=N_DIRECTIONS / 2).flat_map(|by| [direction + by, direction + N_DIRECTIONS - by]);
        turned.map(|it| it % N_DIRECTIONS).find(|it| n_points[*it] > 0)
    };
    (0..N_DIRECTIONS).map(|direction| with_points(direction).is_none_or(is_outside)).collect()
}

fn direction_of([x_m, y_m]: [f32; 2]) -> usize {
    let turns = f64::from(y_m).atan2(f64::from(x_m)) / std::f64::consts::TAU;
    ((turns.rem_euclid(1.0) * N_DIRECTIONS as f64) as usize).min(N_DIRECTIONS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::drawn_labels::labeled;
    use detector::PointCloud;
    use proptest::prelude::*;

    /// Points all round at these ranges, of which those within `deg` of forward are inside the region.
    fn scan(labeled_area: LabeledArea, inside_deg: f32) -> LabeledScan {
        let positions = (0..720_u16).flat_map(|half_degrees| {
            let (sin, cos) = (f32::from(half_degrees) / 2.0 + 0.2).to_radians().sin_cos();
            [5.0, 20.0, 60.0].map(|range_m| [range_m * cos, range_m * sin, -1.7])
        });
        let cloud: PointCloud = positions.collect();
        let region = |[x_m, y_m, _]: [f32; 3]| {
            if y_m.atan2(x_m).abs().to_degrees() <= inside_deg {
                PointRegion::Labeled
            } else {
                PointRegion::Outside
            }
        };
        let point_regions = cloud.positions_m().map(region).collect();
        LabeledScan { point_regions, labeled_area, ..labeled(cloud.positions_m(), []) }
    }

    /// A camera at the sensor that looks forward: x to the right is -y, y down is -z; 1000 × 400 pixels, 45° to either side.
    fn camera() -> LabeledArea {
        let image_from_sensor = Matrix3x4::new(
            500.0, -500.0, 0.0, 0.0, //
            200.0, 0.0, -500.0, 0.0, //
            1.0, 0.0, 0.0, 0.0,
        );
        LabeledArea::CameraImage { image_from_sensor, image_size_px: [1000, 400] }
    }

    #[track_caller]
    fn check(area: LabeledArea, position_m: [f32; 2], expected_outside: bool) {
        let positions = LabeledPositions::of(&scan(area, 40.0));
        assert_eq!(positions.is_outside(position_m), expected_outside, "{area:?} {position_m:?}");
    }

    #[test]
    fn a_camera_sees_what_is_ahead_between_its_sides_however_near() {
        check(camera(), [10.0, 9.9], false);
        check(camera(), [10.0, 10.1], true);
        check(camera(), [10.0, -10.1], true);
        check(camera(), [1.0, 0.0], false);
        check(camera(), [-10.0, 0.0], true);
        check(camera(), [0.0, 0.0], true);
    }

    #[test]
    fn a_tilted_camera_sees_positions_at_some_height() {
        // Turned down by 45°: nothing on the level of the sensor is in the image, the ground far ahead is, and nothing
        // behind.
        let LabeledArea::CameraImage { image_from_sensor, image_size_px } = camera() else { unreachable!() };
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let camera_from_sensor = nalgebra::Matrix4::new(
            half, 0.0, -half, 0.0, 0.0, 1.0, 0.0, 0.0, half, 0.0, half, 0.0, 0.0, 0.0, 0.0, 1.0,
        );
        let image_from_sensor = image_from_sensor * camera_from_sensor;
        let tilted = LabeledArea::CameraImage { image_from_sensor, image_size_px };
        check(tilted, [100.0, 0.0], false);
        check(tilted, [-100.0, 0.0], true);
        check(tilted, [0.0, 500.0], true);
    }

    #[test]
    fn ahead_is_an_angle_to_either_side() {
        let ahead = LabeledArea::Ahead { to_either_side_deg: 40.0 };
        check(ahead, [10.0, 8.3], false);
        check(ahead, [10.0, -8.3], false);
        check(ahead, [10.0, 8.5], true);
        check(ahead, [-1.0, 0.0], true);
        check(LabeledArea::Everywhere, [-1.0, 0.0], false);
    }

    #[test]
    fn points_decide_by_direction() {
        check(LabeledArea::AsPoints, [7.0, 0.1], false);
        check(LabeledArea::AsPoints, [10.0, 8.0], false);
        check(LabeledArea::AsPoints, [10.0, 9.0], true);
        check(LabeledArea::AsPoints, [-70.0, 0.1], true);
        let empty = LabeledScan { labeled_area: LabeledArea::AsPoints, ..labeled([], []) };
        assert!(LabeledPositions::of(&empty).is_outside([1.0, 0.0]));
    }

    #[test]
    fn a_direction_without_points_is_as_its_neighbours() {
        let cloud = PointCloud::from_iter([[10.0, 5.0, 0.0], [10.0, -5.0, 0.0], [f32::NAN, 0.0, 0.0]]);
        let point_regions = vec![PointRegion::Unscorable, PointRegion::Outside, PointRegion::Outside];
        let positions =
            LabeledPositions::of(&LabeledScan { cloud, point_regions, ..scan(LabeledArea::AsPoints, 0.0) });
        assert!(!positions.is_outside([10.0, 1.0]) && !positions.is_outside([10.0, 50.0]));
        assert!(positions.is_outside([10.0, -1.0]) && positions.is_outside([-10.0, -1.0]));
    }

    proptest! {
        /// A camera sees a position if and only if trying many heights finds one that projects into the image.
        #[test]
        fn a_camera_sees_what_trying_heights_finds(x_m in -60.0_f32..60.0, y_m in -60.0_f32..60.0) {
            let LabeledArea::CameraImage { image_from_sensor, image_size_px } = camera() else { unreachable!() };
            let is_in_image = |step: i32| {
                let z_m = f64::from(step) * 0.02;
                let it = image_from_sensor * Vector4::new(f64::from(x_m), f64::from(y_m), z_m, 1.0);
                let [width_px, height_px] = image_size_px.map(f64::from);
                it.z > 0.0 && it.x >= 0.0 && it.y >= 0.0 && it.x < width_px * it.z && it.y < height_px * it.z
            };
            prop_assert_eq!(is_seen([x_m, y_m], &image_from_sensor, image_size_px), (-2000..2000).any(is_in_image));
        }
    }
}
