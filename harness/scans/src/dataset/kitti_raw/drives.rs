//! KITTI's raw folders.
//!
//! ```text
//! DATE/calib_velo_to_cam.txt, calib_cam_to_cam.txt, calib_imu_to_velo.txt
//! DATE/DATE_drive_NNNN_sync/velodyne_points/data/NNNNNNNNNN.bin, velodyne_points/timestamps.txt
//! DATE/DATE_drive_NNNN_sync/tracklet_labels.xml      optional: boxes; drives without are not labelled
//! DATE/DATE_drive_NNNN_sync/oxts/data/NNNNNNNNNN.txt   optional: poses
//! ```
//!
//! The folder of a data set may be that of all days, of a day, or of a drive.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use nalgebra::Isometry3;

use super::drive_calibration::{CameraView, parse_camera_view, parse_transform};
use super::inertial_poses::{InertialFix, parse_inertial_fix};
use super::tracklet_file::parse_tracklets;
use crate::annotation::{Annotation, LabeledArea, LabeledScan, PointRegion, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::class_table::ClassReader;
use crate::dataset::data_sheet::LabeledRegion;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::kitti::camera_field_of_view::{CameraFieldOfView, point_regions};
use crate::dataset::kitti::label::KITTI_VOCABULARY;
use crate::dataset::numbered_files::{TEN_DIGITS, numbered_files};
use crate::dataset::on_disk::{entries_of, has_extension, is_there, name_of};
use crate::dataset::point_columns::PointColumns;
use crate::dataset::points_of_boxes::assign_points_in_boxes;
use crate::dataset::scan_columns::ScanColumns;
use crate::dataset::scan_sizes::ScanSizes;
use crate::dataset::source::DatasetSource;
use crate::dataset::text_file::read_text_file;
use crate::dataset::{Dataset, DatasetError, Listing, labels_without_scan};

const SCANS: &str = "velodyne_points/data";
const TIMES: &str = "velodyne_points/timestamps.txt";
const LABELS: &str = "tracklet_labels.xml";
const POSES: &str = "oxts/data";

/// Open drives: labels, calibrations and times are in memory, scans and poses are read one at a time.
#[derive(Debug)]
struct KittiRaw {
    // Invariant: `drives` has every drive that `scan_ids` names.
    listing: Listing,
    labeled_region: LabeledRegion,
    columns: ScanColumns,
    drives: BTreeMap<String, Drive>,
}

#[derive(Debug)]
struct Drive {
    folder: PathBuf,
    /// `None` if the drive is not labelled.
    labels: Option<Labels>,
    times_ns: Vec<u64>,
    poses: Option<Poses>,
}

#[derive(Debug)]
struct Labels {
    annotations_by_scan: BTreeMap<u32, Vec<Annotation>>,
    view: CameraView,
}

#[derive(Debug)]
struct Poses {
    origin: InertialFix,
    unit_from_sensor: Isometry3<f64>,
}

/// Whether `folder` holds drives, or is one.
pub fn is_kitti_raw(folder: &Path) -> bool {
    !drives_below(folder).is_empty()
}

/// Opens the folder of `source`: all drives, or only those of `sequences`, such as `2011_09_26_drive_0001_sync`.
///
/// No scan is read, and of the poses only the first of each drive.
pub fn open_kitti_raw(mut source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let sequences = source.parts.sequences.take();
    let (mut scan_ids, mut drives, mut checksum) = (Vec::new(), BTreeMap::new(), DatasetChecksum::default());
    let (mut paths, mut sizes) = (Vec::new(), ScanSizes::default());
    let mut classes = ClassReader::new(&source.classes, KITTI_VOCABULARY);
    for folder in drives_below(&source.path) {
        let name = name_of(&folder);
        if sequences.as_ref().is_some_and(|it| !it.contains(&name)) {
            continue;
        }
        let numbers = numbered_files(&folder.join(SCANS), "bin", TEN_DIGITS)?;
        if numbers.is_empty() {
            return Err(DatasetError::no_scans(folder.join(SCANS)));
        }
        for number in &numbers {
            let file = format!("{SCANS}/{number:010}.bin");
            let path = folder.join(&file);
            checksum.add_scan(&format!("{name}/{file}"), sizes.n_bytes_of(&path));
            paths.push(path);
        }
        let last = numbers.last().copied().unwrap_or_default();
        scan_ids.extend(numbers.into_iter().map(|index| ScanId { sequence: name.clone(), index }));
        let drive = open_drive(folder.clone(), &name, last, &mut checksum, &mut classes)?;
        if let Some(other) = drives.insert(name.clone(), drive) {
            return Err(DatasetError::same_name("drives", &name, &[&other.folder, &folder]));
        }
    }
    classes.unknown().refuse(&source.id)?;
    if let Some(missing) = sequences.iter().flatten().find(|name| !drives.contains_key(*name)) {
        return Err(DatasetError::missing_selected(&source.path.join(missing)));
    }
    if scan_ids.is_empty() {
        return Err(DatasetError::no_scans(source.path));
    }
    sizes.check(&source.path, source.damage)?;
    let labeled_region = source.labeled_region;
    let columns = ScanColumns::new(source.columns.clone(), PointColumns::of_kitti(), &paths);
    let description = source.describe(DatasetFormat::KittiRaw, checksum.finish());
    let listing = Listing { description, scan_ids };
    Ok(Box::new(KittiRaw { listing, labeled_region, columns, drives }))
}

impl Dataset for KittiRaw {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let id = self.listing.scan_ids[scan_idx].clone();
        let drive = &self.drives[&id.sequence];
        let path = drive.folder.join(SCANS).join(format!("{:010}.bin", id.index));
        let (cloud, points_left_out) = self.columns.read(&path)?.into_parts();
        let Some(labels) = &drive.labels else {
            let point_regions = vec![PointRegion::Outside; cloud.len()];
            let labeled_area = LabeledArea::AsPoints;
            let annotations = Vec::new();
            return Ok(LabeledScan { id, cloud, annotations, point_regions, labeled_area, points_left_out });
        };
        let mut annotations = labels.annotations_by_scan.get(&id.index).cloned().unwrap_or_default();
        assign_points_in_boxes(&cloud, &mut annotations);
        let view = CameraFieldOfView {
            image_from_velodyne: &labels.view.image_from_velodyne,
            image_size_px: labels.view.image_size_px,
            dont_care: &[],
        };
        let (point_regions, labeled_area) = match self.labeled_region {
            LabeledRegion::Camera => (point_regions(&cloud, &annotations, &view), view.labeled_area()),
            LabeledRegion::Everywhere | LabeledRegion::PerPoint => {
                (vec![PointRegion::Labeled; cloud.len()], LabeledArea::Everywhere)
            }
        };
        Ok(LabeledScan { id, cloud, annotations, point_regions, labeled_area, points_left_out })
    }

    fn columns(&self) -> Result<Option<String>, DatasetError> {
        self.columns.described()
    }

    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        let scans: BTreeSet<(&str, u32)> =
            self.listing.scan_ids.iter().map(|it| (it.sequence.as_str(), it.index)).collect();
        let labeled = self.drives.iter().flat_map(|(name, drive)| {
            let numbers = drive.labels.iter().flat_map(|it| it.annotations_by_scan.keys());
            numbers.map(move |index| (name.as_str(), *index))
        });
        let without_scan = labeled.filter(|it| !scans.contains(it));
        let names: Vec<String> = without_scan.map(|(name, index)| format!("{name}/{index:010}")).collect();
        Ok(labels_without_scan(&names))
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        let id = &self.listing.scan_ids[scan_idx];
        self.drives[&id.sequence].times_ns.get(id.index as usize).copied()
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        let id = &self.listing.scan_ids[scan_idx];
        let drive = &self.drives[&id.sequence];
        let Some(poses) = &drive.poses else { return Ok(None) };
        let fix = read_fix(&drive.folder.join(POSES), id.index)?;
        Ok(Some(fix.world_from_unit(&poses.origin) * poses.unit_from_sensor))
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        // The calibration of the cameras is read with the labels.
        let labels = self.drives[&self.scan_ids()[scan_idx].sequence].labels.as_ref();
        Ok(labels.map_or(ForeignFrame::Sensor, |it| ForeignFrame::Camera {
            velodyne_from_camera: it.view.velodyne_from_camera,
            image_from_velodyne: it.view.image_from_velodyne,
            image_size_px: it.view.image_size_px,
        }))
    }

    fn scan_n_bytes(&self, scan_idx: usize) -> Option<u64> {
        let id = &self.listing.scan_ids[scan_idx];
        let file = self.drives[&id.sequence].folder.join(SCANS).join(format!("{:010}.bin", id.index));
        Some(file.metadata().ok()?.len())
    }
}

