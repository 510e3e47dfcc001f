//! A folder of scans, in the order of their names.
//!
//! ```text
//! NAME.pcd, .ply, .npy, .bin, .las or .laz   the scans, in the folder, or in lidar, pointclouds or velodyne in it
//! labels/NAME.json                           optional: boxes; where there is a folder of labels, every scan has its own
//! ```
//!
//! The folder of labels may be called `labels`, `label` or `label_2`; [`label_file`](super::label_file) says what may be in
//! it.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::any_scan_file::{read_scan_file, scan_extension, scan_origin_m};
use super::label_file::LabelFile;
use super::scan_file::ScanPoints;
use crate::annotation::{Annotation, LabeledArea, LabeledScan, PointRegion, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::class_table::{ClassReader, ClassRules, UnknownClasses};
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::on_disk::{entries_of, has_extension, name_of};
use crate::dataset::points_of_boxes::assign_points_in_boxes;
use crate::dataset::source::DatasetSource;
use crate::dataset::text_file::read_text_file;
use crate::dataset::unpaired_files::UnpairedFiles;
use crate::dataset::{Dataset, DatasetError, Listing, labels_without_scan};

/// Where scans may lie in the folder that is named.
const SCANS: [&str; 4] = ["", "lidar", "pointclouds", "velodyne"];

/// Where labels may.
const LABELS: [&str; 3] = ["labels", "label", "label_2"];

/// An open folder: the names of the scans are in memory.
#[derive(Debug)]
struct ScanFolder {
    // Invariant: `scan_ids` and `scans` have the same length and order.
    listing: Listing,
    scans: Vec<PathBuf>,
    labels: Option<PathBuf>,
    classes: ClassRules,
}

/// Whether scans lie in `folder`.
pub fn is_scan_folder(folder: &Path) -> bool {
    scans_below(folder).is_some()
}

/// The folder with scans: `folder` itself, or one that tools keep them in.
fn scans_below(folder: &Path) -> Option<PathBuf> {
    let has_scans = |folder: &PathBuf| entries_of(folder).is_ok_and(|it| it.iter().any(|it| is_scan(it)));
    SCANS.into_iter().map(|name| folder.join(name)).find(has_scans)
}

/// Opens the folder of `source`. Scans are numbered in the order of their names.
pub fn open_scan_folder(source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let folder = source.path.clone();
    let mut scans = entries_of(&scans_below(&folder).unwrap_or(folder.clone()))?;
    scans.retain(|path| is_scan(path));
    refuse_same_names(&scans)?;
    if scans.is_empty() {
        return Err(DatasetError::no_scans(folder));
    }
    let labels = LABELS.into_iter().map(|it| folder.join(it)).find(|it| it.is_dir());
    let (mut checksum, mut without_labels) = (DatasetChecksum::default(), Vec::new());
    for scan in &scans {
        let name = name_of(scan);
        checksum.add_file(&name, scan)?;
        let file = labels.as_ref().map(|it| LabelFile::find(it, scan)).transpose()?.flatten();
        for (index, file) in file.iter().flat_map(LabelFile::files).enumerate() {
            // The first is that of the labels, the second what they need.
            let kind = ["labels", "calib"][index];
            checksum.add_text(&format!("{kind}/{name}"), &read_text_file(file)?);
        }
        if labels.is_some() && file.is_none() {
            without_labels.push(name);
        }
    }
    if let Some(labels) = labels.as_ref().filter(|_| !without_labels.is_empty()) {
        let unpaired = UnpairedFiles { scans: without_labels, labels: labels_without_scans(labels, &scans)? };
        unpaired.refuse(labels)?;
    }
    let sequence = name_of(&folder.canonicalize().unwrap_or_else(|_| folder.clone()));
    let scan_ids =
        (0..scans.len() as u32).map(|index| ScanId { sequence: sequence.clone(), index }).collect();
    let classes = source.classes.clone();
    let description = source.describe(DatasetFormat::ScanFolder, checksum.finish());
    let listing = Listing { description, scan_ids };
    Ok(Box::new(ScanFolder { listing, scans, labels, classes }))
}

impl Dataset for ScanFolder {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let path = &self.scans[scan_idx];
        let ScanPoints { points, origin_m } = read_scan_file(path)?;
        let (cloud, points_left_out) = points.into_parts();
        let (mut annotations, region) = match &self.labels {
            Some(labels) => {
                let (annotations, unknown) = self.read_labels(labels, path, origin_m)?;
                if !unknown.is_empty() {
                    self.all_unknown_classes(labels).refuse(&self.listing.description.id)?;
                }
                (annotations, PointRegion::Labeled)
            }
            None => (Vec::new(), PointRegion::Outside),
        };
        assign_points_in_boxes(&cloud, &mut annotations);
        let point_regions = vec![region; cloud.len()];
        let id = self.listing.scan_ids[scan_idx].clone();
        let labeled_area = LabeledArea::AsPoints;
        Ok(LabeledScan { id, cloud, annotations, point_regions, labeled_area, points_left_out })
    }

    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        let Some(labels) = &self.labels else { return Ok(Vec::new()) };
        Ok(labels_without_scan(&labels_without_scans(labels, &self.scans)?))
    }

    /// Where the origin was moved to, of scans on a map.
    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        let origin_m = scan_origin_m(&self.scans[scan_idx])?;
        let pose =
            Isometry3::from_parts(Translation3::from(Vector3::from(origin_m)), UnitQuaternion::identity());
        Ok((origin_m != [0.0; 3]).then_some(pose))
    }

    fn scan_n_bytes(&self, scan_idx: usize) -> Option<u64> {
        Some(self.scans[scan_idx].metadata().ok()?.len())
    }
}

