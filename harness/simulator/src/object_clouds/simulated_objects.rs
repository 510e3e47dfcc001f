//! Simulated objects by name: `objects-around`, `objects-air`, `objects-approach`, and one for each of four rotating
//! sensors.

use detector::PointCloud;
use reports::vocabulary::partial_class::PartialClass;
use scans::dataset::DatasetError;
use scans::dataset::simulation::Simulation;
use scans::object_cloud::ObjectCloud;
use scans::object_cloud::growing_cloud::{GrowingCloud, Moment};
use scans::object_cloud::object_cloud_set::{ObjectCloudSet, ObjectSetDescription};
use serde::{Deserialize, Serialize};

use super::approach::{ApproachParams, Drive, approached};
use super::around::{scanned_around, survey_scanner};
use super::drawn_object::{ObjectNumber, StreamUse};
use super::from_the_air::scanned_from_the_air;
use super::lone_object::LoneObject;
use super::planar_scanner::PlanarScanner;
use super::single_scan::{RANGES_M, scanned_once};
use crate::sensor::SensorModel;
use crate::street::SIMULATOR_VERSION;

/// The names of all simulated sets of objects.
pub const OBJECT_SETS: [&str; 7] = [
    "objects-around",
    "objects-hdl-64e-s2",
    "objects-hdl-32e",
    "objects-vlp-16",
    "objects-os1-128",
    "objects-air",
    "objects-approach",
];

/// An object with fewer points is looked at again: from nearer, or on another drive.
pub const LEAST_POINTS: usize = 20;

/// Number of drives that are tried at most.
const N_DRIVES: u32 = 20;

/// Purpose of objects. No object of one part is in another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObjectPart {
    /// Models are trained on them.
    Training,
    /// Choices are made with them.
    Development,
    /// Results are measured on them, and nothing else.
    Judging,
}

/// Parameters of a set of simulated objects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectSimulation {
    /// One of [`OBJECT_SETS`].
    pub set: String,
    /// Their purpose.
    pub part: ObjectPart,
    /// How many of each class.
    pub n_per_class: u32,
    /// The simulator that made them.
    pub simulator_version: u32,
}

/// Simulated objects, made when they are read.
#[derive(Debug)]
pub struct SimulatedObjects {
    description: ObjectSetDescription,
    classes: Vec<PartialClass>,
    part: ObjectPart,
    n_per_class: u32,
    viewing: Viewing,
}

/// How objects are looked at.
#[derive(Debug)]
enum Viewing {
    Around(SensorModel),
    Once(SensorModel),
    FromTheAir,
    Approach(PlanarScanner, ApproachParams),
}

impl ObjectPart {
    /// All, in the order in which they are used.
    pub const ALL: [Self; 3] = [Self::Training, Self::Development, Self::Judging];

    /// The seed of its objects.
    pub fn seed(self) -> u64 {
        match self {
            Self::Training => 1,
            Self::Development => 2,
            Self::Judging => 3,
        }
    }
}

/// The simulated objects of the set `name`, `n_per_class` of each of [`PartialClass::ALL`], class by class.
pub fn open_simulated_objects(
    name: &str,
    part: ObjectPart,
    n_per_class: u32,
) -> Result<SimulatedObjects, DatasetError> {
    let unknown = || DatasetError::unknown_dataset(name, &OBJECT_SETS.map(str::to_owned));
    let viewing = match name.strip_prefix("objects-").ok_or_else(unknown)? {
        "around" => Viewing::Around(survey_scanner()),
        "air" => Viewing::FromTheAir,
        "approach" => Viewing::Approach(PlanarScanner::embedded(), ApproachParams::shipped()),
        _ if !OBJECT_SETS.contains(&name) => return Err(unknown()),
        sensor => Viewing::Once(SensorModel::embedded(sensor).ok_or_else(unknown)?),
    };
    let asked_for =
        ObjectSimulation { set: name.to_owned(), part, n_per_class, simulator_version: SIMULATOR_VERSION };
    let simulation = Some(Simulation::of(&asked_for));
    let description = ObjectSetDescription { id: name.to_owned(), root: None, simulation };
    let classes = PartialClass::ALL.into_iter().flat_map(|it| std::iter::repeat_n(it, n_per_class as usize));
    Ok(SimulatedObjects { description, classes: classes.collect(), part, n_per_class, viewing })
}

