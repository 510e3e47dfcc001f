//! Streets of the simulator as a data set.

use serde::Deserialize;

use super::checksum::sha256;
use super::{AnnotatedClasses, Dataset, DatasetDescription, DatasetError};
use crate::annotation::{LabeledScan, PointRegion, ScanId};
use crate::simulator::sensor::SensorModel;
use crate::simulator::{Street, StreetKind};

/// Which street is driven through, and which scans are taken.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StreetDrive {
    /// What kind of street it is.
    pub street: StreetKind,
    /// What it is drawn from, and what happens on it.
    pub seed: u64,
    /// Number of scans.
    pub n_scans: u32,
    /// Turns of the sensor from one scan to the next; 1 takes every turn.
    pub turns_per_scan: u32,
    /// Only this far to either side of forward counts as labelled, in degrees, as where a camera decides what people
    /// label. Everything is, if it is left out.
    pub labeled_to_either_side_deg: Option<f32>,
}

/// A drive through a simulated street. Scans are made when they are read.
struct SimulatedStreet {
    description: DatasetDescription,
    street: Street,
    sensor: SensorModel,
    scan_ids: Vec<ScanId>,
    labeled_to_either_side_deg: Option<f32>,
}

/// The format's name in tables and files.
const FORMAT: &str = "simulated-street";

/// Opens the drive as the data set called `id`.
pub fn open_simulated_street(id: &str, drive: &StreetDrive) -> Box<dyn Dataset> {
    let street = Street::new(drive.street, drive.seed);
    let sensor = SensorModel::hdl_64e_s2();
    let turns = (0..drive.n_scans).map(|scan| scan * drive.turns_per_scan);
    let scan_ids: Vec<ScanId> = turns.map(|index| ScanId { sequence: street.sequence(), index }).collect();
    let made_of = format!(
        "{}scans {}\nturns per scan {}\nlabelled to either side {:?}\n",
        street.provenance(&sensor),
        drive.n_scans,
        drive.turns_per_scan,
        drive.labeled_to_either_side_deg
    );
    let description = DatasetDescription {
        id: id.to_owned(),
        format: FORMAT.to_owned(),
        root: None,
        simulated: true,
        annotated: AnnotatedClasses::EveryObject,
        sensor_height_m: sensor.height_above_road_m,
        licence: None,
        checksum: Some(sha256(&made_of)),
        seed: Some(drive.seed),
    };
    let labeled_to_either_side_deg = drive.labeled_to_either_side_deg;
    Box::new(SimulatedStreet { description, street, sensor, scan_ids, labeled_to_either_side_deg })
}

impl Dataset for SimulatedStreet {
    fn description(&self) -> &DatasetDescription {
        &self.description
    }

    fn scan_ids(&self) -> &[ScanId] {
        &self.scan_ids
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let mut scan = self.street.scan(&self.sensor, self.scan_ids[scan_idx].index);
        if let Some(limit_deg) = self.labeled_to_either_side_deg {
            mark_outside(&mut scan, limit_deg);
        }
        Ok(scan)
    }
}

/// Marks all points farther than `limit_deg` to either side of forward as outside of what is labelled.
fn mark_outside(scan: &mut LabeledScan, limit_deg: f32) {
    let columns = scan.cloud.x_m().iter().zip(scan.cloud.y_m());
    for ((x_m, y_m), region) in columns.zip(&mut scan.point_regions) {
        if y_m.atan2(*x_m).abs().to_degrees() > limit_deg {
            *region = PointRegion::Outside;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: StreetDrive = StreetDrive {
        street: StreetKind::MainRoad,
        seed: 3,
        n_scans: 4,
        turns_per_scan: 5,
        labeled_to_either_side_deg: None,
    };

    #[test]
    fn what_is_beside_a_limited_view_is_not_labelled() {
        let limited = StreetDrive { labeled_to_either_side_deg: Some(40.0), ..DRIVE };
        let scan = open_simulated_street("street", &limited).read_scan(0).unwrap();
        let everything = open_simulated_street("street", &DRIVE).read_scan(0).unwrap();
        assert!(everything.point_regions.iter().all(|&it| it == PointRegion::Labeled));
        assert_eq!(scan.cloud, everything.cloud);
        for (position_m, region) in scan.cloud.positions_m().zip(&scan.point_regions) {
            let is_ahead =
                position_m[0] > 0.0 && position_m[1].abs() < position_m[0] * 40.0_f32.to_radians().tan();
            assert_eq!(is_ahead, *region == PointRegion::Labeled, "{position_m:?}");
        }
    }

    #[test]
    fn scans_are_the_turns_that_were_asked_for() {
        let dataset = open_simulated_street("street", &DRIVE);
        let turns: Vec<u32> = dataset.scan_ids().iter().map(|it| it.index).collect();
        assert_eq!(turns, [0, 5, 10, 15]);
        let scan = dataset.read_scan(2).unwrap();
        assert_eq!(scan.id, dataset.scan_ids()[2]);
        assert_eq!(scan, Street::new(StreetKind::MainRoad, 3).scan(&SensorModel::hdl_64e_s2(), 10));
    }

    #[test]
    fn the_checksum_changes_with_the_seed() {
        let checksum =
            |drive: &StreetDrive| open_simulated_street("street", drive).description().checksum.clone();
        assert_ne!(checksum(&DRIVE), checksum(&StreetDrive { seed: 4, ..DRIVE }));
        assert_eq!(checksum(&DRIVE), checksum(&DRIVE));
    }
}