impl ScanFolder {
    /// The labels of a scan, and the names of classes in them that nobody knows.
    fn read_labels(
        &self,
        labels: &Path,
        scan: &Path,
        origin_m: [f64; 3],
    ) -> Result<(Vec<Annotation>, UnknownClasses), DatasetError> {
        let file =
            LabelFile::find(labels, scan)?.ok_or_else(|| DatasetError::without_labels(scan, labels))?;
        let texts = file.files().into_iter().map(read_text_file).collect::<Result<Vec<_>, _>>()?;
        let mut classes = ClassReader::new(&self.classes, file.vocabulary());
        let annotations = file.parse(&texts, origin_m, &mut classes)?;
        Ok((annotations, classes.unknown().clone()))
    }

    /// Of all labels that can be read, so that they are said at once.
    fn all_unknown_classes(&self, labels: &Path) -> UnknownClasses {
        let mut all = UnknownClasses::default();
        for scan in &self.scans {
            if let Ok((_, unknown)) = self.read_labels(labels, scan, [0.0; 3]) {
                all.append(&unknown);
            }
        }
        all
    }
}

/// The names of the files in `labels` that belong to none of `scans`, in order.
fn labels_without_scans(labels: &Path, scans: &[PathBuf]) -> Result<Vec<String>, DatasetError> {
    let stems: BTreeSet<&OsStr> = scans.iter().filter_map(|it| it.file_stem()).collect();
    let mut files = entries_of(labels)?;
    files.retain(|path| has_extension(path, "json") || has_extension(path, "txt"));
    // labelCloud's own, beside the labels.
    files.retain(|path| !path.ends_with("_classes.json"));
    files.retain(|path| path.file_stem().is_none_or(|it| !stems.contains(it)));
    Ok(files.iter().map(|it| name_of(it)).collect())
}

/// Scans that differ only in their endings would share their labels.
fn refuse_same_names(scans: &[PathBuf]) -> Result<(), DatasetError> {
    let mut by_stem: BTreeMap<&OsStr, &PathBuf> = BTreeMap::new();
    for scan in scans {
        let stem = scan.file_stem().unwrap_or_default();
        if let Some(other) = by_stem.insert(stem, scan) {
            return Err(DatasetError::same_name("scans", &stem.to_string_lossy(), &[other, scan]));
        }
    }
    Ok(())
}

fn is_scan(path: &Path) -> bool {
    scan_extension(path).is_some() && path.is_file()
}
