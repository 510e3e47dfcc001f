//! Streets that are simulated under one condition after another.

use nalgebra::Isometry3;
use scans::annotation::LabeledScan;
use scans::dataset::checksum::sha256;
use scans::dataset::simulation::Simulation;
use scans::dataset::{Dataset, DatasetDescription, DatasetError, Listing};
use serde::Serialize;
use simulator::StreetKind;
use simulator::simulated_street::{Shutter, StreetDrive, open_simulated_street};
use simulator::street_conditions::StreetConditions;

/// One condition: a change of the standard drive.
#[derive(Debug, Clone)]
pub struct Condition {
    /// Name of the group of conditions.
    pub group: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Whether the shipped trees were trained on other drives under it.
    pub trained: bool,
    change: fn(&mut StreetDrive),
}

/// Number of turns of the sensor from one scan to the next.
const TURNS_PER_SCAN: u32 = 30;

/// Every condition, in the order of the table. Nothing is tuned on them: detectors are told only the sensor and its height.
/// The trees of `hierarchical`, its rivals and the vehicle model of clusters were trained on other drives under some of
/// them, rain of 20 mm/h and hills of 10 % among these. No model was trained with the new sensors, and they have no shipped
/// density curve: it is learned from five of their scans.
pub const CONDITIONS: &[Condition] = &[
    trained("standard", "hdl-64e-s2, 1.73 m", |_| {}),
    unseen("road", "level", |it| it.conditions = even(0.0)),
    unseen("road", "5 % even", |it| it.conditions = even(0.05)),
    unseen("road", "10 % even", |it| it.conditions = even(0.10)),
    trained("road", "hills to 5 %", |it| it.conditions = hills(0.05)),
    trained("road", "hills to 10 %", |it| it.conditions = hills(0.10)),
    unseen("kerb", "3 cm", |it| it.conditions.kerb_height_m = Some(0.03)),
    unseen("kerb", "15 cm", |it| it.conditions.kerb_height_m = Some(0.15)),
    unseen("kerb", "25 cm", |it| it.conditions.kerb_height_m = Some(0.25)),
    unseen("truck ahead", "3.0 m", |it| it.conditions.truck_ahead_height_m = Some(3.0)),
    trained("trees", "avenue", |it| it.conditions.avenue = true),
    unseen("overhead", "bridges", |it| it.conditions.bridges = true),
    unseen("overhead", "wires", |it| it.conditions.wires = true),
    unseen("overhead", "garages", |it| it.conditions.garages = true),
    trained("traffic", "haulage", |it| it.conditions.haulage = true),
    trained("traffic", "North American", |it| it.conditions.north_american = true),
    trained("mounted at", "1.0 m", |it| it.sensor_height_m = Some(1.0)),
    unseen("mounted at", "2.5 m", |it| it.sensor_height_m = Some(2.5)),
    trained("sensor", "hdl-32e", |it| "hdl-32e".clone_into(&mut it.sensor)),
    trained("sensor", "vlp-16", |it| "vlp-16".clone_into(&mut it.sensor)),
    trained("sensor", "os1-128", |it| "os1-128".clone_into(&mut it.sensor)),
    trained("sensor", "argoverse2", |it| "argoverse2".clone_into(&mut it.sensor)),
    unseen("new sensor", "xt32", |it| "xt32".clone_into(&mut it.sensor)),
    unseen("new sensor", "pandar64", |it| "pandar64".clone_into(&mut it.sensor)),
    unseen("new sensor", "os0-128", |it| "os0-128".clone_into(&mut it.sensor)),
    trained("weather", "rain, 10 mm/h", |it| it.rain_mm_per_h = Some(10.0)),
    trained("weather", "rain, 50 mm/h", |it| it.rain_mm_per_h = Some(50.0)),
    unseen("shutter", "rolling", |it| it.shutter = Shutter::Rolling),
];

const fn trained(group: &'static str, name: &'static str, change: fn(&mut StreetDrive)) -> Condition {
    Condition { group, name, trained: true, change }
}

const fn unseen(group: &'static str, name: &'static str, change: fn(&mut StreetDrive)) -> Condition {
    Condition { group, name, trained: false, change }
}

fn even(gradient: f32) -> StreetConditions {
    StreetConditions { gradient: Some(gradient), ..StreetConditions::default() }
}

fn hills(greatest: f32) -> StreetConditions {
    StreetConditions { hill_gradient: Some(greatest), ..StreetConditions::default() }
}

impl Condition {
    /// The name of its data set.
    pub fn id(&self) -> String {
        format!("{}: {}", self.group, self.name)
    }

    /// The drives under the condition, one through each kind of street.
    pub fn drives(&self, seed: u64, n_scans: u32) -> Vec<StreetDrive> {
        StreetKind::ALL.map(|street| self.drive(street, seed, n_scans)).to_vec()
    }