/// The folders of drives: `folder` itself, or those in it or in its folders.
fn drives_below(folder: &Path) -> Vec<PathBuf> {
    let is_drive = |path: &Path| path.join(SCANS).is_dir();
    if is_drive(folder) {
        return vec![folder.to_path_buf()];
    }
    let folders_in = |folder: &Path| {
        entries_of(folder).unwrap_or_default().into_iter().filter(|it| it.is_dir()).collect::<Vec<_>>()
    };
    let inner = folders_in(folder);
    let innermost = inner.iter().flat_map(|it| folders_in(it));
    let mut drives: Vec<PathBuf> = inner.iter().cloned().chain(innermost).filter(|it| is_drive(it)).collect();
    drives.sort();
    drives
}

fn open_drive(
    folder: PathBuf,
    name: &str,
    last_scan: u32,
    checksum: &mut DatasetChecksum,
    classes: &mut ClassReader<'_>,
) -> Result<Drive, DatasetError> {
    let mut read_text = |path: &Path, name: &str| -> Result<String, DatasetError> {
        let text = read_text_file(path)?;
        checksum.add_text(name, &text);
        Ok(text)
    };
    // A relative path may end in `..` or be `.`, which has no parent by name.
    let day =
        folder.canonicalize().ok().and_then(|it| it.parent().map(Path::to_path_buf)).unwrap_or_default();
    let mut calibration = |kind: &str| -> Result<(PathBuf, String), DatasetError> {
        let path = day.join(format!("calib_{kind}.txt"));
        if !path.is_file() {
            return Err(DatasetError::without_calibration(&folder.join(SCANS), &path));
        }
        let text = read_text(&path, &format!("{name}/calib_{kind}.txt"))?;
        Ok((path, text))
    };
    let poses = if is_there(&folder.join(POSES)) {
        let (path, text) = calibration("imu_to_velo")?;
        let unit_from_sensor = parse_transform(&path, &text)?.inverse();
        let origin = first_fix(&folder.join(POSES))?;
        Some(Poses { origin, unit_from_sensor })
    } else {
        None
    };
    let labels = if is_there(&folder.join(LABELS)) {
        let ((velo_path, velo), (cam_path, cam)) = (calibration("velo_to_cam")?, calibration("cam_to_cam")?);
        let view = parse_camera_view((&velo_path, &velo), (&cam_path, &cam))?;
        let path = folder.join(LABELS);
        let text = read_text(&path, &format!("{name}/{LABELS}"))?;
        Some(Labels { annotations_by_scan: parse_tracklets(&path, &text, classes)?, view })
    } else {
        None
    };
    let path = folder.join(TIMES);
    let times_ns =
        if is_there(&path) { parse_times(&path, &read_text_file(&path)?, last_scan)? } else { Vec::new() };
    Ok(Drive { folder, labels, times_ns, poses })
}

