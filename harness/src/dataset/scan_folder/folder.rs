//! A folder of scans, in the order of their names.
//!
//! ```text
//! NAME.pcd, .ply, .npy, .bin, .las or .laz   the scans, in the folder, or in lidar, pointclouds or velodyne in it
//! labels/NAME.json                           optional: boxes; where there is a folder of labels, every scan has its own
//! ```
//!
//! The folder of labels may be called `labels`, `label` or `label_2`; [`label_file`](super::label_file) says what may be in it.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::any_scan_file::{read_scan_file, scan_origin_m};
use super::label_file::LabelFile;
use super::scan_file::scan_extension;
use crate::annotation::{LabeledScan, PointRegion, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::missing_scans::labels_of_missing;
use crate::dataset::numbered_files::is_hidden;
use crate::dataset::points_of_boxes::points_of_boxes;
use crate::dataset::source::DatasetSource;
use crate::dataset::text_file::read_text_file;
use crate::dataset::{Dataset, DatasetDescription, DatasetError};

/// Where scans may lie in the folder that is named.
const SCANS: [&str; 4] = ["", "lidar", "pointclouds", "velodyne"];

/// Where labels may.
const LABELS: [&str; 3] = ["labels", "label", "label_2"];

/// An open folder: the names of the scans are in memory.
#[derive(Debug)]
pub struct ScanFolder {
    // Invariant: `scan_ids` and `scans` have the same length and order.
    description: DatasetDescription,
    scan_ids: Vec<ScanId>,
    scans: Vec<PathBuf>,
    labels: Option<PathBuf>,
}

/// Whether scans lie in `folder`.
pub fn is_scan_folder(folder: &Path) -> bool {
    scans_below(folder).is_some()
}

/// The folder with scans: `folder` itself, or one that tools keep them in.
fn scans_below(folder: &Path) -> Option<PathBuf> {
    let has_scans = |folder: &PathBuf| {
        std::fs::read_dir(folder)
            .is_ok_and(|mut entries| entries.any(|entry| entry.is_ok_and(|it| is_scan(&it.path()))))
    };
    SCANS.into_iter().map(|name| folder.join(name)).find(has_scans)
}

/// Opens the folder of `source`. Scans are numbered in the order of their names.
///
/// # Errors
///
/// [`DatasetError`] if a scan lacks its labels, or labels are not text.
pub fn open_scan_folder(source: DatasetSource) -> Result<ScanFolder, DatasetError> {
    let folder = source.path.clone();
    let io_error = |source| DatasetError::Io { path: folder.clone(), source };
    let mut scans = Vec::new();
    for entry in std::fs::read_dir(scans_below(&folder).unwrap_or(folder.clone())).map_err(io_error)? {
        let path = entry.map_err(io_error)?.path();
        if is_scan(&path) {
            scans.push(path);
        }
    }
    scans.sort();
    if scans.is_empty() {
        return Err(DatasetError::NoScans { path: folder });
    }
    let labels = LABELS.into_iter().map(|it| folder.join(it)).find(|it| it.is_dir());
    let mut checksum = DatasetChecksum::default();
    for scan in &scans {
        let name = scan.file_name().map(|it| it.to_string_lossy().into_owned()).unwrap_or_default();
        let metadata = std::fs::metadata(scan).map_err(io_error)?;
        checksum.add_scan(&name, metadata.len());
        if let Some(labels) = &labels {
            for (place, file) in LabelFile::find(labels, scan)?.files().into_iter().enumerate() {
                // The first is that of the labels, the second what they need.
                let kind = ["labels", "calib"][place];
                checksum.add_text(&format!("{kind}/{name}"), &read_text_file(file)?);
            }
        }
    }
    let sequence = folder.canonicalize().unwrap_or_else(|_| folder.clone());
    let sequence = sequence.file_name().map(|it| it.to_string_lossy().into_owned()).unwrap_or_default();
    let scan_ids =
        (0..scans.len() as u32).map(|index| ScanId { sequence: sequence.clone(), index }).collect();
    let description = source.describe(DatasetFormat::ScanFolder, checksum.finish());
    Ok(ScanFolder { description, scan_ids, scans, labels })
}

impl Dataset for ScanFolder {
    fn description(&self) -> &DatasetDescription {
        &self.description
    }

    fn scan_ids(&self) -> &[ScanId] {
        &self.scan_ids
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let path = &self.scans[scan_idx];
        let points = read_scan_file(path)?;
        let (mut annotations, region) = match &self.labels {
            Some(labels) => {
                let file = LabelFile::find(labels, path)?;
                let texts = file.files().into_iter().map(read_text_file).collect::<Result<Vec<_>, _>>()?;
                let annotated = &self.description.annotated;
                (file.parse(&texts, points.origin_m, annotated)?, PointRegion::Labeled)
            }
            None => (Vec::new(), PointRegion::Outside),
        };
        let boxes: Vec<_> = annotations.iter().filter_map(|it| it.bounding_box).collect();
        for (annotation, points) in annotations.iter_mut().zip(points_of_boxes(&points.cloud, &boxes)) {
            annotation.point_indices = points;
        }
        let point_regions = vec![region; points.cloud.len()];
        let id = self.scan_ids[scan_idx].clone();
        Ok(LabeledScan { id, cloud: points.cloud, annotations, point_regions })
    }

    fn labels_without_scans(&self) -> Result<Option<String>, DatasetError> {
        let Some(labels) = &self.labels else { return Ok(None) };
        let io_error = |source| DatasetError::Io { path: labels.clone(), source };
        let stems: BTreeSet<&OsStr> = self.scans.iter().filter_map(|it| it.file_stem()).collect();
        let mut missing = BTreeSet::new();
        for entry in std::fs::read_dir(labels).map_err(io_error)? {
            let path = entry.map_err(io_error)?.path();
            let is_label =
                path.extension().is_some_and(|it| it == "json" || it == "txt") && !is_hidden(&path);
            if is_label && path.file_stem().is_some_and(|it| !stems.contains(it)) {
                missing.insert(path.file_name().unwrap_or_default().to_string_lossy().into_owned());
            }
        }
        Ok(labels_of_missing(missing.into_iter()))
    }

    /// Where the origin was moved to, of scans on a map.
    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        let origin_m = scan_origin_m(&self.scans[scan_idx])?;
        let pose =
            Isometry3::from_parts(Translation3::from(Vector3::from(origin_m)), UnitQuaternion::identity());
        Ok((origin_m != [0.0; 3]).then_some(pose))
    }
}

fn is_scan(path: &Path) -> bool {
    !is_hidden(path) && scan_extension(path).is_some() && path.is_file()
}
