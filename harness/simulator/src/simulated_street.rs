//! Streets of the simulator as a data set.

use std::path::Path;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use reports::vocabulary::named::named;
use scans::annotation::{LabeledScan, ScanId};
use scans::dataset::checksum::sha256;
use scans::dataset::labeled_ahead::keep_ahead;
use scans::dataset::simulation::Simulation;
use scans::dataset::text_file::read_text_file;
use scans::dataset::{AnnotatedClasses, Dataset, DatasetDescription, DatasetError, Listing};
use serde::{Deserialize, Serialize};

use super::rain::Rain;
use super::sensor::{EMBEDDED_SENSORS, SensorModel};
use super::street_conditions::StreetConditions;
use super::{Street, StreetKind};

/// Which street is driven through, and which scans are taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StreetDrive {
    /// Kind of the street.
    pub street: StreetKind,
    /// Seed of the street and of everything that happens on it.
    pub seed: u64,
    /// Number of scans.
    pub n_scans: u32,
    /// Turns of the sensor from one scan to the next; 1 takes every turn.
    pub turns_per_scan: u32,
    /// Scans of a street, after which the drive goes on in the street of the next seed; without it, all that a street has.
    pub scans_per_drive: Option<u32>,
    /// The sensor: the id of an embedded description, or the path of a file with one.
    pub sensor: String,
    /// Whether the street moves on while the sensor turns.
    #[serde(default)]
    pub shutter: Shutter,
    /// How hard it rains, in millimetres per hour; it is dry if this is left out.
    pub rain_mm_per_h: Option<f32>,
    /// How high the sensor is mounted above the road, in metres, instead of as its description has it.
    pub sensor_height_m: Option<f32>,
    /// Conditions of the street that are set instead of drawn.
    #[serde(default)]
    pub conditions: StreetConditions,
    /// Only points within this angle to either side of forward count as labelled, in degrees, as where people label the view
    /// of a camera. Without it, all points do.
    pub labeled_to_either_side_deg: Option<f32>,
}

named! {
    /// How a scan is taken.
    #[derive(Default)]
    pub enum Shutter {
        /// All at once, as in recordings whose motion was compensated.
        #[default]
        Instant = "instant",
        /// Beam by beam, while car and street move on.
        Rolling = "rolling",
    }
}

/// A drive through a simulated street. Scans are made when they are read.
struct SimulatedStreet {
    listing: Listing,
    drive: StreetDrive,
    sensor: SensorModel,
    // The seed of the street of each scan.
    seeds: Vec<u64>,
}

/// The format's name in tables and files.
const FORMAT: &str = "simulated-street";

/// Opens the drive as the data set called `id`. Where a street ends, or has given as many scans as it may, the drive goes on
/// in the street of the next seed.
pub fn open_simulated_street(id: &str, drive: &StreetDrive) -> Result<Box<dyn Dataset>, DatasetError> {
    let described = sensor_named(&drive.sensor)?;
    let height_above_road_m = drive.sensor_height_m.unwrap_or(described.height_above_road_m);
    let sensor = SensorModel { height_above_road_m, ..described };
    let (seeds, scan_ids) = scans_of(drive, &sensor);
    let per_drive = drive.scans_per_drive.map_or_else(String::new, |it| format!("scans per drive {it}\n"));
    let made_of = format!(
        "{}scans {}\nturns per scan {}\n{per_drive}shutter {:?}\nlabelled to either side {:?}\n",
        drive.draw(drive.seed).provenance(&sensor),
        drive.n_scans,
        drive.turns_per_scan,
        drive.shutter,
        drive.labeled_to_either_side_deg
    );
    let description = DatasetDescription {
        id: id.to_owned(),
        format: FORMAT.to_owned(),
        root: None,
        annotated: AnnotatedClasses::EveryObject,
        sensor_height_m: sensor.height_above_road_m,
        sensor: drive.sensor.clone(),
        licence: None,
        checksum: Some(sha256(&made_of)),
        simulation: Some(Simulation::of(drive)),
    };
    Ok(Box::new(SimulatedStreet {
        listing: Listing { description, scan_ids },
        drive: drive.clone(),
        sensor,
        seeds,
    }))
}

