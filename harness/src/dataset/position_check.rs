//! Which positions a reader takes.
//!
//! The same in all formats: a point of which a coordinate is NaN or infinite has no position. It stays in its place, so that labels
//! of points still fit, belongs to no object, and is counted. A coordinate beyond what any sensor sees is damage.

use detector::PointCloud;

/// Coordinates of a point in the sensor frame are within this of 0, in metres.
pub const MAX_COORDINATE_M: f32 = 10_000.0;

/// Makes sure that no coordinate is beyond [`MAX_COORDINATE_M`]. Errors are the rest of a sentence about the file.
///
/// # Errors
///
/// If one is, with the point and the coordinate.
pub fn check_positions(cloud: &PointCloud) -> Result<(), String> {
    let axes = [("x", cloud.x_m()), ("y", cloud.y_m()), ("z", cloud.z_m())];
    let is_beyond = |coordinate_m: &f32| coordinate_m.is_finite() && coordinate_m.abs() > MAX_COORDINATE_M;
    for (axis, coordinates_m) in axes {
        if let Some(point_idx) = coordinates_m.iter().position(is_beyond) {
            let coordinate_m = coordinates_m[point_idx];
            return Err(format!(
                "has point {point_idx} with {axis} = {coordinate_m} m, but no sensor sees farther than {MAX_COORDINATE_M} m"
            ));
        }
    }
    Ok(())
}

/// Points of `cloud` without a position.
pub fn n_without_position(cloud: &PointCloud) -> usize {
    cloud.positions_m().filter(|it| !it.iter().all(|coordinate_m| coordinate_m.is_finite())).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_without_position_is_counted_and_one_beyond_all_sensors_refused() {
        let cloud = PointCloud::from_iter([
            [1.0, f32::NAN, 0.0],
            [-10_000.0, 0.0, 10_000.0],
            [0.0, f32::INFINITY, 0.0],
        ]);
        assert_eq!((check_positions(&cloud), n_without_position(&cloud)), (Ok(()), 2));
        let cloud = PointCloud::from_iter([[1.0, 2.0, 3.0], [0.0, 0.0, -10_001.0]]);
        let expected = "has point 1 with z = -10001 m, but no sensor sees farther than 10000 m";
        assert_eq!(check_positions(&cloud), Err(expected.to_owned()));
    }
}
