//! Poses relative to the beginning of a drive.

use nalgebra::Isometry3;
use scans::annotation::ScanId;

/// The frame of the first scan of the drive at hand.
///
/// Poses of a data set may count from anywhere. Relative to the first scan of its drive, a sensor is never so far away that
/// single precision does not suffice.
#[derive(Debug, Clone, Default)]
pub struct DriveFrame {
    drive: Option<(String, String)>,
    world_from_start: Isometry3<f64>,
    positions_m: Vec<[f32; 3]>,
}

/// Number of positions that are kept: half a minute of a sensor that turns ten times a second.
const MAX_POSITIONS: usize = 300;

impl DriveFrame {
    /// Pose of the sensor relative to the first scan of its drive that was asked for. This scan becomes the first if
    /// `dataset` or the sequence is another than before.
    pub fn start_from_sensor(
        &mut self,
        dataset: &str,
        scan: &ScanId,
        world_from_sensor: Isometry3<f64>,
    ) -> Isometry3<f64> {
        let is_same = |it: &(String, String)| it.0 == dataset && it.1 == scan.sequence;
        if !self.drive.as_ref().is_some_and(is_same) {
            self.drive = Some((dataset.to_owned(), scan.sequence.clone()));
            self.world_from_start = world_from_sensor;
            self.positions_m.clear();
        }
        let start_from_sensor = self.world_from_start.inverse() * world_from_sensor;
        if self.positions_m.len() == MAX_POSITIONS {
            self.positions_m.remove(0);
        }
        self.positions_m.push(start_from_sensor.translation.vector.cast::<f32>().into());
        start_from_sensor
    }

    /// The latest positions of the sensor on this drive, in the same frame.
    pub fn positions_m(&self) -> &[[f32; 3]] {
        &self.positions_m
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn every_drive_starts_at_the_origin() {
        let mut frame = DriveFrame::default();
        let quarter_turn = Vector3::z() * std::f64::consts::FRAC_PI_2;
        let mut position = |dataset: &str, sequence: &str, x_m: f64| {
            let scan = ScanId { sequence: sequence.to_owned(), index: 0 };
            let world_from_sensor = Isometry3::new(Vector3::new(x_m, 5e6, 0.0), quarter_turn);
            let at_m = frame.start_from_sensor(dataset, &scan, world_from_sensor).translation.vector;
            [at_m.x, at_m.y].map(|it| (it * 1e3).round() / 1e3)
        };
        assert_eq!(position("city", "0", 4.0), [0.0, 0.0]);
        // Forward is the world's y, so that what lies further along its x lies to the right.
        assert_eq!(position("city", "0", 6.0), [0.0, -2.0]);
        assert_eq!(position("city", "1", 6.0), [0.0, 0.0]);
        assert_eq!(position("village", "1", 7.0), [0.0, 0.0]);
        assert_eq!(position("village", "1", 8.0), [0.0, -1.0]);
        assert_eq!(frame.positions_m().len(), 2);
    }
}
