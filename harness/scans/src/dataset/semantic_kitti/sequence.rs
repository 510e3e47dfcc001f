//! SemanticKITTI's folders.
//!
//! ```text
//! sequences/NN/velodyne/NNNNNN.bin
//! sequences/NN/labels/NNNNNN.label    drives without this folder are the test split and left out
//! sequences/NN/poses.txt, times.txt   optional, one line a scan; calib.txt goes with the poses
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::Isometry3;

use super::ground_truth::{class_of_number, label_scan};
use super::label_file::{parse_label_file, read_labels_of_kept};
use super::pose_file::{parse_camera_from_sensor, parse_poses, parse_times};
use crate::annotation::{LabeledScan, ScanId};
use crate::dataset::class_table::{ClassReader, ClassRules, UnknownClasses};
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::kitti::split_folder::SplitFolder;
use crate::dataset::numbered_files::{SIX_DIGITS, numbered_file, numbered_files};
use crate::dataset::on_disk::{bytes_of, entries_of, is_there, names_of};
use crate::dataset::point_columns::PointColumns;
use crate::dataset::scan_columns::ScanColumns;
use crate::dataset::source::{DamagePolicy, DatasetSource};
use crate::dataset::unpaired_files::{LeftOut, UnpairedFiles};
use crate::dataset::{Dataset, DatasetError, Listing};

const SEQUENCES: &str = "sequences";
const SCANS: &str = "velodyne";
const LABELS: &str = "labels";

/// An open SemanticKITTI data set: poses and times are in memory, scans and labels are read one at a time.
#[derive(Debug)]
struct SemanticKitti {
    // Invariant: `sequences` has every sequence that `scan_ids` names.
    listing: Listing,
    sequences: BTreeMap<String, Sequence>,
    columns: ScanColumns,
    left_out: Vec<LeftOut>,
    classes: ClassRules,
}

/// Times and poses of the sensor, by number of the scan; empty if the files do not state them.
#[derive(Debug, Clone)]
struct Sequence {
    times_ns: Vec<u64>,
    world_from_sensor: Vec<Isometry3<f64>>,
}

/// Whether `folder` looks like SemanticKITTI.
pub fn is_semantic_kitti(folder: &Path) -> bool {
    let is_sequence = |it: &PathBuf| it.join(SCANS).is_dir() || it.join(LABELS).is_dir();
    entries_of(&folder.join(SEQUENCES)).is_ok_and(|it| it.iter().any(is_sequence))
}

/// Opens the folder of `source`: all drives that have labels, or only those of `sequences`.
///
/// No scan and no label is read.
pub fn open_semantic_kitti(mut source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let sequences = source.parts.sequences.take();
    let mut folder = SplitFolder::unchecked(&source.path);
    let present = labeled_sequences(&folder)?;
    if let Some(missing) = sequences.iter().flatten().find(|name| !present.contains(*name)) {
        let path = folder.path_of(&format!("{SEQUENCES}/{missing}/{LABELS}"));
        return Err(DatasetError::missing_selected(&path));
    }
    let (mut scan_ids, mut opened) = (Vec::new(), BTreeMap::new());
    let (mut paths, mut left_out) = (Vec::new(), Vec::new());
    for name in sequences.as_ref().unwrap_or(&present) {
        let numbers = scan_numbers(&mut folder, name, source.damage, &mut left_out)?;
        opened.insert(name.clone(), open_sequence(&mut folder, name, &numbers)?);
        let scans = folder.path_of(&format!("{SEQUENCES}/{name}/{SCANS}"));
        paths.extend(numbers.iter().map(|number| numbered_file(&scans, *number, "bin")));
        scan_ids.extend(numbers.into_iter().map(|index| ScanId { sequence: name.clone(), index }));
    }
    if scan_ids.is_empty() {
        return Err(DatasetError::no_scans(folder.path_of(SEQUENCES)));
    }
    let classes = source.classes.clone();
    let columns = ScanColumns::new(source.columns.clone(), PointColumns::of_kitti(), &paths);
    let checksum = folder.finish(source.damage)?;
    let description = source.describe(DatasetFormat::SemanticKitti, checksum);
    let listing = Listing { description, scan_ids };
    Ok(Box::new(SemanticKitti { listing, sequences: opened, columns, left_out, classes }))
}

impl Dataset for SemanticKitti {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let id = self.listing.scan_ids[scan_idx].clone();
        let points = self.columns.read(&self.file(&id, SCANS, "bin"))?;
        let path = self.label_file(&id);
        let labels = parse_label_file(&path, &bytes_of(&path)?, points.n_in_file())?;
        let mut classes = ClassReader::new(&self.classes, &[]);
        let scan = label_scan(id, points, &labels, &path, &mut classes);
        if !classes.unknown().is_empty() {
            self.all_unknown_classes().refuse(&self.listing.description.id)?;
        }
        Ok(scan)
    }

    fn columns(&self) -> Result<Option<String>, DatasetError> {
        self.columns.described()
    }

    fn files_left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    fn point_labels(&self, scan_idx: usize, scan: &LabeledScan) -> Result<Option<Vec<u32>>, DatasetError> {
        let path = self.label_file(&self.listing.scan_ids[scan_idx]);
        read_labels_of_kept(&path, scan).map(Some)
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        let id = &self.listing.scan_ids[scan_idx];
        self.sequences[&id.sequence].times_ns.get(id.index as usize).copied()
    }

    fn scan_n_bytes(&self, scan_idx: usize) -> Option<u64> {
        Some(self.file(&self.listing.scan_ids[scan_idx], SCANS, "bin").metadata().ok()?.len())
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        let id = &self.listing.scan_ids[scan_idx];
        Ok(self.sequences[&id.sequence].world_from_sensor.get(id.index as usize).copied())
    }
}