impl StreetDrive {
    /// The drive that a data set was simulated on; `None` for a recorded one.
    pub fn of(dataset: &DatasetDescription) -> Option<Self> {
        // Data sets of any other simulation were refused when they were opened.
        dataset.simulation.as_ref()?.read().ok()
    }

    /// The street of this seed, in the weather of the drive.
    fn draw(&self, seed: u64) -> Street {
        let dry = Street::under(self.street, seed, &self.conditions);
        match self.rain_mm_per_h {
            Some(mm_per_h) => dry.in_rain(Rain::new(mm_per_h)),
            None => dry,
        }
    }
}

impl Dataset for SimulatedStreet {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        // Drawing a street takes a fiftieth of the time of a scan of it.
        let street = self.drive.draw(self.seeds[scan_idx]);
        let turn = self.listing.scan_ids[scan_idx].index;
        let mut scan = match self.drive.shutter {
            Shutter::Instant => street.scan(&self.sensor, turn),
            Shutter::Rolling => street.rolling_scan(&self.sensor, turn),
        };
        if let Some(limit_deg) = self.drive.labeled_to_either_side_deg {
            keep_ahead(&mut scan, limit_deg);
        }
        Ok(scan)
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        let turns = f64::from(self.listing.scan_ids[scan_idx].index);
        Some((1e9 * turns / f64::from(self.sensor.turns_per_second)).round() as u64)
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        let street = self.drive.draw(self.seeds[scan_idx]);
        let pose = street.ego_pose(&self.sensor, self.listing.scan_ids[scan_idx].index);
        let [x, y, z, w] = pose.world_from_sensor_xyzw.map(f64::from);
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let at_m = Translation3::from(pose.position_m.map(f64::from));
        Ok(Some(Isometry3::from_parts(at_m, turn)))
    }
}

/// The seed of the street and the id of each scan.
fn scans_of(drive: &StreetDrive, sensor: &SensorModel) -> (Vec<u64>, Vec<ScanId>) {
    let (mut seeds, mut scan_ids) = (Vec::new(), Vec::new());
    let mut seed = drive.seed;
    while scan_ids.len() < drive.n_scans as usize {
        let street = drive.draw(seed);
        // A drive shorter than the step still has its first turn.
        let turns = (0..street.n_scans(sensor).max(1)).step_by(drive.turns_per_scan as usize);
        let n_missing = drive.n_scans as usize - scan_ids.len();
        let n_of_drive = drive.scans_per_drive.map_or(n_missing, |it| n_missing.min(it as usize));
        for index in turns.take(n_of_drive) {
            seeds.push(seed);
            scan_ids.push(ScanId { sequence: street.sequence(), index });
        }
        seed = seed.wrapping_add(1);
    }
    (seeds, scan_ids)
}

/// The embedded sensor with this id, or the one described in the file at this path.
pub fn sensor_named(id_or_path: &str) -> Result<SensorModel, DatasetError> {
    if let Some(sensor) = SensorModel::embedded(id_or_path) {
        return Ok(sensor);
    }
    let path = Path::new(id_or_path);
    if !path.exists() {
        let known = EMBEDDED_SENSORS.map(|(id, _)| id).join(", ");
        return Err(DatasetError::Usage(format!(
            "there is no sensor {id_or_path:?}: it is neither one of {known} nor a file"
        )));
    }
    let described = SensorModel::from_toml(&read_text_file(path)?);
    described.map_err(|error| DatasetError::Sensor { path: path.to_owned(), source: error.into() })
}

#[cfg(test)]
mod tests {
    use scans::annotation::{LabeledArea, PointRegion};

    use super::*;

    fn drive() -> StreetDrive {
        StreetDrive {
            street: StreetKind::MainRoad,
            seed: 3,
            n_scans: 4,
            turns_per_scan: 5,
            scans_per_drive: None,
            sensor: "hdl-64e-s2".to_owned(),
            shutter: Shutter::Instant,
            rain_mm_per_h: None,
            sensor_height_m: None,
            conditions: StreetConditions::default(),
            labeled_to_either_side_deg: None,
        }
    }

