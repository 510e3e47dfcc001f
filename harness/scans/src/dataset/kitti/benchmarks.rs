//! KITTI's object and tracking benchmarks: scans with labels in the frame of a camera.
//!
//! ```text
//! object      velodyne/NNNNNN.bin            single scans
//!             label_2/NNNNNN.txt, calib/NNNNNN.txt
//!             image_2/NNNNNN.png             optional, only its size is read
//! tracking    velodyne/SEQUENCE/NNNNNN.bin   whole drives; only scans that exist count, so a partial download is a data set
//!             label_02/SEQUENCE.txt          the labels of all scans of the drive, whether downloaded or not
//!             calib/SEQUENCE.txt
//!             image_02/SEQUENCE/NNNNNN.png   optional, only the size of the first is read
//! ```
//!
//! The scans of the object benchmark were picked out of drives at random, and their numbers are no times. The development
//! kit lists the raw scans that they are taken from, if it lies beside the split ([`RawMapping`]).

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::calibration::{KittiCalibration, parse_calibration};
use super::ground_truth::{KittiGroundTruth, label_scan};
use super::label::{KITTI_VOCABULARY, KittiLabel, parse_object_labels, parse_tracking_labels};
use super::raw_mapping::{RawMapping, RawScan};
use super::region_file::with_regions_of_file;
use super::split_folder::SplitFolder;
use crate::annotation::{LabeledScan, ScanId};
use crate::dataset::class_table::ClassReader;
use crate::dataset::data_sheet::LabeledRegion;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::numbered_files::{SIX_DIGITS, numbered_file, numbered_files};
use crate::dataset::on_disk::{entries_of, has_extension, names_of};
use crate::dataset::point_columns::PointColumns;
use crate::dataset::scan_columns::ScanColumns;
use crate::dataset::source::{DamagePolicy, DatasetSource};
use crate::dataset::unpaired_files::{LeftOut, UnpairedFiles};
use crate::dataset::{Dataset, DatasetError, Listing, Nearness, labels_without_scan};

/// The folders of the label files.
const OBJECT_LABELS: &str = "label_2";
const TRACKING_LABELS: &str = "label_02";

/// The scans of the object benchmark come from all of KITTI's drives, and their own files do not state which.
const SEQUENCE: &str = "training";

/// An open benchmark: labels and calibrations are in memory, scans are read one at a time.
#[derive(Debug)]
struct KittiBenchmark {
    // Invariant: `scan_ids` and `scans` have the same length and order.
    listing: Listing,
    labeled_region: LabeledRegion,
    nearness: Nearness,
    columns: ScanColumns,
    scans: Vec<Scan>,
    // Names of missing scans that have labels.
    not_there: Vec<String>,
    left_out: Vec<LeftOut>,
}

/// Facts about a scan that are known without reading its points.
#[derive(Debug, Clone)]
struct Scan {
    // Below `velodyne`, without its ending.
    name: String,
    path: PathBuf,
    camera: Arc<Camera>,
    labels: Vec<KittiLabel>,
    raw: Option<RawScan>,
}

/// The camera in whose image objects were labelled.
#[derive(Debug)]
struct Camera {
    calibration: KittiCalibration,
    image_size_px: [u32; 2],
}

/// Whether `folder` looks like a split of the object benchmark.
pub fn is_kitti_object(folder: &Path) -> bool {
    let has_scans =
        || entries_of(&folder.join("velodyne")).is_ok_and(|it| it.iter().any(|it| has_extension(it, "bin")));
    folder.join(OBJECT_LABELS).is_dir() || (folder.join("calib").is_dir() && has_scans())
}

/// Whether `folder` looks like a split of the tracking benchmark.
pub fn is_kitti_tracking(folder: &Path) -> bool {
    let has_drives = || entries_of(&folder.join("velodyne")).is_ok_and(|it| it.iter().any(|it| it.is_dir()));
    folder.join(TRACKING_LABELS).is_dir() || has_drives()
}

