//! KITTI's object benchmark: single scans, each with its own label and calibration file.
//!
//! ```text
//! velodyne/NNNNNN.bin
//! label_2/NNNNNN.txt
//! calib/NNNNNN.txt
//! image_2/NNNNNN.png   optional, only its size is read
//! ```
//!
//! Scans were picked out of drives at random, and their numbers are no times. Which raw scans they are is told by the development kit,
//! if it lies beside the split ([`RawMapping`]).

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::calibration::{KittiCalibration, parse_calibration};
use super::ground_truth::{KittiGroundTruth, label_scan};
use super::label::{KITTI_VOCABULARY, KittiLabel, parse_object_labels};
use super::raw_mapping::{RawMapping, RawScan};
use super::region_file::with_regions_of_file;
use super::split_folder::SplitFolder;
use crate::annotation::{LabeledScan, ScanId};
use crate::dataset::class_table::ClassReader;
use crate::dataset::data_sheet::LabeledRegion;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::numbered_files::{numbered_file, numbered_files};
use crate::dataset::source::DatasetSource;
use crate::dataset::unpaired_files::UnpairedFiles;
use crate::dataset::velodyne_bin::read_velodyne_bin;
use crate::dataset::{Dataset, DatasetError, Listing, Nearness};

/// The folder of the label files.
const LABELS: &str = "label_2";

/// The scans come from all over KITTI's drives, and their own files do not say from which.
const SEQUENCE: &str = "training";

/// An open KITTI object data set: labels and calibrations are in memory, scans are read one at a time.
#[derive(Debug, Clone)]
pub struct KittiObjects {
    // Invariant: `scan_ids` and `scans` have the same length and order.
    listing: Listing,
    labeled_region: LabeledRegion,
    scans: Vec<Scan>,
}

/// What is known about a scan without reading its points.
#[derive(Debug, Clone)]
struct Scan {
    path: PathBuf,
    calibration: KittiCalibration,
    image_size_px: [u32; 2],
    labels: Vec<KittiLabel>,
    raw: Option<RawScan>,
}

/// Whether `folder` looks like a split of the object benchmark.
pub fn is_kitti_object(folder: &Path) -> bool {
    let has_scans = || {
        std::fs::read_dir(folder.join("velodyne")).is_ok_and(|mut entries| {
            entries.any(|entry| {
                entry.is_ok_and(|it| it.path().extension().is_some_and(|extension| extension == "bin"))
            })
        })
    };
    folder.join(LABELS).is_dir() || (folder.join("calib").is_dir() && has_scans())
}

/// Opens the split folder of `source`: all its scans, or only those numbered in `scans`.
///
/// Scans are not looked into. With `scans`, files that belong to other scans are not looked at.
pub fn open_kitti_object(
    source: DatasetSource,
    scans: Option<&BTreeSet<u32>>,
) -> Result<KittiObjects, DatasetError> {
    let mut folder = SplitFolder::with_labels(&source.path, LABELS)?;
    let mut numbers: Vec<u32> = scan_numbers(&folder, scans)?.into_iter().collect();
    let mapping = RawMapping::beside(&source.path)?;
    let raw_scan = |number| mapping.as_ref().map(|it| it.raw_scan(number).cloned()).transpose();
    if mapping.is_some() {
        let mut by_time = Vec::with_capacity(numbers.len());
        for number in numbers {
            by_time.push((raw_scan(number)?, number));
        }
        by_time.sort_unstable();
        numbers = by_time.into_iter().map(|(_, number)| number).collect();
    }
    let mut scan_ids = Vec::with_capacity(numbers.len());
    let mut opened = Vec::with_capacity(numbers.len());
    let mut classes = ClassReader::new(&source.classes, KITTI_VOCABULARY);
    for index in numbers {
        opened.push(Scan { raw: raw_scan(index)?, ..open_scan(&mut folder, index, &mut classes)? });
        scan_ids.push(ScanId { sequence: SEQUENCE.to_owned(), index });
    }
    classes.unknown().refuse(&source.id)?;
    let labeled_region = source.labeled_region;
    let description = source.describe(DatasetFormat::KittiObject, folder.finish());
    Ok(KittiObjects { listing: Listing { description, scan_ids }, labeled_region, scans: opened })
}

