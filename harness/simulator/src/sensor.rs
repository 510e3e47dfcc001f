//! Description of a rotating LiDAR: beams, turn, range, noise.

/// A rotating LiDAR, read from a description file.
///
/// ```
/// use simulator::sensor::SensorModel;
///
/// let sensor = SensorModel::hdl_64e_s2();
/// assert_eq!(sensor.n_beams(), 64);
/// ```
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorModel {
    /// Its name.
    pub name: String,
    /// Scans a second.
    pub turns_per_second: f32,
    /// How often each beam fires in a turn.
    pub n_firings_per_turn: u32,
    /// Nearer hits are not reported, in metres.
    pub min_range_m: f32,
    /// Farther hits are not reported, in metres.
    pub max_range_m: f32,
    /// Mounting height above the road, in metres.
    pub height_above_road_m: f32,
    /// Standard deviation of a measured range, in metres.
    pub range_noise_sigma_m: f32,
    /// Standard deviation over the beams of the range error a beam keeps for a whole drive, in metres.
    pub beam_range_error_sigma_m: f32,
    /// Standard deviation over the beams of the unknown part of a beam's elevation, in degrees.
    pub beam_elevation_error_sigma_deg: f32,
    /// Standard deviation over the beams of the unknown part of a beam's azimuth, in degrees.
    pub beam_azimuth_error_sigma_deg: f32,
    /// Width of a beam, in degrees: a beam that straddles an edge may give an echo between both surfaces.
    pub beam_divergence_deg: f32,
    /// Reflectivity times cosine of incidence over squared range at which half of the hits return.
    pub half_detected_signal_per_m2: f32,
    /// Emitter and receiver look side by side: at this range the receiver sees half of the lit spot, and less the nearer it
    /// is, so that nearer hits return weaker. 0 if they look through the same optics.
    pub near_field_m: f32,
    /// Share of hits that are lost whatever they hit, 0 to 1.
    pub random_loss: f32,
    /// The beams, from the top.
    pub blocks: Vec<BeamBlock>,
    /// The roof of the car that carries the sensor, if it shades beams.
    pub carrier_roof: Option<CarrierRoof>,
}

/// Ids and texts of the descriptions that come with the program.
pub const EMBEDDED_SENSORS: [(&str, &str); 8] = [
    ("hdl-64e-s2", include_str!("sensors/hdl-64e-s2.toml")),
    ("hdl-32e", include_str!("sensors/hdl-32e.toml")),
    ("vlp-16", include_str!("sensors/vlp-16.toml")),
    ("os1-128", include_str!("sensors/os1-128.toml")),
    ("argoverse2", include_str!("sensors/argoverse2.toml")),
    ("xt32", include_str!("sensors/xt32.toml")),
    ("pandar64", include_str!("sensors/pandar64.toml")),
    ("os0-128", include_str!("sensors/os0-128.toml")),
];

/// Beams at equal steps of elevation.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeamBlock {
    /// How many.
    pub n_beams: u32,
    /// Elevation of the first beam above the horizon, in degrees.
    pub top_elevation_deg: f32,
    /// Height of their common origin above the origin of the sensor frame, in metres.
    pub origin_height_m: f32,
    /// How much lower each next beam points, in degrees.
    pub step_deg: f32,
}

/// One beam as its description has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Elevation above the horizon in degrees.
    pub elevation_deg: f32,
    /// Height of its origin above the origin of the sensor frame, in metres.
    pub origin_height_m: f32,
}

/// A level rectangle below the sensor that swallows beams.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CarrierRoof {
    /// How far below the sensor, in metres.
    pub depth_below_sensor_m: f32,
    /// How far it reaches forward of the sensor, in metres.
    pub front_m: f32,
    /// How far it reaches backward, in metres.
    pub rear_m: f32,
    /// How far it reaches to either side, in metres.
    pub half_width_m: f32,
}

/// Why a description of a sensor is refused.
#[derive(Debug, thiserror::Error)]
pub enum SensorModelError {
    /// Not TOML, or not the fields of a [`SensorModel`].
    #[error(transparent)]
    Syntax(#[from] toml::de::Error),
    /// A value no sensor can have.
    #[error("{field} is {value}, which is not within {least} to {greatest}")]
    OutOfBounds {
        /// Which field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// The least it may be.
        least: f64,
        /// The most it may be.
        greatest: f64,
    },
}

impl SensorModel {
    /// The HDL-64E S2 of the KITTI recordings.
    pub fn hdl_64e_s2() -> Self {
        Self::embedded("hdl-64e-s2").expect("it is embedded")
    }

    /// The embedded description of this id, one of [`EMBEDDED_SENSORS`].
    pub fn embedded(id: &str) -> Option<Self> {
        let (_, text) = EMBEDDED_SENSORS.iter().find(|(known_id, _)| *known_id == id)?;
        Some(Self::from_toml(text).expect("a test reads every embedded description"))
    }

    /// Reads a description.
    pub fn from_toml(text: &str) -> Result<Self, SensorModelError> {
        let sensor: Self = toml::from_str(text)?;
        sensor.check()?;
        Ok(sensor)
    }

    /// Number of beams.
    pub fn n_beams(&self) -> u32 {
        self.blocks.iter().map(|block| block.n_beams).sum()
    }

