//! Streets of the simulator as a data set.

use serde::Deserialize;

use super::checksum::sha256;
use super::{AnnotatedClasses, Dataset, DatasetDescription, DatasetError};
use crate::annotation::{LabeledScan, ScanId};
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
}

/// A drive through a simulated street. Scans are made when they are read.
struct SimulatedStreet {
    description: DatasetDescription,
    street: Street,
    sensor: SensorModel,
    scan_ids: Vec<ScanId>,
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
        "{}scans {}\nturns per scan {}\n",
        street.provenance(&sensor),
        drive.n_scans,
        drive.turns_per_scan
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
    Box::new(SimulatedStreet { description, street, sensor, scan_ids })
}

impl Dataset for SimulatedStreet {
    fn description(&self) -> &DatasetDescription {
        &self.description
    }

    fn scan_ids(&self) -> &[ScanId] {
        &self.scan_ids
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        Ok(self.street.scan(&self.sensor, self.scan_ids[scan_idx].index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scans_are_the_turns_that_were_asked_for() {
        let drive = StreetDrive { street: StreetKind::MainRoad, seed: 3, n_scans: 4, turns_per_scan: 5 };
        let dataset = open_simulated_street("street", &drive);
        let turns: Vec<u32> = dataset.scan_ids().iter().map(|it| it.index).collect();
        assert_eq!(turns, [0, 5, 10, 15]);
        let scan = dataset.read_scan(2).unwrap();
        assert_eq!(scan.id, dataset.scan_ids()[2]);
        assert_eq!(scan, Street::new(StreetKind::MainRoad, 3).scan(&SensorModel::hdl_64e_s2(), 10));
    }

    #[test]
    fn the_checksum_changes_with_the_seed() {
        let drive = StreetDrive { street: StreetKind::MainRoad, seed: 3, n_scans: 4, turns_per_scan: 5 };
        let checksum =
            |drive: &StreetDrive| open_simulated_street("street", drive).description().checksum.clone();
        assert_ne!(checksum(&drive), checksum(&StreetDrive { seed: 4, ..drive.clone() }));
        assert_eq!(checksum(&drive), checksum(&drive.clone()));
    }
}
