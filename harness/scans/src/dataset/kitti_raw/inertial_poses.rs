//! `oxts/data/NNNNNNNNNN.txt`: poses of the inertial unit, as latitude, longitude, height and turn.

use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::dataset::DatasetError;
use crate::dataset::text_file::text_lines;

/// Radius in the makers' tools, in metres.
const EARTH_RADIUS_M: f64 = 6_378_137.0;

/// The line of one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertialFix {
    latitude_rad: f64,
    longitude_rad: f64,
    height_m: f64,
    roll_pitch_yaw_rad: [f64; 3],
}

/// Reads the file of one scan; the first six of its thirty numbers are the pose of the unit.
pub fn parse_inertial_fix(path: &Path, text: &str) -> Result<InertialFix, DatasetError> {
    let Some(mut line) = text_lines(path, text).next() else {
        return Err(DatasetError::Damaged { path: path.to_path_buf(), problem: "is empty".to_owned() });
    };
    let [latitude_deg, longitude_deg, height_m] = line.numbers("position")?;
    let roll_pitch_yaw_rad = line.numbers("turn")?;
    if latitude_deg.abs() >= 85.0 || longitude_deg.abs() > 360.0 {
        return Err(line.error(format!("latitude {latitude_deg} and longitude {longitude_deg} do not exist")));
    }
    let (latitude_rad, longitude_rad) = (latitude_deg.to_radians(), longitude_deg.to_radians());
    Ok(InertialFix { latitude_rad, longitude_rad, height_m, roll_pitch_yaw_rad })
}

impl InertialFix {
    /// The pose of the unit in a frame with x to the east, y to the north and z up, whose origin is at `origin`.
    ///
    /// A Mercator projection that keeps lengths at the latitude of `origin`, as in the makers' tools.
    pub fn world_from_unit(&self, origin: &Self) -> Isometry3<f64> {
        let scale_m = origin.latitude_rad.cos() * EARTH_RADIUS_M;
        let northward =
            |it: &Self| scale_m * (std::f64::consts::FRAC_PI_4 + it.latitude_rad / 2.0).tan().ln();
        let [roll_rad, pitch_rad, yaw_rad] = self.roll_pitch_yaw_rad;
        Isometry3::from_parts(
            Translation3::new(
                scale_m * (self.longitude_rad - origin.longitude_rad),
                northward(self) - northward(origin),
                self.height_m - origin.height_m,
            ),
            UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, yaw_rad),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<InertialFix, String> {
        parse_inertial_fix(Path::new("o.txt"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_minute_of_latitude_is_a_nautical_mile() {
        let origin = parse("49 8.4 110 0 0 0 1 2 3").unwrap();
        let north = parse("49.016666666666666 8.4 112 0 0 1.5707963267948966").unwrap();
        let pose = north.world_from_unit(&origin);
        assert!((pose.translation.y - 1855.3).abs() < 0.5, "{pose}");
        assert!(pose.translation.x.abs() < 1e-9 && (pose.translation.z - 2.0).abs() < 1e-9);
        let ahead = pose.rotation * nalgebra::Vector3::x();
        assert!((ahead.y - 1.0).abs() < 1e-12, "{ahead}");
    }

    #[test]
    fn what_is_no_position_is_refused() {
        assert_eq!(parse(" \n").expect_err("empty"), "\"o.txt\" is empty");
        assert_eq!(parse("49 8.4 110 0 0").expect_err("short"), "\"o.txt\", line 1: ends before its turn");
        assert!(parse("90 8.4 110 0 0 0").expect_err("the pole").contains("do not exist"));
    }
}