    /// These drives as one data set, of `n_scans` scans each.
    ///
    /// # Errors
    ///
    /// [`DatasetError`] if they cannot be made.
    pub fn open(&self, seed: u64, n_scans: u32) -> Result<Box<dyn Dataset>, DatasetError> {
        Ok(Box::new(JoinedDrives::open(&self.id(), self.drives(seed, n_scans))?))
    }

    fn drive(&self, street: StreetKind, seed: u64, n_scans: u32) -> StreetDrive {
        let mut drive = StreetDrive {
            street,
            seed,
            n_scans,
            turns_per_scan: TURNS_PER_SCAN,
            scans_per_drive: None,
            sensor: "hdl-64e-s2".to_owned(),
            shutter: Shutter::Instant,
            rain_mm_per_h: None,
            sensor_height_m: None,
            conditions: StreetConditions::default(),
            labeled_to_either_side_deg: None,
        };
        (self.change)(&mut drive);
        drive
    }
}

/// Several drives under the same condition as one data set.
struct JoinedDrives {
    listing: Listing,
    drives: Vec<Box<dyn Dataset>>,
    // Of each scan the drive, and the index in it.
    indices: Vec<[usize; 2]>,
}

/// Inputs of the simulation of such a data set.
#[derive(Serialize)]
struct SimulatedDrives {
    drives: Vec<StreetDrive>,
}

impl JoinedDrives {
    /// Opens `drives`, at least one, all with one sensor at one height, as the data set `id`.
    fn open(id: &str, drives: Vec<StreetDrive>) -> Result<Self, DatasetError> {
        let opened: Vec<Box<dyn Dataset>> = drives
            .iter()
            .map(|it| open_simulated_street(it.street.name(), it))
            .collect::<Result<_, DatasetError>>()?;
        let checksums: Vec<&str> =
            opened.iter().filter_map(|it| it.description().checksum.as_deref()).collect();
        let description = DatasetDescription {
            id: id.to_owned(),
            checksum: Some(sha256(checksums.join("\n").as_str())),
            simulation: Some(Simulation::of(&SimulatedDrives { drives })),
            ..opened[0].description().clone()
        };
        let indices = opened
            .iter()
            .enumerate()
            .flat_map(|(drive_idx, it)| (0..it.scan_ids().len()).map(move |scan_idx| [drive_idx, scan_idx]));
        let indices = indices.collect();
        let scan_ids = opened.iter().flat_map(|it| it.scan_ids().to_vec()).collect();
        Ok(Self { listing: Listing { description, scan_ids }, drives: opened, indices })
    }

    fn drive_and_idx(&self, scan_idx: usize) -> (&dyn Dataset, usize) {
        let [drive_idx, in_drive_idx] = self.indices[scan_idx];
        (&*self.drives[drive_idx], in_drive_idx)
    }
}

impl Dataset for JoinedDrives {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let (drive, in_drive_idx) = self.drive_and_idx(scan_idx);
        drive.read_scan(in_drive_idx)
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        let (drive, in_drive_idx) = self.drive_and_idx(scan_idx);
        drive.scan_time_ns(in_drive_idx)
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        let (drive, in_drive_idx) = self.drive_and_idx(scan_idx);
        drive.world_from_sensor(in_drive_idx)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn opened(name: &str) -> Box<dyn Dataset> {
        CONDITIONS.iter().find(|it| it.name == name).unwrap().open(5, 2).unwrap()
    }

    #[test]
    fn conditions_have_names_of_their_own_and_make_drives_that_can_be() {
        let names: BTreeSet<_> = CONDITIONS.iter().map(Condition::id).collect();
        assert_eq!(names.len(), CONDITIONS.len());
        for condition in CONDITIONS {
            for drive in condition.drives(1, 1) {
                assert_eq!(drive.conditions.check(), Ok(()), "{}", condition.name);
            }
            let dataset = condition.open(1, 1).unwrap();
            let drives: BTreeSet<&str> = dataset.scan_ids().iter().map(|it| it.sequence.as_str()).collect();
            assert_eq!((dataset.scan_ids().len(), drives.len()), (3, 3), "{}", condition.name);
        }
    }

    #[test]
    fn every_scan_is_that_of_its_drive() {
        let dataset = opened("vlp-16");
        assert_eq!((dataset.description().sensor.as_str(), dataset.scan_ids().len()), ("vlp-16", 6));
        for (scan_idx, id) in dataset.scan_ids().iter().enumerate() {
            assert_eq!(dataset.read_scan(scan_idx).unwrap().id, *id);
        }
        assert!(dataset.description().is_simulated());
    }

    #[test]
    fn conditions_are_felt() {
        let standard = opened("hdl-64e-s2, 1.73 m");
        let cloud = standard.read_scan(0).unwrap().cloud;
        for other in ["10 % even", "25 cm", "3.0 m", "1.0 m", "vlp-16", "rain, 50 mm/h", "rolling"] {
            let other = opened(other);
            assert_ne!(other.description().checksum, standard.description().checksum);
            assert_ne!(other.read_scan(0).unwrap().cloud, cloud);
        }
    }
}