    /// The nominal beams, in the order of the blocks.
    pub fn beams(&self) -> impl Iterator<Item = Beam> + '_ {
        self.blocks.iter().flat_map(|block| {
            (0..block.n_beams).map(|beam| Beam {
                elevation_deg: block.top_elevation_deg - beam as f32 * block.step_deg,
                origin_height_m: block.origin_height_m,
            })
        })
    }

    /// Refuses values that no sensor can have.
    pub(crate) fn check(&self) -> Result<(), SensorModelError> {
        let within = |field, value: f64, least: f64, greatest: f64| {
            let in_bounds = (least..=greatest).contains(&value);
            in_bounds.then_some(()).ok_or(SensorModelError::OutOfBounds { field, value, least, greatest })
        };
        within("turns_per_second", self.turns_per_second.into(), 0.1, 1000.0)?;
        within("n_firings_per_turn", self.n_firings_per_turn.into(), 1.0, 100_000.0)?;
        within("min_range_m", self.min_range_m.into(), 0.0, 100.0)?;
        within("max_range_m", self.max_range_m.into(), self.min_range_m.into(), 1000.0)?;
        within("height_above_road_m", self.height_above_road_m.into(), 0.1, 10.0)?;
        within("range_noise_sigma_m", self.range_noise_sigma_m.into(), 0.0, 1.0)?;
        within("beam_range_error_sigma_m", self.beam_range_error_sigma_m.into(), 0.0, 1.0)?;
        within("beam_elevation_error_sigma_deg", self.beam_elevation_error_sigma_deg.into(), 0.0, 5.0)?;
        within("beam_azimuth_error_sigma_deg", self.beam_azimuth_error_sigma_deg.into(), 0.0, 5.0)?;
        within("beam_divergence_deg", self.beam_divergence_deg.into(), 0.0, 5.0)?;
        within("half_detected_signal_per_m2", self.half_detected_signal_per_m2.into(), 1e-12, 1.0)?;
        within("near_field_m", self.near_field_m.into(), 0.0, 100.0)?;
        within("random_loss", self.random_loss.into(), 0.0, 1.0)?;
        let n_beams = self.blocks.iter().map(|block| f64::from(block.n_beams)).sum();
        within("number of beams", n_beams, 1.0, 1024.0)?;
        for beam in self.beams() {
            within("elevation of a beam in degrees", beam.elevation_deg.into(), -90.0, 90.0)?;
            within("origin_height_m", beam.origin_height_m.into(), -1.0, 1.0)?;
        }
        if let Some(roof) = self.carrier_roof {
            within("depth_below_sensor_m", roof.depth_below_sensor_m.into(), 0.01, 10.0)?;
            within("front_m", roof.front_m.into(), 0.0, 20.0)?;
            within("rear_m", roof.rear_m.into(), 0.0, 20.0)?;
            within("half_width_m", roof.half_width_m.into(), 0.0, 5.0)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_refused(from: &str, to: &str, expected_message: &str) {
        let text = include_str!("sensors/hdl-64e-s2.toml");
        assert!(text.contains(from));
        let error = SensorModel::from_toml(&text.replace(from, to)).unwrap_err();
        assert!(error.to_string().contains(expected_message), "{error}");
    }

    #[track_caller]
    fn check_embedded(id: &str, expected_n_beams: u32, [top_deg, bottom_deg]: [f32; 2]) {
        let sensor = SensorModel::embedded(id).unwrap();
        assert_eq!(sensor.n_beams(), expected_n_beams);
        let elevations_deg: Vec<f32> = sensor.beams().map(|beam| beam.elevation_deg).collect();
        assert!((elevations_deg[0] - top_deg).abs() < 0.01, "{}", elevations_deg[0]);
        // The lower of the two of Argoverse 2 is upside down.
        assert!(id == "argoverse2" || elevations_deg.is_sorted_by(|above, below| above > below), "{id}");
        let last_deg = elevations_deg[elevations_deg.len() - 1];
        assert!((last_deg - bottom_deg).abs() < 0.01, "{last_deg}");
    }

    #[test]
    fn embedded_sensors_have_the_beams_of_their_data_sheets() {
        check_embedded("hdl-64e-s2", 64, [2.0, -24.8]);
        check_embedded("hdl-32e", 32, [10.67, -30.67]);
        check_embedded("vlp-16", 16, [15.0, -15.0]);
        check_embedded("os1-128", 128, [22.5, -22.5]);
        // Two, the lower one upside down.
        check_embedded("argoverse2", 64, [15.0, -15.0]);
        check_embedded("xt32", 32, [15.0, -16.0]);
        check_embedded("pandar64", 64, [15.0, -25.0]);
        check_embedded("os0-128", 128, [45.0, -45.0]);
        let pandar64 = SensorModel::embedded("pandar64").unwrap();
        let n_dense = pandar64.beams().filter(|it| (-6.01..=2.01).contains(&it.elevation_deg)).count();
        assert_eq!(n_dense, 49);
        assert_eq!(EMBEDDED_SENSORS.len(), 8);
        assert_eq!(SensorModel::embedded("hdl-65"), None);
    }

    #[test]
    fn what_no_sensor_can_be_is_refused() {
        check_refused("random_loss", "random_los", "unknown field `random_los`");
        check_refused("turns_per_second = 10.0", "turns_per_second = 0.0", "turns_per_second is 0");
        check_refused("max_range_m = 120.0", "max_range_m = nan", "max_range_m is NaN");
        check_refused("n_beams = 32", "n_beams = 0", "number of beams is 0");
    }
}
