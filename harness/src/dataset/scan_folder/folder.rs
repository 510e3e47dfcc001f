//! A folder of scans, in the order of their names.
//!
//! ```text
//! NAME.pcd, .ply, .npy or .bin   the scans
//! labels/NAME.json               optional: boxes; where there is a folder of labels, every scan has its own
//! ```

use std::path::{Path, PathBuf};

use super::box_list::read_box_list;
use super::scan_file::{read_scan_file, scan_extension};
use crate::annotation::{LabeledScan, PointRegion, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::numbered_files::is_hidden;
use crate::dataset::points_of_boxes::points_of_boxes;
use crate::dataset::source::DatasetSource;
use crate::dataset::text_file::read_text_file;
use crate::dataset::{Dataset, DatasetDescription, DatasetError};

const LABELS: &str = "labels";

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
    std::fs::read_dir(folder)
        .is_ok_and(|mut entries| entries.any(|entry| entry.is_ok_and(|it| is_scan(&it.path()))))
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
    for entry in std::fs::read_dir(&folder).map_err(io_error)? {
        let path = entry.map_err(io_error)?.path();
        if is_scan(&path) {
            scans.push(path);
        }
    }
    scans.sort();
    if scans.is_empty() {
        return Err(DatasetError::NoScans { path: folder });
    }
    let labels = Some(folder.join(LABELS)).filter(|it| it.is_dir());
    let mut checksum = DatasetChecksum::default();
    for scan in &scans {
        let name = scan.file_name().map(|it| it.to_string_lossy().into_owned()).unwrap_or_default();
        let metadata = std::fs::metadata(scan).map_err(io_error)?;
        checksum.add_scan(&name, metadata.len());
        if let Some(labels) = &labels {
            let labels = labels_of(labels, scan);
            if !labels.exists() {
                return Err(DatasetError::ScanWithoutLabels { scan: scan.clone(), labels });
            }
            checksum.add_text(&format!("{LABELS}/{name}"), &read_text_file(&labels)?);
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
        let cloud = read_scan_file(path)?;
        let (mut annotations, region) = match &self.labels {
            Some(labels) => (read_box_list(&labels_of(labels, path))?, PointRegion::Labeled),
            None => (Vec::new(), PointRegion::Outside),
        };
        let boxes: Vec<_> = annotations.iter().filter_map(|it| it.bounding_box).collect();
        for (annotation, points) in annotations.iter_mut().zip(points_of_boxes(&cloud, &boxes)) {
            annotation.point_indices = points;
        }
        let point_regions = vec![region; cloud.len()];
        Ok(LabeledScan { id: self.scan_ids[scan_idx].clone(), cloud, annotations, point_regions })
    }
}

fn is_scan(path: &Path) -> bool {
    !is_hidden(path) && scan_extension(path).is_some() && path.is_file()
}

fn labels_of(labels: &Path, scan: &Path) -> PathBuf {
    labels.join(scan.file_name().unwrap_or_default()).with_extension("json")
}
