//! Argoverse 2's folders.
//!
//! ```text
//! LOG/sensors/lidar/TIMESTAMP.feather          the sweeps, named after nanoseconds
//! LOG/annotations.feather                      logs without it are the test split and left out
//! LOG/city_SE3_egovehicle.feather              optional: poses
//! LOG/calibration/egovehicle_SE3_sensor.feather   optional: where the lidars are
//! ```
//!
//! Logs lie in the folder itself, or in `train`, `val` or `test`, with or without `sensor` above.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{Isometry3, Translation3, Vector3};
use reports::vocabulary::class::AnnotationClass;

use super::log_truth::{ANNOTATIONS, LogTruth, survey_classes};
use crate::annotation::{LabeledScan, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::class_table::{ClassReader, ClassRules, UnknownClasses};
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::feather::FeatherTable;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::official::OfficialScan;
use crate::dataset::on_disk::{entries_of, has_extension, is_there, name_of};
use crate::dataset::points_of_boxes::assign_points_in_boxes;
use crate::dataset::positioned_points::PositionedPoints;
use crate::dataset::scan_sizes::ScanSizes;
use crate::dataset::source::DatasetSource;
use crate::dataset::{Dataset, DatasetError, Listing, labels_without_scan};

const SWEEPS: &str = "sensors/lidar";

/// Folders of logs below the folder of the data set.
const SPLITS: [&str; 7] = [".", "train", "val", "test", "sensor/train", "sensor/val", "sensor/test"];

/// Height of the point between the lidars above the road: that above the rear axle, and the axle's.
pub const ARGOVERSE2_SENSOR_HEIGHT_M: f32 = 1.95;

/// Two VLP-32C, one upside down on the other.
pub const ARGOVERSE2_SENSOR: &str = "argoverse2";

/// The labelled classes, where the car may drive and five metres beside it.
pub const ARGOVERSE2_CLASSES: [AnnotationClass; 12] = [
    AnnotationClass::Car,
    AnnotationClass::Truck,
    AnnotationClass::Bus,
    AnnotationClass::Pedestrian,
    AnnotationClass::SittingPerson,
    AnnotationClass::Cyclist,
    AnnotationClass::ParkedCycle,
    AnnotationClass::Tram,
    AnnotationClass::Trailer,
    AnnotationClass::Animal,
    AnnotationClass::Pole,
    AnnotationClass::StreetFurniture,
];

/// An open data set: it holds the names of sweeps, and the boxes of the log that was last read from.
#[derive(Debug)]
struct SensorLogs {
    // Invariant: `scan_ids` and `sweeps` have the same length and order.
    listing: Listing,
    sweeps: Vec<Sweep>,
    classes: ClassRules,
    last_truth: Mutex<Option<(PathBuf, Arc<LogTruth>)>>,
}

#[derive(Debug)]
struct Sweep {
    log: PathBuf,
    // Its time, which names its file.
    name: String,
    time_ns: i64,
}

impl Sweep {
    fn path(&self) -> PathBuf {
        self.log.join(SWEEPS).join(format!("{}.feather", self.name))
    }
}

/// Whether logs of Argoverse 2 lie in `folder`.
pub fn is_argoverse2(folder: &Path) -> bool {
    !logs_below(folder).is_empty()
}

/// Opens the folder of `source`: all logs that have annotations, or only those of `sequences`.
///
/// No sweep and no label is read.
pub fn open_argoverse2(mut source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let sequences = source.parts.sequences.take();
    let (mut scan_ids, mut sweeps, mut checksum) = (Vec::new(), Vec::new(), DatasetChecksum::default());
    let (mut found, mut sizes) = (BTreeSet::new(), ScanSizes::default());
    for log in logs_below(&source.path) {
        let name = name_of(&log);
        if !is_there(&log.join(ANNOTATIONS)) || sequences.as_ref().is_some_and(|it| !it.contains(&name)) {
            continue;
        }
        checksum.add_file(&format!("{name}/{ANNOTATIONS}"), &log.join(ANNOTATIONS))?;
        for (index, time_ns) in (0..).zip(sweep_times(&log.join(SWEEPS))?) {
            let sweep = Sweep { log: log.clone(), name: time_ns.to_string(), time_ns };
            let path = format!("{name}/{SWEEPS}/{}.feather", sweep.name);
            checksum.add_scan(&path, sizes.n_bytes_of(&sweep.path()));
            scan_ids.push(ScanId { sequence: name.clone(), index });
            sweeps.push(sweep);
        }
        found.insert(name);
    }
    if let Some(missing) = sequences.iter().flatten().find(|it| !found.contains(*it)) {
        return Err(DatasetError::missing_selected(&source.path.join(missing).join(ANNOTATIONS)));
    }
    if scan_ids.is_empty() {
        let labels = source.path.join("*/annotations.feather");
        return Err(DatasetError::unlabeled(&source.path, &labels));
    }
    sizes.check(&source.path, source.damage)?;
    let classes = source.classes.clone();
    let description = source.describe(DatasetFormat::Argoverse2, checksum.finish());
    let listing = Listing { description, scan_ids };
    Ok(Box::new(SensorLogs { listing, sweeps, classes, last_truth: Mutex::new(None) }))
}

impl Dataset for SensorLogs {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let sweep = &self.sweeps[scan_idx];
        let truth = self.truth_of(&sweep.log)?;
        let points = read_sweep(&sweep.path(), &truth.car_from_sensor_m)?;
        let mut annotations = truth.annotations.get(&sweep.time_ns).cloned().unwrap_or_default();
        assign_points_in_boxes(points.cloud(), &mut annotations);
        Ok(points.labeled_everywhere(self.listing.scan_ids[scan_idx].clone(), annotations))
    }

    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        let sweeps: BTreeSet<(&Path, i64)> =
            self.sweeps.iter().map(|it| (it.log.as_path(), it.time_ns)).collect();
        let mut names = Vec::new();
        for log in self.logs() {
            let truth = self.truth_of(log)?;
            let without_sweep = truth.annotations.keys().filter(|it| !sweeps.contains(&(log, **it)));
            names.extend(without_sweep.map(|time_ns| format!("{time_ns} of {log:?}")));
        }
        Ok(labels_without_scan(&names))
    }

    fn file_name(&self, scan_idx: usize) -> Option<&str> {
        Some(&self.sweeps[scan_idx].name)
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        u64::try_from(self.sweeps[scan_idx].time_ns).ok()
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        let sweep = &self.sweeps[scan_idx];
        Ok(self.truth_of(&sweep.log)?.world_from_sensor.get(&sweep.time_ns).copied())
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        let Sweep { log, time_ns, .. } = &self.sweeps[scan_idx];
        Ok(ForeignFrame::Car {
            log_id: self.scan_ids()[scan_idx].sequence.clone(),
            timestamp_ns: *time_ns,
            car_from_sensor: Translation3::from(self.truth_of(log)?.car_from_sensor_m).into(),
        })
    }

    fn official_scan(&self, scan_idx: usize) -> Result<Option<OfficialScan>, DatasetError> {
        let Sweep { log, time_ns, .. } = &self.sweeps[scan_idx];
        let objects = self.truth_of(log)?.objects.get(time_ns).cloned().unwrap_or_default();
        Ok(Some(OfficialScan { objects, origin_m: [0.0; 3] }))
    }
}

