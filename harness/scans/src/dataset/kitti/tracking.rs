//! KITTI's tracking benchmark: whole drives, with one label file each.
//!
//! ```text
//! velodyne/SEQUENCE/NNNNNN.bin   the scans; only those that exist count, so a partial download is a data set
//! label_02/SEQUENCE.txt          the labels of all scans of the drive, whether downloaded or not
//! calib/SEQUENCE.txt
//! image_02/SEQUENCE/NNNNNN.png   optional, only the size of the first is read
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::calibration::{KittiCalibration, parse_calibration};
use super::ground_truth::{KittiGroundTruth, label_scan};
use super::label::{KITTI_VOCABULARY, KittiLabel, parse_tracking_labels};
use super::region_file::with_regions_of_file;
use super::split_folder::SplitFolder;
use crate::annotation::{LabeledScan, ScanId};
use crate::dataset::class_table::ClassReader;
use crate::dataset::data_sheet::LabeledRegion;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::numbered_files::{is_hidden, numbered_file, numbered_files};
use crate::dataset::source::DatasetSource;
use crate::dataset::velodyne_bin::read_velodyne_bin;
use crate::dataset::{Dataset, DatasetError, Listing, labels_without_scan};

/// The folder of the label files.
const LABELS: &str = "label_02";

/// An open KITTI tracking data set: labels and calibrations are in memory, scans are read one at a time.
#[derive(Debug, Clone)]
pub struct KittiTracking {
    // Invariant: `sequences` has every sequence that `scan_ids` names.
    listing: Listing,
    labeled_region: LabeledRegion,
    sequences: BTreeMap<String, Sequence>,
}

/// What is known about a drive without reading a scan.
#[derive(Debug, Clone)]
struct Sequence {
    folder: PathBuf,
    calibration: KittiCalibration,
    image_size_px: [u32; 2],
    labels_by_scan: BTreeMap<u32, Vec<KittiLabel>>,
}

/// Whether `folder` looks like a split of the tracking benchmark.
pub fn is_kitti_tracking(folder: &Path) -> bool {
    let has_drives = || {
        std::fs::read_dir(folder.join("velodyne")).is_ok_and(|mut entries| {
            entries.any(|entry| entry.is_ok_and(|it| it.path().is_dir() && !is_hidden(&it.path())))
        })
    };
    folder.join(LABELS).is_dir() || has_drives()
}

/// Opens the split folder of `source`: all drives that have scans, or only those of `sequences`.
///
/// Scans are not looked into.
pub fn open_kitti_tracking(
    source: DatasetSource,
    sequences: Option<&BTreeSet<String>>,
) -> Result<KittiTracking, DatasetError> {
    let mut folder = SplitFolder::with_labels(&source.path, LABELS)?;
    let velodyne = folder.path_of("velodyne");
    let present = sequence_names(&velodyne)?;
    if let Some(missing) = sequences.and_then(|names| names.iter().find(|name| !present.contains(*name))) {
        return Err(DatasetError::MissingSelected { path: velodyne.join(missing) });
    }
    let mut scan_ids = Vec::new();
    let mut opened = BTreeMap::new();
    let mut classes = ClassReader::new(&source.classes, KITTI_VOCABULARY);
    for name in sequences.unwrap_or(&present) {
        let numbers = scan_numbers(&mut folder, name)?;
        scan_ids.extend(numbers.into_iter().map(|index| ScanId { sequence: name.clone(), index }));
        opened.insert(name.clone(), open_sequence(&mut folder, name, &mut classes)?);
    }
    classes.unknown().refuse(&source.id)?;
    if scan_ids.is_empty() {
        return Err(DatasetError::NoScans { path: velodyne });
    }
    let labeled_region = source.labeled_region;
    let description = source.describe(DatasetFormat::KittiTracking, folder.finish());
    Ok(KittiTracking { listing: Listing { description, scan_ids }, labeled_region, sequences: opened })
}

