//! KITTI's text files: boxes in the rectified camera frame, with the score in the last column.
//!
//! A file for each scan in the object benchmark (`000000.txt`), for each drive in the tracking benchmark (`0001.txt`), whose
//! lines begin with the number of the scan and the track. `DontCare` is skipped. A drive's file holds the detections of all
//! its scans; a scan without a line has none.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::Matrix4;

use super::detections::{ForeignBox, ForeignDetections};
use super::result_files::ResultFiles;
use super::result_reader::{FoundInScan, OpenResults, ResultReader, ResultsOf};
use crate::annotation::{LabeledScan, ScanId};
use crate::dataset::DatasetError;
use crate::dataset::class_table::{ClassReader, ClassRules};
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::kitti::box_in_velodyne::box_in_velodyne;
use crate::dataset::kitti::label::{
    KITTI_VOCABULARY, KittiLabel, KittiObject, UNLIKELY_OCCLUSION, parse_object_labels, parse_tracking_labels,
};
use crate::dataset::text_file::read_text_file;

/// The ending of the files.
pub const ENDING: &str = ".txt";

/// Results in KITTI's layouts.
pub struct KittiText {
    scan_ids: Vec<ScanId>,
    asked: BTreeMap<usize, ForeignFrame>,
    classes: ClassRules,
    // By drive and number of the scan.
    drives: BTreeMap<String, BTreeMap<u32, Vec<KittiLabel>>>,
    files: BTreeMap<usize, PathBuf>,
}

impl KittiText {
    /// Reads the files of drives, and finds those of scans.
    pub fn open(files: &ResultFiles, of: ResultsOf<'_>) -> Result<OpenResults, DatasetError> {
        let [say, lacks] =
            ["has boxes in the frame of KITTI's camera", "has no calibration of such a camera"];
        of.require(files.root(), |it| matches!(it, ForeignFrame::Camera { .. }), say, lacks)?;
        let mut reader = ClassReader::new(of.classes, KITTI_VOCABULARY);
        let (mut drives, mut taken) = (BTreeMap::new(), BTreeSet::new());
        for id in of.dataset.scan_ids() {
            if drives.contains_key(&id.sequence) {
                continue;
            }
            if let Some((_, path)) = files.of_drive(&id.sequence, ENDING) {
                let labels = parse_tracking_labels(path, &read_text_file(path)?, &mut reader)?;
                drives.insert(id.sequence.clone(), labels);
                taken.insert(path);
            }
        }
        reader.unknown().refuse_results(&files.root().display().to_string())?;
        let of_scans = files.of_scans(of.dataset, ENDING);
        taken.extend(of_scans.values().map(PathBuf::as_path));
        let files_left_over = files.left_over(ENDING, &taken);
        let (scan_ids, classes) = (of.dataset.scan_ids().to_vec(), of.classes.clone());
        let results = Self { scan_ids, asked: of.asked, classes, drives, files: of_scans };
        let left_over = [results.left_over(), files_left_over].concat();
        Ok(OpenResults { oddities: results.oddities(), ..OpenResults::new(results, left_over) })
    }

    fn labels_of_file(&self, path: &Path) -> Result<Vec<KittiLabel>, DatasetError> {
        let mut reader = ClassReader::new(&self.classes, KITTI_VOCABULARY);
        let labels = parse_object_labels(path, &read_text_file(path)?, &mut reader)?;
        reader.unknown().refuse_results(&path.display().to_string())?;
        Ok(labels)
    }

    /// The scans in the files of drives that the data set does not have.
    fn left_over(&self) -> Vec<String> {
        let known: BTreeSet<(&str, u32)> =
            self.scan_ids.iter().map(|it| (it.sequence.as_str(), it.index)).collect();
        let numbers =
            self.drives.iter().flat_map(|(drive, scans)| scans.keys().map(move |it| (drive.as_str(), *it)));
        let of_drives =
            numbers.filter(|it| !known.contains(it)).map(|(drive, it)| format!("{drive}/{it:06}"));
        of_drives.collect()
    }

    /// Notes on scans before the first or after the last scan in the file of their drive: they may not have been processed.
    fn oddities(&self) -> Vec<String> {
        let mut oddities = Vec::new();
        for (drive, scans) in &self.drives {
            let ends = scans.first_key_value().zip(scans.last_key_value());
            let Some(((first, _), (last, _))) = ends else { continue };
            let ids = self.asked.keys().map(|it| &self.scan_ids[*it]);
            let n_beyond =
                ids.filter(|it| it.sequence == *drive && !(first..=last).contains(&&it.index)).count();
            if n_beyond > 0 {
                oddities.push(format!(
                    "drive {drive} has results from scan {first} to {last}: of {n_beyond} others it is taken that nothing was \
                     found there"
                ));
            }
        }
        oddities
    }
}

impl ResultReader for KittiText {
    fn has(&self, scan_idx: usize) -> bool {
        self.drives.contains_key(&self.scan_ids[scan_idx].sequence) || self.files.contains_key(&scan_idx)
    }

    fn read(&mut self, scan_idx: usize, _scan: &LabeledScan) -> FoundInScan {
        let id = &self.scan_ids[scan_idx];
        let of_file;
        let labels = match (self.drives.get(&id.sequence), self.files.get(&scan_idx)) {
            (Some(drive), _) => drive.get(&id.index).map_or(&[][..], Vec::as_slice),
            (None, Some(path)) => {
                of_file = self.labels_of_file(path)?;
                &of_file
            }
            (None, None) => return Ok(None),
        };
        let Some(ForeignFrame::Camera { velodyne_from_camera, .. }) = self.asked.get(&scan_idx) else {
            return Ok(None);
        };
        let objects: Vec<KittiObject> = labels.iter().filter_map(KittiLabel::object).cloned().collect();
        let boxes = objects.iter().map(|it| box_of(it, velodyne_from_camera)).collect();
        Ok(Some(ForeignDetections { kitti_objects: Some(objects), ..ForeignDetections::of_boxes(boxes) }))
    }
}

fn box_of(object: &KittiObject, velodyne_from_camera: &Matrix4<f64>) -> ForeignBox {
    ForeignBox {
        bounding_box: box_in_velodyne(&object.camera_box, velodyne_from_camera),
        class: Some(object.class.into()),
        score: object.score.map(|it| it as f32),
        box_score: None,
        velocity_m_per_s: None,
        is_unlikely: object.in_image.occlusion == UNLIKELY_OCCLUSION,
    }
}
