//! A folder of scans, in the order of their names.
//!
//! ```text
//! NAME.pcd, .ply, .npy, .bin, .las or .laz   the scans, in the folder, or in lidar, pointclouds or velodyne in it
//! labels/NAME.json                           optional: boxes; where there is a folder of labels, every scan has its own
//! ```
//!
//! The folder of labels may be called `labels`, `label` or `label_2`; [`label_file`](super::label_file) lists the formats of
//! its files.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::any_scan_file::{read_scan_file, scan_extension, scan_origin_m};
use super::label_file::{LabelFile, is_labels};
use super::scan_file::ScanPoints;
use crate::annotation::{Annotation, LabeledArea, LabeledScan, PointRegion, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::class_table::{ClassReader, ClassRules, UnknownClasses};
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::on_disk::{entries_of, has_extension, is_there, name_of, stem_of};
use crate::dataset::point_columns::PointColumns;
use crate::dataset::points_of_boxes::assign_points_in_boxes;
use crate::dataset::scan_columns::ScanColumns;
use crate::dataset::scan_sizes::ScanSizes;
use crate::dataset::source::{DamagePolicy, DatasetSource};
use crate::dataset::text_file::read_text_file;
use crate::dataset::unpaired_files::{LeftOut, UnpairedFiles};
use crate::dataset::{Dataset, DatasetError, Listing};

/// Folders of scans below the folder of the data set.
const SCANS: [&str; 4] = ["", "lidar", "pointclouds", "velodyne"];

/// Folders of labels.
const LABELS: [&str; 3] = ["labels", "label", "label_2"];

/// An open folder: the names of the scans are in memory.
#[derive(Debug)]
struct ScanFolder {
    // Invariant: `scan_ids`, `scans` and `names` have the same length and order.
    listing: Listing,
    scans: Vec<PathBuf>,
    names: Vec<String>,
    columns: ScanColumns,
    labels: Option<PathBuf>,
    left_out: Vec<LeftOut>,
    classes: ClassRules,
}

/// Whether scans lie in `folder`.
pub fn is_scan_folder(folder: &Path) -> bool {
    scans_below(folder).is_some()
}

/// Whether a folder of labels lies in `folder`.
pub fn has_labels(folder: &Path) -> bool {
    LABELS.iter().any(|it| folder.join(it).is_dir())
}

/// The folder with scans: `folder` itself, or one in which tools keep them.
fn scans_below(folder: &Path) -> Option<PathBuf> {
    let has_scans = |folder: &PathBuf| entries_of(folder).is_ok_and(|it| it.iter().any(|it| is_scan(it)));
    SCANS.into_iter().map(|name| folder.join(name)).find(has_scans)
}

/// Opens the folder of `source`. Scans have the numbers in the names of their files, or else their positions among the
/// names.
pub fn open_scan_folder(source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let folder = source.path.clone();
    let mut scans = entries_of(&scans_below(&folder).unwrap_or(folder.clone()))?;
    scans.retain(|path| is_scan(path));
    refuse_same_names(&scans)?;
    if scans.is_empty() {
        return Err(DatasetError::no_scans(folder));
    }
    let mut numbered = numbered(scans);
    let labels = LABELS.into_iter().map(|it| folder.join(it)).find(|it| is_there(it));
    let left_out = match &labels {
        Some(labels) => leave_out_unpaired(&mut numbered, labels, source.damage)?,
        None => Vec::new(),
    };
    if numbered.is_empty() {
        return Err(DatasetError::no_scans(folder));
    }
    let checksum = checksum_of(&folder, &numbered, labels.as_deref(), source.damage)?;
    let sequence = name_of(&folder.canonicalize().unwrap_or_else(|_| folder.clone()));
    let scan_id = |(index, _): &(u32, PathBuf)| ScanId { sequence: sequence.clone(), index: *index };
    let scan_ids = numbered.iter().map(scan_id).collect();
    let scans: Vec<PathBuf> = numbered.into_iter().map(|(_, path)| path).collect();
    let names = scans.iter().map(|it| stem_of(it)).collect();
    let columns = ScanColumns::new(source.columns.clone(), PointColumns::of_kitti(), &scans);
    let classes = source.classes.clone();
    let description = source.describe(DatasetFormat::ScanFolder, checksum);
    let listing = Listing { description, scan_ids };
    Ok(Box::new(ScanFolder { listing, scans, names, columns, labels, left_out, classes }))
}

/// `scans` with their numbers: those in their names, if each has one of its own, and sorted by them; or else their
/// positions.
fn numbered(scans: Vec<PathBuf>) -> Vec<(u32, PathBuf)> {
    let number_of = |path: &PathBuf| {
        let stem = path.file_stem()?.to_str()?;
        stem.bytes().all(|it| it.is_ascii_digit()).then(|| stem.parse::<u32>().ok())?
    };
    let numbers: Option<Vec<u32>> = scans.iter().map(number_of).collect();
    let are_own = |numbers: &Vec<u32>| numbers.iter().collect::<BTreeSet<_>>().len() == numbers.len();
    let mut numbered: Vec<(u32, PathBuf)> = match numbers.filter(are_own) {
        Some(numbers) => numbers.into_iter().zip(scans).collect(),
        None => (0..).zip(scans).collect(),
    };
    numbered.sort_unstable();
    numbered
}

/// Takes scans without labels out of `scans` if damage is skipped; returns them and labels without a scan.
fn leave_out_unpaired(
    scans: &mut Vec<(u32, PathBuf)>,
    labels: &Path,
    damage: DamagePolicy,
) -> Result<Vec<LeftOut>, DatasetError> {
    let all: Vec<PathBuf> = scans.iter().map(|(_, path)| path.clone()).collect();
    let mut without_labels = BTreeSet::new();
    for scan in &all {
        if LabelFile::find(labels, scan)?.is_none() {
            without_labels.insert(scan);
        }
    }
    if let Some(other) = other_file_of(labels, &without_labels)?.filter(|_| damage == DamagePolicy::Refuse) {
        let problem =
            "is named as a scan, but is not read: labels are NAME.json, or NAME.txt as KITTI has them"
                .to_owned();
        return Err(DatasetError::damaged(other, problem));
    }
    scans.retain(|(_, path)| !without_labels.contains(path));
    let without_scan = labels_without_scans(labels, &all)?;
    let unpaired = UnpairedFiles {
        scans: without_labels.iter().map(|it| name_of(it)).collect(),
        labels: without_scan.into_iter().filter(|it| is_label_file(it)).map(|it| name_of(&it)).collect(),
    };
    unpaired.left_out(labels, damage)
}

fn checksum_of(
    folder: &Path,
    scans: &[(u32, PathBuf)],
    labels: Option<&Path>,
    damage: DamagePolicy,
) -> Result<String, DatasetError> {
    let (mut checksum, mut sizes) = (DatasetChecksum::default(), ScanSizes::default());
    for (_, scan) in scans {
        let name = name_of(scan);
        checksum.add_scan(&name, sizes.n_bytes_of(scan));
        let file = labels.map(|it| LabelFile::find(it, scan)).transpose()?.flatten();
        for (index, file) in file.iter().flat_map(LabelFile::files).enumerate() {
            // The first is the file of the labels, the second the calibration.
            let kind = ["labels", "calib"][index];
            checksum.add_text(&format!("{kind}/{name}"), &read_text_file(file)?);
        }
    }
    sizes.check(folder, damage)?;
    Ok(checksum.finish())
}

impl Dataset for ScanFolder {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let path = &self.scans[scan_idx];
        let ScanPoints { points, origin_m } = read_scan_file(path, &self.columns)?;
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

    fn columns(&self) -> Result<Option<String>, DatasetError> {
        self.columns.described()
    }

    /// Labels of all scans in one file are not read.
    fn note_of_labels(&self) -> Option<String> {
        let root = self.listing.description.root.as_ref().filter(|_| self.labels.is_none())?;
        let is_of_labels = |it: &PathBuf| it.is_file() && stem_of(it).to_lowercase().contains("label");
        let file = entries_of(root).ok()?.into_iter().find(is_of_labels)?;
        let name = name_of(&file);
        Some(format!("{name:?} is not read: every scan has a file of its own in a folder `labels`"))
    }

    fn file_name(&self, scan_idx: usize) -> Option<&str> {
        self.names.get(scan_idx).map(String::as_str)
    }

    fn files_left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// The origin that a scan on a map was moved to.
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
    /// The labels of a scan, and the unknown names of classes in them.
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

    /// The unknown classes of all labels that can be read, so that one error names them all.
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

/// The files in `labels` that are named after none of `scans`, in order.
fn labels_without_scans(labels: &Path, scans: &[PathBuf]) -> Result<Vec<PathBuf>, DatasetError> {
    let stems: BTreeSet<&OsStr> = scans.iter().filter_map(|it| it.file_stem()).collect();
    let mut files = entries_of(labels)?;
    files.retain(|path| has_extension(path, "json") || has_extension(path, "txt"));
    // A file of labelCloud's own, beside the labels.
    files.retain(|path| !path.ends_with("_classes.json"));
    files.retain(|path| path.file_stem().is_none_or(|it| !stems.contains(it)));
    Ok(files)
}

/// The first file in `labels` that has the name of one of `scans`, and an ending that no labels have.
fn other_file_of(labels: &Path, scans: &BTreeSet<&PathBuf>) -> Result<Option<PathBuf>, DatasetError> {
    let stems: BTreeSet<&OsStr> = scans.iter().filter_map(|it| it.file_stem()).collect();
    let files = entries_of(labels)?;
    Ok(files.into_iter().find(|it| it.is_file() && it.file_stem().is_some_and(|it| stems.contains(it))))
}

/// Whether the file at `path` holds labels, and is no other file beside them, such as a readme or a list of classes.
fn is_label_file(path: &Path) -> bool {
    let is_number = || stem_of(path).bytes().all(|it| it.is_ascii_digit());
    is_number() || read_text_file(path).map_or(true, |text| is_labels(path, &text))
}

/// Fails if scans differ only in their endings: they would share their labels.
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

/// Also true for a broken link, which is refused by name later.
fn is_scan(path: &Path) -> bool {
    scan_extension(path).is_some() && !path.is_dir()
}