/// Opens the split folder of `source`: all its scans, or only those that are chosen.
///
/// No scan is read, nor any file of other scans.
pub fn open_kitti_object(source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let mut folder = SplitFolder::with_labels(&source.path, OBJECT_LABELS)?;
    let (numbers, left_out) = object_numbers(&folder, source.parts.scans.as_ref(), source.damage)?;
    let mapping = RawMapping::beside(&source.path)?;
    let raw_scan = |number| mapping.as_ref().map(|it| it.raw_scan(number).cloned()).transpose();
    let mut by_time =
        numbers.into_iter().map(|it| Ok((raw_scan(it)?, it))).collect::<Result<Vec<_>, DatasetError>>()?;
    by_time.sort_unstable();
    let nearness =
        if by_time.iter().all(|(raw, _)| raw.is_some()) { Nearness::Times } else { Nearness::Unknown };
    let mut classes = ClassReader::new(&source.classes, KITTI_VOCABULARY);
    let (mut scan_ids, mut scans) = (Vec::new(), Vec::new());
    for (raw, index) in by_time {
        let name = format!("{index:06}");
        let path = folder.add_scan(&format!("velodyne/{name}.bin"));
        let labels_name = format!("{OBJECT_LABELS}/{name}.txt");
        let text = folder.read_text(&labels_name, DatasetError::missing_selected)?;
        let labels = parse_object_labels(&folder.path_of(&labels_name), &text, &mut classes)?;
        let image = folder.path_of(&format!("image_2/{name}.png"));
        let camera = read_camera(&mut folder, &name, &path, &image)?;
        scans.push(Scan { name, path, camera, labels, raw });
        scan_ids.push(ScanId { sequence: SEQUENCE.to_owned(), index });
    }
    classes.unknown().refuse(&source.id)?;
    let labeled_region = source.labeled_region;
    let columns = columns_of(&source, &scans);
    let checksum = folder.finish(source.damage)?;
    let description = source.describe(DatasetFormat::KittiObject, checksum);
    let listing = Listing { description, scan_ids };
    let not_there = Vec::new();
    Ok(Box::new(KittiBenchmark { listing, labeled_region, nearness, columns, scans, not_there, left_out }))
}

/// Opens the split folder of `source`: all drives that have scans, or only the chosen ones. No scan is read.
pub fn open_kitti_tracking(mut source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let selected = source.parts.sequences.take();
    let mut folder = SplitFolder::with_labels(&source.path, TRACKING_LABELS)?;
    let velodyne = folder.path_of("velodyne");
    let drives: Vec<PathBuf> = entries_of(&velodyne)?.into_iter().filter(|it| !it.is_file()).collect();
    let present: BTreeSet<String> = names_of(&drives, "the UTF-8 name of a sequence")?.into_iter().collect();
    if let Some(missing) = selected.iter().flatten().find(|it| !present.contains(*it)) {
        return Err(DatasetError::missing_selected(&velodyne.join(missing)));
    }
    let mut classes = ClassReader::new(&source.classes, KITTI_VOCABULARY);
    let (mut scan_ids, mut scans, mut not_there) = (Vec::new(), Vec::new(), Vec::new());
    for drive in selected.as_ref().unwrap_or(&present) {
        let drive_folder = velodyne.join(drive);
        let numbers = numbered_files(&drive_folder, "bin", SIX_DIGITS)?;
        if numbers.is_empty() {
            return Err(DatasetError::no_scans(drive_folder));
        }
        let labels_name = format!("{TRACKING_LABELS}/{drive}.txt");
        let text = folder.read_text(&labels_name, |it| DatasetError::without_labels(&drive_folder, it))?;
        let mut labels_by_scan = parse_tracking_labels(&folder.path_of(&labels_name), &text, &mut classes)?;
        let image = first_image(&folder, drive)?;
        let camera = read_camera(&mut folder, drive, &drive_folder, &image)?;
        for index in numbers {
            let name = format!("{drive}/{index:06}");
            let path = folder.add_scan(&format!("velodyne/{name}.bin"));
            let labels = labels_by_scan.remove(&index).unwrap_or_default();
            scans.push(Scan { name, path, camera: Arc::clone(&camera), labels, raw: None });
            scan_ids.push(ScanId { sequence: drive.clone(), index });
        }
        not_there.extend(labels_by_scan.keys().map(|index| format!("{drive}/{index:06}")));
    }
    classes.unknown().refuse(&source.id)?;
    if scan_ids.is_empty() {
        return Err(DatasetError::no_scans(velodyne));
    }
    let labeled_region = source.labeled_region;
    let columns = columns_of(&source, &scans);
    let checksum = folder.finish(source.damage)?;
    let description = source.describe(DatasetFormat::KittiTracking, checksum);
    let listing = Listing { description, scan_ids };
    let nearness = Nearness::Times;
    let left_out = Vec::new();
    Ok(Box::new(KittiBenchmark { listing, labeled_region, nearness, columns, scans, not_there, left_out }))
}