impl SensorLogs {
    /// The unknown classes of all logs whose annotations can be read, so that one error names them all.
    fn all_unknown_classes(&self) -> UnknownClasses {
        let mut classes = ClassReader::new(&self.classes, &[]);
        for log in self.logs() {
            // A log that cannot be read fails when its scans are read.
            let _ = survey_classes(log, &mut classes);
        }
        classes.unknown().clone()
    }

    fn logs(&self) -> BTreeSet<&Path> {
        self.sweeps.iter().map(|it| it.log.as_path()).collect()
    }

    fn truth_of(&self, log: &Path) -> Result<Arc<LogTruth>, DatasetError> {
        let last = || self.last_truth.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((path, truth)) = last().as_ref()
            && path == log
        {
            return Ok(Arc::clone(truth));
        }
        let mut classes = ClassReader::new(&self.classes, &[]);
        let truth = Arc::new(LogTruth::read(log, &mut classes)?);
        if !classes.unknown().is_empty() {
            self.all_unknown_classes().refuse(&self.listing.description.id)?;
        }
        *last() = Some((log.to_path_buf(), Arc::clone(&truth)));
        Ok(truth)
    }
}

/// The columns of a sweep with the laser of a point, and its time after that of the sweep, in nanoseconds.
const LASER: &str = "laser_number";
const OFFSET: &str = "offset_ns";

fn read_sweep(path: &Path, car_from_sensor_m: &Vector3<f64>) -> Result<PositionedPoints, DatasetError> {
    let mut table = FeatherTable::read_some(path, &["x", "y", "z", "intensity"], &[LASER, OFFSET])?;
    let damaged = |problem| DatasetError::Damaged { path: path.to_path_buf(), problem };
    let mut take = |name: &str| table.take_numbers(name).map_err(damaged);
    let (x, y, z, intensity) = (take("x")?, take("y")?, take("z")?, take("intensity")?);
    let n_points = x.len();
    if [&y, &z, &intensity].iter().any(|it| it.len() != n_points) {
        return Err(damaged("has columns of different lengths".to_owned()));
    }
    let mut points = PositionedPoints::with_capacity(n_points);
    for point_idx in 0..n_points {
        let position_m = Vector3::new(x[point_idx], y[point_idx], z[point_idx]) - car_from_sensor_m;
        // A byte, scaled to the range of other sensors.
        let intensity = intensity[point_idx] as f32 / 255.0;
        points.push(position_m.into(), intensity).map_err(damaged)?;
    }
    let mut take_if_there = |name: &str| table.take_integers(name).unwrap_or_default();
    let lasers: Vec<f64> = take_if_there(LASER).into_iter().map(|it| it as f64).collect();
    let offsets_s: Vec<f64> = take_if_there(OFFSET).into_iter().map(|it| it as f64 * 1e-9).collect();
    points.take_rings(&lasers);
    points.take_time_offsets_s(&offsets_s);
    points.none_or_some(path)
}

/// The folders of logs in the splits of `folder`, or `folder` itself.
fn logs_below(folder: &Path) -> Vec<PathBuf> {
    let is_log = |path: &Path| path.join(SWEEPS).is_dir();
    if is_log(folder) {
        return vec![folder.to_path_buf()];
    }
    let mut logs = Vec::new();
    for split in SPLITS {
        let entries = entries_of(&folder.join(split)).unwrap_or_default();
        logs.extend(entries.into_iter().filter(|path| is_log(path)));
    }
    logs.sort();
    logs
}

fn sweep_times(folder: &Path) -> Result<Vec<i64>, DatasetError> {
    let sweeps = entries_of(folder)?.into_iter().filter(|it| has_extension(it, "feather"));
    let time_ns = |path: PathBuf| {
        let time_ns = path.file_stem().and_then(|it| it.to_str()).and_then(|it| it.parse().ok());
        let expected = "a number of nanoseconds, such as 315973157959879000";
        time_ns.ok_or_else(|| DatasetError::file_name(path, expected))
    };
    let mut times_ns: Vec<i64> = sweeps.map(time_ns).collect::<Result<_, _>>()?;
    times_ns.sort_unstable();
    Ok(times_ns)
}