impl Dataset for KittiTracking {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let id = self.listing.scan_ids[scan_idx].clone();
        let sequence = &self.sequences[&id.sequence];
        let points = read_velodyne_bin(&numbered_file(&sequence.folder, id.index, "bin"))?;
        let truth = KittiGroundTruth {
            calibration: &sequence.calibration,
            image_size_px: sequence.image_size_px,
            labeled_region: self.labeled_region,
            labels: sequence.labels_by_scan.get(&id.index).map_or(&[], Vec::as_slice),
        };
        let name = id.to_string();
        let labeled = label_scan(id, points, &truth);
        match self.labeled_region {
            LabeledRegion::PerPoint => with_regions_of_file(labeled, &self.listing.description, &name),
            LabeledRegion::Camera | LabeledRegion::Everywhere => Ok(labeled),
        }
    }

    fn scan_n_bytes(&self, scan_idx: usize) -> Option<u64> {
        let id = &self.listing.scan_ids[scan_idx];
        let file = numbered_file(&self.sequences[&id.sequence].folder, id.index, "bin");
        Some(file.metadata().ok()?.len())
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        let sequence = &self.sequences[&self.scan_ids()[scan_idx].sequence];
        Ok(sequence.calibration.foreign_frame(sequence.image_size_px))
    }

    fn kitti_labels(&self, scan_idx: usize) -> Option<&[KittiLabel]> {
        let id = &self.scan_ids()[scan_idx];
        Some(self.sequences[&id.sequence].labels_by_scan.get(&id.index).map_or(&[], Vec::as_slice))
    }

    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        let scans: BTreeSet<(&str, u32)> =
            self.listing.scan_ids.iter().map(|it| (it.sequence.as_str(), it.index)).collect();
        let labeled = self.sequences.iter().flat_map(|(name, sequence)| {
            sequence.labels_by_scan.keys().map(move |index| (name.as_str(), *index))
        });
        let without_scan = labeled.filter(|it| !scans.contains(it));
        let names: Vec<String> = without_scan.map(|(name, index)| format!("{name}/{index:06}")).collect();
        Ok(labels_without_scan(&names))
    }
}

/// The names of the folders in `velodyne`.
fn sequence_names(velodyne: &Path) -> Result<BTreeSet<String>, DatasetError> {
    let io_error = |source| DatasetError::Io { path: velodyne.to_path_buf(), source };
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(velodyne).map_err(io_error)? {
        let path = entry.map_err(io_error)?.path();
        if !path.is_dir() || is_hidden(&path) {
            continue;
        }
        match path.file_name().and_then(|name| name.to_str()) {
            Some(name) => names.insert(name.to_owned()),
            None => return Err(DatasetError::FileName { path, expected: "the UTF-8 name of a sequence" }),
        };
    }
    Ok(names)
}

/// The numbers of the scans of sequence `name`, at least one.
fn scan_numbers(folder: &mut SplitFolder, name: &str) -> Result<BTreeSet<u32>, DatasetError> {
    let path = folder.path_of(&format!("velodyne/{name}"));
    let numbers = numbered_files(&path, "bin")?;
    if numbers.is_empty() {
        return Err(DatasetError::NoScans { path });
    }
    for number in &numbers {
        folder.add_scan(&format!("velodyne/{name}/{number:06}.bin"))?;
    }
    Ok(numbers)
}

fn open_sequence(
    folder: &mut SplitFolder,
    name: &str,
    classes: &mut ClassReader<'_>,
) -> Result<Sequence, DatasetError> {
    let scans = folder.path_of(&format!("velodyne/{name}"));
    let labels_name = format!("{LABELS}/{name}.txt");
    let labels = folder
        .read_text(&labels_name, |labels| DatasetError::ScanWithoutLabels { scan: scans.clone(), labels })?;
    let calibration_name = format!("calib/{name}.txt");
    let calibration = folder.read_text(&calibration_name, |calibration| {
        DatasetError::ScanWithoutCalibration { scan: scans.clone(), calibration }
    })?;
    Ok(Sequence {
        labels_by_scan: parse_tracking_labels(&folder.path_of(&labels_name), &labels, classes)?,
        calibration: parse_calibration(&folder.path_of(&calibration_name), &calibration)?,
        image_size_px: image_size_px(folder, name)?,
        folder: scans,
    })
}

/// The image size of sequence `name`: that of its first image, since a drive was recorded with one setting.
fn image_size_px(folder: &mut SplitFolder, name: &str) -> Result<[u32; 2], DatasetError> {
    let images = folder.path_of(&format!("image_02/{name}"));
    let first = if images.is_dir() { numbered_files(&images, "png")?.first().copied() } else { None };
    folder.image_size_px(name, &numbered_file(&images, first.unwrap_or_default(), "png"))
}