impl Dataset for KittiBenchmark {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let Scan { name, path, camera, labels, .. } = &self.scans[scan_idx];
        let truth = KittiGroundTruth {
            calibration: &camera.calibration,
            image_size_px: camera.image_size_px,
            labeled_region: self.labeled_region,
            labels,
        };
        let id = self.listing.scan_ids[scan_idx].clone();
        let labeled = label_scan(id, self.columns.read(path)?, &truth);
        match self.labeled_region {
            LabeledRegion::PerPoint => with_regions_of_file(labeled, &self.listing.description, name),
            LabeledRegion::Camera | LabeledRegion::Everywhere => Ok(labeled),
        }
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        self.scans[scan_idx].raw.as_ref().map(|it| it.time_ns)
    }

    fn nearness(&self) -> Nearness {
        self.nearness
    }

    fn scan_block(&self, scan_idx: usize) -> Option<&str> {
        self.scans[scan_idx].raw.as_ref().map(|it| it.drive.as_str())
    }

    fn scan_n_bytes(&self, scan_idx: usize) -> Option<u64> {
        Some(self.scans[scan_idx].path.metadata().ok()?.len())
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        let camera = &self.scans[scan_idx].camera;
        Ok(camera.calibration.foreign_frame(camera.image_size_px))
    }

    fn kitti_labels(&self, scan_idx: usize) -> Option<&[KittiLabel]> {
        Some(&self.scans[scan_idx].labels)
    }

    fn columns(&self) -> Result<Option<String>, DatasetError> {
        self.columns.described()
    }

    fn files_left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        Ok(labels_without_scan(&self.not_there))
    }
}

fn columns_of(source: &DatasetSource, scans: &[Scan]) -> ScanColumns {
    let paths: Vec<PathBuf> = scans.iter().map(|it| it.path.clone()).collect();
    ScanColumns::new(source.columns.clone(), PointColumns::of_kitti(), &paths)
}

/// The numbers of the scans to open, at least one, all of which exist and have labels; and the files to leave out.
fn object_numbers(
    folder: &SplitFolder,
    selected: Option<&BTreeSet<u32>>,
    damage: DamagePolicy,
) -> Result<(BTreeSet<u32>, Vec<LeftOut>), DatasetError> {
    let velodyne = folder.path_of("velodyne");
    let labels = folder.path_of(OBJECT_LABELS);
    let present = numbered_files(&velodyne, "bin", SIX_DIGITS)?;
    let labeled = numbered_files(&labels, "txt", SIX_DIGITS)?;
    let is_wanted = |number: &&u32| selected.is_none_or(|it| it.contains(number));
    let missing = selected.into_iter().flatten().find(|it| !present.contains(it) && !labeled.contains(it));
    if let Some(&missing) = missing {
        return Err(DatasetError::missing_selected(&numbered_file(&velodyne, missing, "bin")));
    }
    let without_scan = labeled.difference(&present).filter(is_wanted);
    let without_labels = present.difference(&labeled).filter(is_wanted);
    let unpaired = UnpairedFiles {
        scans: without_labels.map(|number| format!("{number:06}.bin")).collect(),
        labels: without_scan.map(|number| format!("{number:06}.txt")).collect(),
    };
    let left_out = unpaired.left_out(&labels, damage)?;
    let mut numbers = selected.cloned().unwrap_or_else(|| present.clone());
    numbers.retain(|it| present.contains(it) && labeled.contains(it));
    if numbers.is_empty() {
        return Err(DatasetError::no_scans(velodyne));
    }
    Ok((numbers, left_out))
}

/// Reads the calibration of `scans`, a scan or a drive called `name`, and the size of `image`.
fn read_camera(
    folder: &mut SplitFolder,
    name: &str,
    scans: &Path,
    image: &Path,
) -> Result<Arc<Camera>, DatasetError> {
    let calibration_name = format!("calib/{name}.txt");
    let text = folder.read_text(&calibration_name, |it| DatasetError::without_calibration(scans, it))?;
    let calibration = parse_calibration(&folder.path_of(&calibration_name), &text)?;
    Ok(Arc::new(Camera { calibration, image_size_px: folder.image_size_px(name, image)? }))
}

/// The first image of a drive, which was recorded with one setting.
fn first_image(folder: &SplitFolder, drive: &str) -> Result<PathBuf, DatasetError> {
    let images = folder.path_of(&format!("image_02/{drive}"));
    let first =
        if images.is_dir() { numbered_files(&images, "png", SIX_DIGITS)?.first().copied() } else { None };
    Ok(numbered_file(&images, first.unwrap_or_default(), "png"))
}