impl ObjectCloudSet for SimulatedObjects {
    fn description(&self) -> &ObjectSetDescription {
        &self.description
    }

    fn classes(&self) -> &[PartialClass] {
        &self.classes
    }

    fn read(&self, object_idx: usize) -> Result<GrowingCloud, DatasetError> {
        let number = self.number(object_idx);
        let object = LoneObject::new(&number.draw());
        let (cloud, moments) = match &self.viewing {
            Viewing::Around(scanner) => scanned_around(&object, number, scanner),
            Viewing::Once(sensor) => well_scanned(&object, number, sensor),
            Viewing::FromTheAir => scanned_from_the_air(&object, number),
            Viewing::Approach(scanner, params) => {
                let (_, cloud, moments) = well_approached(&object, number, scanner, params);
                (cloud, moments)
            }
        };
        let id = format!("{}-{:04}", number.class, number.number);
        let whole = ObjectCloud { id, class: number.class, cloud };
        Ok(GrowingCloud { whole, extents_m: Some(object.extents_m), moments })
    }
}

impl SimulatedObjects {
    /// How the vehicle drives toward object `object_idx`; `None` in a set without a vehicle.
    pub fn drive(&self, object_idx: usize) -> Option<Drive> {
        let Viewing::Approach(scanner, params) = &self.viewing else { return None };
        let number = self.number(object_idx);
        Some(well_approached(&LoneObject::new(&number.draw()), number, scanner, params).0)
    }

    fn number(&self, object_idx: usize) -> ObjectNumber {
        let number = object_idx as u32 % self.n_per_class;
        ObjectNumber { seed: self.part.seed(), class: self.classes[object_idx], number }
    }
}

/// The object in one scan, at the distance that its number says, or nearer if it has fewer than [`LEAST_POINTS`] there.
fn well_scanned(
    object: &LoneObject,
    number: ObjectNumber,
    sensor: &SensorModel,
) -> (PointCloud, Vec<Moment>) {
    let farthest = number.number as usize % RANGES_M.len();
    let mut scans = RANGES_M[..=farthest].iter().rev().map(|it| scanned_once(object, number, sensor, *it));
    let is_well_seen = |it: &(PointCloud, Moment)| it.0.len() >= LEAST_POINTS;
    let nearest = || scanned_once(object, number, sensor, RANGES_M[0]);
    let (cloud, moment) = scans.find(is_well_seen).unwrap_or_else(nearest);
    (cloud, vec![moment])
}

