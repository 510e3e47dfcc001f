//! A scanner with one beam that turns in a plane.

use crate::sensor::{SensorModel, SensorModelError};

/// A 2-D scanner, read from a description file: a rotating one with a single level beam that is blind behind.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanarScanner {
    /// Width of the field that it sees, the same to either side of forward, in degrees.
    pub field_of_view_deg: f32,
    /// Everything else, as of a rotating scanner.
    pub turning: SensorModel,
}

impl PlanarScanner {
    /// The one that comes with the program: 270 degrees in steps of a quarter, 25 times a second.
    pub fn embedded() -> Self {
        Self::from_toml(include_str!("../sensors/tilted-2d.toml")).expect("a test reads the description")
    }

    /// Reads a description.
    pub fn from_toml(text: &str) -> Result<Self, SensorModelError> {
        let scanner: Self = toml::from_str(text)?;
        scanner.turning.check()?;
        let out_of_bounds =
            |field, value, least, greatest| SensorModelError::OutOfBounds { field, value, least, greatest };
        if !(1.0..=360.0).contains(&scanner.field_of_view_deg) {
            let value = f64::from(scanner.field_of_view_deg);
            return Err(out_of_bounds("field_of_view_deg", value, 1.0, 360.0));
        }
        let n_beams = f64::from(scanner.turning.n_beams());
        if n_beams != 1.0 {
            return Err(out_of_bounds("number of beams", n_beams, 1.0, 1.0));
        }
        let elevation_deg = scanner.turning.blocks.iter().map(|it| f64::from(it.top_elevation_deg)).sum();
        if elevation_deg != 0.0 {
            return Err(out_of_bounds("elevation of a beam in degrees", elevation_deg, 0.0, 0.0));
        }
        Ok(scanner)
    }

    /// Whether firing `firing` of a turn, which begins behind, falls into the field of view.
    pub fn sees(&self, firing: usize) -> bool {
        let turned = (firing as f64 + 0.5) / f64::from(self.turning.n_firings_per_turn);
        (turned * 360.0 - 180.0).abs() <= f64::from(self.field_of_view_deg) / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_one_sees_270_degrees_in_quarters() {
        let scanner = PlanarScanner::embedded();
        let n_seen = (0..scanner.turning.n_firings_per_turn as usize).filter(|it| scanner.sees(*it)).count();
        assert_eq!(n_seen, 1080);
        assert!(!scanner.sees(0) && !scanner.sees(179) && scanner.sees(180) && scanner.sees(720));
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, part: &str) {
        let text = include_str!("../sensors/tilted-2d.toml");
        assert!(text.contains(from));
        let error = PlanarScanner::from_toml(&text.replace(from, to)).expect_err("no such scanner");
        assert!(error.to_string().contains(part), "{error}");
    }

    #[test]
    fn what_is_no_planar_scanner_is_refused() {
        check_refused("field_of_view_deg = 270.0", "field_of_view_deg = nan", "field_of_view_deg is NaN");
        check_refused("field_of_view_deg", "field_of_vew_deg", "unknown field `field_of_vew_deg`");
        check_refused("n_beams = 1", "n_beams = 2", "number of beams is 2");
        check_refused(
            "top_elevation_deg = 0.0",
            "top_elevation_deg = 3.0",
            "elevation of a beam in degrees is 3",
        );
        check_refused("max_range_m = 50.0", "max_range_m = 0.01", "not within 0.05");
    }
}