impl Dataset for KittiObjects {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let id = self.listing.scan_ids[scan_idx].clone();
        let scan = &self.scans[scan_idx];
        let points = read_velodyne_bin(&scan.path)?;
        let truth = KittiGroundTruth {
            calibration: &scan.calibration,
            image_size_px: scan.image_size_px,
            labeled_region: self.labeled_region,
            labels: &scan.labels,
        };
        let name = format!("{:06}", id.index);
        let labeled = label_scan(id, points, &truth);
        match self.labeled_region {
            LabeledRegion::PerPoint => with_regions_of_file(labeled, &self.listing.description, &name),
            LabeledRegion::Camera | LabeledRegion::Everywhere => Ok(labeled),
        }
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        self.scans[scan_idx].raw.as_ref().map(|it| it.time_ns)
    }

    fn nearness(&self) -> Nearness {
        if self.scans.iter().all(|it| it.raw.is_some()) { Nearness::Times } else { Nearness::Unknown }
    }

    fn scan_block(&self, scan_idx: usize) -> Option<&str> {
        self.scans[scan_idx].raw.as_ref().map(|it| it.drive.as_str())
    }

    fn scan_n_bytes(&self, scan_idx: usize) -> Option<u64> {
        Some(self.scans[scan_idx].path.metadata().ok()?.len())
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        let scan = &self.scans[scan_idx];
        Ok(scan.calibration.foreign_frame(scan.image_size_px))
    }

    fn kitti_labels(&self, scan_idx: usize) -> Option<&[KittiLabel]> {
        Some(&self.scans[scan_idx].labels)
    }
}

/// The numbers of the scans to open, at least one, all of which exist.
fn scan_numbers(
    folder: &SplitFolder,
    selected: Option<&BTreeSet<u32>>,
) -> Result<BTreeSet<u32>, DatasetError> {
    let velodyne = folder.path_of("velodyne");
    let labels = folder.path_of(LABELS);
    let present = numbered_files(&velodyne, "bin")?;
    let labeled = numbered_files(&labels, "txt")?;
    let is_wanted = |number: &&u32| selected.is_none_or(|it| it.contains(number));
    let missing = selected.into_iter().flatten().find(|it| !present.contains(it) && !labeled.contains(it));
    if let Some(&missing) = missing {
        return Err(DatasetError::MissingSelected { path: numbered_file(&velodyne, missing, "bin") });
    }
    let without_scan = labeled.difference(&present).filter(is_wanted);
    let without_labels = present.difference(&labeled).filter(is_wanted);
    let unpaired = UnpairedFiles {
        scans: without_labels.map(|number| format!("{number:06}.bin")).collect(),
        labels: without_scan.map(|number| format!("{number:06}.txt")).collect(),
    };
    if !unpaired.is_empty() {
        return Err(DatasetError::Unpaired { labels, unpaired });
    }
    let numbers = selected.cloned().unwrap_or(present);
    if numbers.is_empty() {
        return Err(DatasetError::NoScans { path: velodyne });
    }
    Ok(numbers)
}

fn open_scan(
    folder: &mut SplitFolder,
    number: u32,
    classes: &mut ClassReader<'_>,
) -> Result<Scan, DatasetError> {
    let scan_name = format!("velodyne/{number:06}.bin");
    let path = folder.path_of(&scan_name);
    folder.add_scan(&scan_name)?;
    let labels_name = format!("{LABELS}/{number:06}.txt");
    let labels = folder.read_text(&labels_name, |path| DatasetError::MissingSelected { path })?;
    let calibration_name = format!("calib/{number:06}.txt");
    let calibration = folder.read_text(&calibration_name, |calibration| {
        DatasetError::ScanWithoutCalibration { scan: path.clone(), calibration }
    })?;
    let image = numbered_file(&folder.path_of("image_2"), number, "png");
    Ok(Scan {
        labels: parse_object_labels(&folder.path_of(&labels_name), &labels, classes)?,
        calibration: parse_calibration(&folder.path_of(&calibration_name), &calibration)?,
        image_size_px: folder.image_size_px(&format!("{number:06}"), &image)?,
        path,
        raw: None,
    })
}