fn read_fix(poses: &Path, scan: u32) -> Result<InertialFix, DatasetError> {
    let path = poses.join(format!("{scan:010}.txt"));
    parse_inertial_fix(&path, &read_text_file(&path)?)
}

/// The fix of the file with the lowest number: the origin of all poses.
fn first_fix(poses: &Path) -> Result<InertialFix, DatasetError> {
    let first = entries_of(poses)?.into_iter().find(|it| has_extension(it, "txt"));
    let path = first.ok_or_else(|| DatasetError::no_scans(poses))?;
    parse_inertial_fix(&path, &read_text_file(&path)?)
}

/// Times in nanoseconds, one per line, such as `2011-09-26 13:02:25.951199337`. Their zone is not stated; UTC is assumed.
fn parse_times(path: &Path, text: &str, last_scan: u32) -> Result<Vec<u64>, DatasetError> {
    let mut times_ns = Vec::new();
    for (line, content) in (1..).zip(text.lines().filter(|it| !it.trim().is_empty())) {
        let time = content.trim().parse::<DateTime>().ok().and_then(|it| it.to_zoned(TimeZone::UTC).ok());
        let time_ns = time.and_then(|it| u64::try_from(it.timestamp().as_nanosecond()).ok());
        times_ns.push(time_ns.ok_or_else(|| DatasetError::Line {
            path: path.to_path_buf(),
            line,
            problem: format!("{:?} is not a time", content.chars().take(40).collect::<String>()),
        })?);
    }
    if times_ns.len() <= last_scan as usize {
        let problem = format!("has {} lines, but the last scan is {last_scan}", times_ns.len());
        return Err(DatasetError::Damaged { path: path.to_path_buf(), problem });
    }
    Ok(times_ns)
}
