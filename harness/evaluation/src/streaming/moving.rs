//! Times, poses between two scans, and boxes that move.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use reports::rows::match_outcome::BoxFacts;
use reports::rows::pose_row::PoseRow;
use scans::conversion::results::detection_rows::{box_facts, oriented_box};
use scans::dataset::pose::isometry;
use scans::dataset::upright_box::{pose_of_box, upright_box};

/// Whole microseconds since the first scan of a drive.
pub type TimeUs = i64;

/// Microseconds of a millisecond.
pub const US_PER_MS: f64 = 1000.0;

/// The pose that is the `share` of the way from `from` to `to`: the position on the straight line, the turn on the shortest
/// arc.
pub fn between(from: &Isometry3<f64>, to: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let at_m = from.translation.vector.lerp(&to.translation.vector, share);
    // Half a turn within a tenth of a second has no shortest arc.
    let turn = from.rotation.try_slerp(&to.rotation, share, 1e-9).unwrap_or(from.rotation);
    Isometry3::from_parts(Translation3::from(at_m), turn)
}

/// The pose `share` times as far as from `from` to `to`, also beyond `to` or before `from`; the turn stays that of `to`.
pub fn beyond(from: &Isometry3<f64>, to: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let at_m = from.translation.vector.lerp(&to.translation.vector, share);
    Isometry3::from_parts(Translation3::from(at_m), to.rotation)
}

/// The pose of the middle of a box, in the frame of its values.
pub fn pose_of(bounding_box: &BoxFacts) -> Isometry3<f64> {
    pose_of_box(&oriented_box(bounding_box))
}

/// A box of this size at `pose`, set upright.
pub fn box_at(pose: &Isometry3<f64>, length_width_height_m: [f32; 3]) -> BoxFacts {
    box_facts(&upright_box(pose, length_width_height_m.map(f64::from)))
}

/// The pose of a row.
///
/// # Errors
///
/// A sentence if it is none.
pub fn pose_of_row(row: &PoseRow) -> Result<Isometry3<f64>, String> {
    isometry([row.x_m, row.y_m, row.z_m], [row.qx, row.qy, row.qz, row.qw])
}

/// The turn of a pose about the vertical alone, in radians.
pub fn yaw_rad(turn: &UnitQuaternion<f64>) -> f64 {
    turn.euler_angles().2
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_pose_in_between_takes_the_short_way_round() {
        let pose =
            |x_m: f64, yaw_rad: f64| Isometry3::new(Vector3::new(x_m, 0.0, 0.0), Vector3::z() * yaw_rad);
        let middle = between(&pose(1.0, 3.0), &pose(3.0, -3.0), 0.5);
        assert!((middle.translation.x - 2.0).abs() < 1e-12);
        assert!((yaw_rad(&middle.rotation).abs() - std::f64::consts::PI).abs() < 1e-9, "{middle}");
        assert_eq!(beyond(&pose(1.0, 0.0), &pose(3.0, 0.5), 1.5).translation.x, 4.0);
    }

    #[test]
    fn a_box_is_where_its_pose_is() {
        let car =
            BoxFacts { center_m: [5.0, -2.0, 0.5], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.5 };
        assert_eq!(box_at(&pose_of(&car), car.length_width_height_m), car);
        let turned = Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2) * pose_of(&car);
        let turned = box_at(&turned, car.length_width_height_m);
        assert!((turned.center_m[0] - 2.0).abs() < 1e-6 && (turned.center_m[1] - 5.0).abs() < 1e-6);
    }
}