impl SemanticKitti {
    fn file(&self, id: &ScanId, kind: &str, extension: &str) -> PathBuf {
        let root = self.listing.description.root.as_deref().expect("it was recorded");
        numbered_file(&root.join(SEQUENCES).join(&id.sequence).join(kind), id.index, extension)
    }

    fn label_file(&self, id: &ScanId) -> PathBuf {
        self.file(id, LABELS, "label")
    }

    /// The unknown classes of all labels that can be read, so that one error names them all.
    fn all_unknown_classes(&self) -> UnknownClasses {
        let mut classes = ClassReader::new(&self.classes, &[]);
        for path in self.listing.scan_ids.iter().map(|id| self.label_file(id)) {
            // A file that cannot be read fails when its scan is read.
            let bytes = bytes_of(&path).unwrap_or_default();
            let (labels, _) = bytes.as_chunks::<4>();
            for (point_idx, &[low, high, _, _]) in labels.iter().enumerate() {
                let position = || format!("{path:?}, point {point_idx}");
                class_of_number(u16::from_le_bytes([low, high]), &mut classes, position);
            }
        }
        classes.unknown().clone()
    }
}

fn labeled_sequences(folder: &SplitFolder) -> Result<BTreeSet<String>, DatasetError> {
    let sequences = folder.path_of(SEQUENCES);
    let labeled: Vec<PathBuf> =
        entries_of(&sequences)?.into_iter().filter(|it| is_there(&it.join(LABELS))).collect();
    let names: BTreeSet<String> = names_of(&labeled, "the UTF-8 name of a sequence")?.into_iter().collect();
    if names.is_empty() {
        let (scans, labels) = (sequences.clone(), sequences.join(format!("*/{LABELS}")));
        return Err(DatasetError::unlabeled(&scans, &labels));
    }
    Ok(names)
}

/// The numbers of the scans of sequence `name` that have labels, at least one; other files are added to `left_out`.
fn scan_numbers(
    folder: &mut SplitFolder,
    name: &str,
    damage: DamagePolicy,
    left_out: &mut Vec<LeftOut>,
) -> Result<BTreeSet<u32>, DatasetError> {
    let path_of = |folder: &SplitFolder, kind: &str| folder.path_of(&format!("{SEQUENCES}/{name}/{kind}"));
    let (scans, labels) = (path_of(folder, SCANS), path_of(folder, LABELS));
    let (mut numbers, labeled) =
        (numbered_files(&scans, "bin", SIX_DIGITS)?, numbered_files(&labels, "label", SIX_DIGITS)?);
    let unpaired = UnpairedFiles {
        scans: numbers.difference(&labeled).map(|number| format!("{number:06}.bin")).collect(),
        labels: labeled.difference(&numbers).map(|number| format!("{number:06}.label")).collect(),
    };
    left_out.extend(unpaired.left_out(&labels, damage)?);
    numbers.retain(|number| labeled.contains(number));
    if numbers.is_empty() {
        return Err(DatasetError::no_scans(scans));
    }
    for number in &numbers {
        folder.add_scan(&format!("{SEQUENCES}/{name}/{SCANS}/{number:06}.bin"));
        folder.add_scan(&format!("{SEQUENCES}/{name}/{LABELS}/{number:06}.label"));
    }
    Ok(numbers)
}

fn open_sequence(
    folder: &mut SplitFolder,
    name: &str,
    numbers: &BTreeSet<u32>,
) -> Result<Sequence, DatasetError> {
    let file = |kind: &str| format!("{SEQUENCES}/{name}/{kind}.txt");
    let times_ns = match folder.read_text_if_present(&file("times"))? {
        Some(text) => parse_times(&folder.path_of(&file("times")), &text)?,
        None => Vec::new(),
    };
    let world_from_sensor = match folder.read_text_if_present(&file("poses"))? {
        Some(text) => {
            let scan = folder.path_of(&format!("{SEQUENCES}/{name}/{SCANS}"));
            let calibration = folder.read_text(&file("calib"), |calibration| {
                DatasetError::without_calibration(&scan, calibration)
            })?;
            let camera_from_sensor = parse_camera_from_sensor(&folder.path_of(&file("calib")), &calibration)?;
            let poses = parse_poses(&folder.path_of(&file("poses")), &text)?;
            // The world is the frame of the sensor at the first scan, as that of the poses is the frame of the camera.
            let world_from_camera = |pose: Isometry3<f64>| camera_from_sensor.inverse() * pose;
            poses.into_iter().map(|pose| world_from_camera(pose) * camera_from_sensor).collect()
        }
        None => Vec::new(),
    };
    let n_needed = numbers.last().map_or(0, |number| *number as usize + 1);
    for (kind, n_lines) in [("times", times_ns.len()), ("poses", world_from_sensor.len())] {
        if n_lines > 0 && n_lines < n_needed {
            let problem = format!("has {n_lines} lines, but the last scan is {}", n_needed - 1);
            return Err(DatasetError::Damaged { path: folder.path_of(&file(kind)), problem });
        }
    }
    Ok(Sequence { times_ns, world_from_sensor })
}