    fn open(drive: &StreetDrive) -> Box<dyn Dataset> {
        open_simulated_street("street", drive).unwrap()
    }

    #[test]
    fn sensors_are_embedded_or_described_in_a_file() {
        let n_points = |sensor: &str| {
            let drive = StreetDrive { sensor: sensor.to_owned(), ..drive() };
            open(&drive).read_scan(0).unwrap().cloud.len()
        };
        let file = tempfile::NamedTempFile::new().unwrap();
        let (_, description) = EMBEDDED_SENSORS.iter().find(|(id, _)| *id == "vlp-16").unwrap();
        std::fs::write(file.path(), description).unwrap();
        assert_eq!(n_points(file.path().to_str().unwrap()), n_points("vlp-16"));
        assert!(n_points("vlp-16") < n_points("hdl-64e-s2") / 2);
    }

    #[test]
    fn unknown_and_damaged_sensors_are_refused() {
        let refused = |sensor: &str| {
            let drive = StreetDrive { sensor: sensor.to_owned(), ..drive() };
            open_simulated_street("street", &drive).err().expect("no sensor")
        };
        let unknown = refused("hdl-65e");
        assert!(unknown.is_usage_error() && unknown.to_string().contains("hdl-64e-s2"), "{unknown}");
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "name = 3").unwrap();
        let damaged = refused(file.path().to_str().unwrap());
        assert!(
            damaged.is_usage_error() && damaged.to_string().contains("does not describe a sensor"),
            "{damaged}"
        );
    }

    #[test]
    fn a_rolling_scan_differs_from_an_instant_one() {
        let rolling = StreetDrive { shutter: Shutter::Rolling, ..drive() };
        let [rolling, instant] = [&rolling, &drive()].map(|it| open(it).read_scan(1).unwrap().cloud);
        assert!(rolling.positions_m().ne(instant.positions_m()));
        assert!(rolling.ring().is_some() && instant.ring().is_some());
        // A tenth of a second around its middle.
        let times_s = rolling.time_offset_s().unwrap();
        let first = times_s.iter().copied().fold(f32::INFINITY, f32::min);
        let last = times_s.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        assert!((-0.05..-0.045).contains(&first) && (0.045..0.05).contains(&last), "{first} {last}");
        assert_eq!(instant.time_offset_s(), None);
    }

    #[test]
    fn what_is_beside_a_limited_view_is_not_labelled() {
        let limited = StreetDrive { labeled_to_either_side_deg: Some(40.0), ..drive() };
        let scan = open(&limited).read_scan(0).unwrap();
        let everything = open(&drive()).read_scan(0).unwrap();
        assert!(everything.point_regions.iter().all(|&it| it == PointRegion::Labeled));
        assert_eq!(scan.cloud, everything.cloud);
        for (position_m, region) in scan.cloud.positions_m().zip(&scan.point_regions) {
            let is_ahead =
                position_m[0] > 0.0 && position_m[1].abs() < position_m[0] * 40.0_f32.to_radians().tan();
            assert_eq!(is_ahead, *region == PointRegion::Labeled, "{position_m:?}");
        }
    }

    #[test]
    fn what_the_limit_cuts_keeps_its_points_and_what_is_beside_is_not_annotated() {
        let limited = StreetDrive { labeled_to_either_side_deg: Some(40.0), ..drive() };
        let scan = open(&limited).read_scan(0).unwrap();
        let everything = open(&drive()).read_scan(0).unwrap();
        let is_ahead = |point_idx: &u32| scan.point_regions[*point_idx as usize] == PointRegion::Labeled;
        let mut ahead = everything.annotations.clone();
        ahead.retain(|it| it.point_indices.iter().any(is_ahead));
        assert_eq!(scan.annotations, ahead);
        assert!(ahead.len() < everything.annotations.len() / 2);
        let is_cut = |it: &&scans::annotation::Annotation| !it.point_indices.iter().all(is_ahead);
        assert!(scan.annotations.iter().any(|it| is_cut(&it)), "something is cut");
        assert_eq!(scan.labeled_area, LabeledArea::Ahead { to_either_side_deg: 40.0 });
    }

    #[test]
    fn scans_are_the_turns_that_were_asked_for() {
        let dataset = open(&drive());
        let turns: Vec<u32> = dataset.scan_ids().iter().map(|it| it.index).collect();
        assert_eq!(turns, [0, 5, 10, 15]);
        let scan = dataset.read_scan(2).unwrap();
        assert_eq!(scan.id, dataset.scan_ids()[2]);
        assert_eq!(scan, Street::new(StreetKind::MainRoad, 3).scan(&SensorModel::hdl_64e_s2(), 10));
    }

    #[test]
    fn a_long_drive_goes_on_in_the_next_street() {
        let long = StreetDrive { n_scans: 6, turns_per_scan: 150, ..drive() };
        let dataset = open(&long);
        let ids: Vec<String> = dataset.scan_ids().iter().map(ToString::to_string).collect();
        let of_street = |seed: u64| (0..3).map(move |scan| format!("main-road-{seed}/{:06}", 150 * scan));
        assert_eq!(ids, of_street(3).chain(of_street(4)).collect::<Vec<_>>());
        let next = Street::new(StreetKind::MainRoad, 4).scan(&SensorModel::hdl_64e_s2(), 150);
        assert_eq!(dataset.read_scan(4).unwrap(), next);
    }

    #[test]
    fn many_short_drives_take_a_few_scans_of_each_seed() {
        let short = StreetDrive { n_scans: 5, turns_per_scan: 150, scans_per_drive: Some(2), ..drive() };
        let dataset = open(&short);
        let ids: Vec<String> = dataset.scan_ids().iter().map(ToString::to_string).collect();
        let expected = ["3/000000", "3/000150", "4/000000", "4/000150", "5/000000"];
        assert_eq!(ids, expected.map(|it| format!("main-road-{it}")));
        assert_eq!([0, 1, 2].map(|it| dataset.scan_time_ns(it).unwrap()), [0, 15_000_000_000, 0]);
        let of_second = Street::new(StreetKind::MainRoad, 4).scan(&SensorModel::hdl_64e_s2(), 150);
        assert_eq!(dataset.read_scan(3).unwrap(), of_second);
        // Without the limit, checksums are what they were before there was one.
        let checksum = |drive: &StreetDrive| open(drive).description().checksum.clone();
        assert_ne!(checksum(&short), checksum(&StreetDrive { scans_per_drive: None, ..short.clone() }));
    }

    #[test]
    fn the_sensor_is_mounted_as_high_as_said() {
        let high = open(&StreetDrive { sensor_height_m: Some(2.5), ..drive() });
        assert_eq!(
            (high.description().sensor_height_m, open(&drive()).description().sensor_height_m),
            (2.5, 1.73)
        );
        let lowest_m = |dataset: &dyn Dataset| {
            let mut heights_m = dataset.read_scan(0).unwrap().cloud.z_m().to_vec();
            heights_m.sort_by(f32::total_cmp);
            heights_m[heights_m.len() / 10]
        };
        let lower_by_m = lowest_m(&*open(&drive())) - lowest_m(&*high);
        assert!((0.6..0.95).contains(&lower_by_m), "{lower_by_m}");
        assert_ne!(high.description().checksum, open(&drive()).description().checksum);
    }

    #[test]
    fn the_checksum_changes_with_the_seed_and_the_rain() {
        let checksum = |drive: &StreetDrive| open(drive).description().checksum.clone();
        assert_ne!(checksum(&drive()), checksum(&StreetDrive { seed: 4, ..drive() }));
        assert_ne!(checksum(&drive()), checksum(&StreetDrive { rain_mm_per_h: Some(10.0), ..drive() }));
        assert_eq!(checksum(&drive()), checksum(&drive()));
    }
}