/// The first drive on which the object gets [`LEAST_POINTS`], or else the one with most points; its points and moments.
fn well_approached(
    object: &LoneObject,
    number: ObjectNumber,
    scanner: &PlanarScanner,
    params: &ApproachParams,
) -> (Drive, PointCloud, Vec<Moment>) {
    let mut rng = number.random_stream(StreamUse::Viewpoint);
    let mut try_once = || {
        let drive = params.drive(object, scanner, &mut rng);
        let (cloud, moments) = approached(object, number, scanner, &drive, params);
        (drive, cloud, moments)
    };
    let mut best = try_once();
    for _ in 1..N_DRIVES {
        if best.1.len() >= LEAST_POINTS {
            break;
        }
        let next = try_once();
        if next.1.len() > best.1.len() {
            best = next;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use scans::conversion::object_folder_writer::write_object_folder;
    use scans::object_cloud::class_folders::open_class_folders;
    use sha2::{Digest as _, Sha256};

    #[test]
    fn every_name_opens_its_objects_and_others_are_refused() {
        for name in OBJECT_SETS {
            let objects = open_simulated_objects(name, ObjectPart::Training, 2).unwrap();
            assert!(objects.description().is_simulated() && objects.description().id == name);
            assert_eq!(objects.classes().len(), 10);
            assert_eq!(objects.drive(0).is_some(), name == "objects-approach");
        }
        for name in ["objects", "objects-", "objects-argoverse2", "street-narrow", "around"] {
            let error = open_simulated_objects(name, ObjectPart::Training, 2).expect_err("no such set");
            assert!(error.is_usage_error() && error.to_string().contains("objects-around"), "{error}");
        }
    }

    #[test]
    fn every_object_is_seen_and_is_not_seen_in_another_part() {
        for name in OBJECT_SETS {
            let parts = ObjectPart::ALL.map(|part| open_simulated_objects(name, part, 3).unwrap());
            for object_idx in 0..15 {
                let [one, two, three] = parts.each_ref().map(|it| it.read(object_idx).unwrap());
                for it in [&one, &two, &three] {
                    assert!(it.whole.cloud.len() >= LEAST_POINTS, "{name} {}", it.whole.id);
                    assert_eq!(it.moments.last().map(|it| it.n_points), Some(it.whole.cloud.len()));
                    assert!(it.whole.cloud.z_m().iter().all(|z_m| *z_m > -0.1), "{name} {}", it.whole.id);
                }
                assert_ne!(one.whole.cloud, two.whole.cloud);
                assert_ne!(two.whole.cloud, three.whole.cloud);
                assert_eq!(one, parts[0].read(object_idx).unwrap(), "{name}");
            }
        }
    }

    #[test]
    fn what_is_written_is_read_back_to_the_bit_and_still_simulated() {
        let parent = tempfile::tempdir().unwrap();
        let [one, again] = ["one", "again"].map(|it| parent.path().join(it));
        let objects = open_simulated_objects("objects-approach", ObjectPart::Judging, 2).unwrap();
        write_object_folder(&objects, &one).unwrap();
        write_object_folder(&objects, &again).unwrap();
        for name in ["objects.json", "tree/tree-0001.npy"] {
            assert_eq!(std::fs::read(one.join(name)).unwrap(), std::fs::read(again.join(name)).unwrap());
        }
        let read = open_class_folders(&one, None).unwrap();
        assert_eq!(read.description().simulation, objects.description().simulation);
        let mut written: Vec<GrowingCloud> = (0..10).map(|it| objects.read(it).unwrap()).collect();
        for object_idx in 0..10 {
            let mut found = read.read(object_idx).unwrap();
            found.whole.id = found.whole.id[found.whole.id.find('/').unwrap() + 1..].replace(".npy", "");
            let index = written.iter().position(|it| *it == found);
            written.remove(index.unwrap_or_else(|| panic!("{} was not written", found.whole.id)));
        }
        assert!(written.is_empty());
    }

    fn digest_of(name: &str) -> String {
        let objects = open_simulated_objects(name, ObjectPart::Training, 2).unwrap();
        let mut digest = Sha256::new();
        for object_idx in 0..10 {
            let object = objects.read(object_idx).unwrap();
            let points = object.whole.cloud.positions_m().zip(object.whole.cloud.intensity());
            for ([x, y, z], intensity) in points {
                digest.update([x, y, z, *intensity].map(f32::to_le_bytes).concat());
            }
            for moment in &object.moments {
                digest.update((moment.n_points as u64).to_le_bytes());
            }
        }
        let [a, b, c, d, ..] = digest.finalize()[..] else { panic!("a digest has 32 bytes") };
        format!("{:08x}", u32::from_be_bytes([a, b, c, d]))
    }

    /// If these change, so do the objects that models are trained on, and with them the results.
    #[test]
    fn objects_are_the_same_bytes_on_every_machine() {
        let names = ["objects-around", "objects-vlp-16", "objects-air", "objects-approach"];
        assert_eq!(names.map(digest_of), ["3583a52b", "51de4456", "f85f1123", "f47c80f5"]);
    }
}
