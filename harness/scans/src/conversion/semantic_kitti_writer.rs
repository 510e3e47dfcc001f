//! Scans as drives of SemanticKITTI: `.bin` and `.label` files, and the poses and times that are known.
//!
//! Every annotation becomes an instance, numbered anew in each drive by its class and track; boxes are not written. Poles
//! without a track keep instance 0, as in the real labels, if a reader of the format finds the same ones among their points.
//! Points of no annotation become *other ground*, points that are not judged *unlabelled*. Scans are numbered anew in each
//! drive, as poses and times go by number.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Isometry3;
use reports::vocabulary::class::AnnotationClass;

use super::instance_numbers::{InstanceNumbers, MAX_INSTANCES};
use super::kitti_writer::bin_file;
use super::whole_folder::WholeFolder;
use super::{ConversionError, ScanToWrite, ScanWriter};
use crate::annotation::{Annotation, LabeledScan, PointRegion};
use crate::dataset::data_sheet::{DATA_SHEET, DataSheet};
use crate::dataset::folder_name::folder_name;
use crate::dataset::semantic_kitti::semantic_class::{BACKGROUND_NUMBER, UNLABELED_NUMBER, number_of};
use crate::dataset::semantic_kitti::upright_components::upright_components;

/// Name of the format in errors.
const FORMAT: &str = "semantic-kitti";

/// The identity: the poses are the sensor's own.
const CALIBRATION: &str = "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n";

/// A data set that is being written.
pub struct SemanticKittiWriter {
    folder: WholeFolder,
    sheet: DataSheet,
    drives: BTreeMap<String, Drive>,
}

#[derive(Default)]
struct Drive {
    n_scans: usize,
    instances: InstanceNumbers,
    times_s: Vec<f64>,
    poses: Vec<Isometry3<f64>>,
}

impl SemanticKittiWriter {
    /// Begins the folder `path`, with the data sheet `sheet`.
    pub fn create(path: &Path, sheet: DataSheet) -> Result<Self, ConversionError> {
        Ok(Self { folder: WholeFolder::create(path)?, sheet, drives: BTreeMap::new() })
    }
}

impl ScanWriter for SemanticKittiWriter {
    fn write(&mut self, to_write: &ScanToWrite<'_>) -> Result<(), ConversionError> {
        let scan = to_write.scan;
        let name = folder_name(&scan.id.sequence);
        let drive = self.drives.entry(name.clone()).or_default();
        let number = drive.n_scans;
        drive.n_scans += 1;
        drive.times_s.push(to_write.time_ns as f64 / 1e9);
        drive.poses.extend(to_write.world_from_sensor);
        let labels = labels_of(scan, &mut drive.instances)?;
        let labels: Vec<u8> = labels.into_iter().flat_map(u32::to_le_bytes).collect();
        let file = |kind: &str, extension: &str| format!("sequences/{name}/{kind}/{number:06}.{extension}");
        self.folder.write(&file("velodyne", "bin"), &bin_file(scan)?)?;
        self.folder.write(&file("labels", "label"), &labels)
    }

    fn finish(self: Box<Self>) -> Result<(), ConversionError> {
        for (name, drive) in &self.drives {
            let write = |file: &str, text: &str| {
                self.folder.write(&format!("sequences/{name}/{file}"), text.as_bytes())
            };
            write(
                "times.txt",
                &drive.times_s.iter().map(|it| format!("{it}\n")).collect::<Vec<_>>().concat(),
            )?;
            // All or none: a line stands for the scan of its number.
            if drive.poses.len() == drive.n_scans {
                write("poses.txt", &drive.poses.iter().map(pose_line).collect::<String>())?;
                write("calib.txt", CALIBRATION)?;
            }
        }
        self.folder.write(DATA_SHEET, self.sheet.to_json().as_bytes())?;
        self.folder.finish()
    }
}

fn labels_of(scan: &LabeledScan, instances: &mut InstanceNumbers) -> Result<Vec<u32>, ConversionError> {
    let label = |region: &PointRegion| match region {
        PointRegion::Labeled => BACKGROUND_NUMBER,
        PointRegion::Unscorable | PointRegion::Outside => UNLABELED_NUMBER,
    };
    let mut labels: Vec<u32> = scan.point_regions.iter().map(|region| u32::from(label(region))).collect();
    let keeps_zero = poles_hang_together(scan);
    instances.begin_scan();
    for annotation in &scan.annotations {
        let points = scorable_points(scan, annotation);
        if points.is_empty() {
            continue;
        }
        let instance = if keeps_zero && is_pole_without_track(annotation) {
            0
        } else {
            instances.number_of(annotation.class, annotation.track).map_err(|n_objects| {
                let drive = scan.id.sequence.clone();
                ConversionError::TooManyObjects { drive, n_objects, format: FORMAT, max: MAX_INSTANCES }
            })?
        };
        for point_idx in points {
            labels[point_idx as usize] = u32::from(number_of(annotation.class)) | u32::from(instance) << 16;
        }
    }
    Ok(labels)
}

/// The points of an annotation without the unscorable ones, which stay unlabelled.
fn scorable_points(scan: &LabeledScan, annotation: &Annotation) -> Vec<u32> {
    let is_scorable = |it: &u32| scan.point_regions[*it as usize] != PointRegion::Unscorable;
    annotation.point_indices.iter().copied().filter(is_scorable).collect()
}

fn is_pole_without_track(annotation: &Annotation) -> bool {
    annotation.class == AnnotationClass::Pole && annotation.track.is_none()
}

/// Whether the poles without a track are the ones that a reader finds among their points.
fn poles_hang_together(scan: &LabeledScan) -> bool {
    let poles = scan.annotations.iter().filter(|it| is_pole_without_track(it));
    let mut poles: Vec<Vec<u32>> = poles.map(|it| scorable_points(scan, it)).collect();
    poles.retain(|points| !points.is_empty());
    poles.sort_unstable();
    let mut points = poles.concat();
    points.sort_unstable();
    let mut found = upright_components(&scan.cloud, &points);
    found.sort_unstable();
    found == poles
}

fn pose_line(pose: &Isometry3<f64>) -> String {
    let matrix = pose.to_homogeneous();
    let rows = (0..3).flat_map(|row| (0..4).map(move |column| (row, column)));
    let numbers: Vec<String> = rows.map(|at| matrix[at].to_string()).collect();
    numbers.join(" ") + "\n"
}
