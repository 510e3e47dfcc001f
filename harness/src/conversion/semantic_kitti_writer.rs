//! Scans as drives of SemanticKITTI: `.bin` and `.label` files, and the poses and times that are known.
//!
//! Every annotation becomes an instance; boxes are not written. Points of no annotation become *other ground*, points that are
//! not judged *unlabelled*. Scans and instances are numbered anew in each drive, as poses and times go by number.
//!
//! Poles without a track get no number where the reader finds the same poles again by what hangs together, as in
//! SemanticKITTI itself: a long drive has more of them than there are numbers.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Isometry3;

use super::instance_numbers::InstanceNumbers;
use super::kitti_writer::bin_bytes;
use super::whole_folder::{WholeFolder, folder_name};
use super::{ConversionError, ScanToWrite, ScanWriter};
use crate::annotation::{Annotation, AnnotationClass, LabeledScan, PointRegion};
use crate::dataset::data_sheet::{DATA_SHEET, DataSheet};
use crate::dataset::semantic_kitti::semantic_class::{BACKGROUND_NUMBER, UNLABELED_NUMBER, number_of};
use crate::dataset::semantic_kitti::upright_components::upright_components;

/// The poses are the sensor's own.
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
    times_s: Vec<f64>,
    poses: Vec<Isometry3<f64>>,
    instances: InstanceNumbers,
}

impl SemanticKittiWriter {
    /// Begins the folder `path`, with what `sheet` says about the scans.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if it exists or cannot be written.
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
        let has_position: Vec<bool> =
            scan.cloud.positions_m().map(|it| it.iter().all(|value| value.is_finite())).collect();
        let labels = labels_of(scan, &mut drive.instances)?;
        let kept = labels.into_iter().zip(&has_position).filter(|(_, has_position)| **has_position);
        let labels: Vec<u8> = kept.flat_map(|(label, _)| label.to_le_bytes()).collect();
        let file = |kind: &str, extension: &str| format!("sequences/{name}/{kind}/{number:06}.{extension}");
        self.folder.write(&file("velodyne", "bin"), &bin_bytes(&scan.cloud, &has_position))?;
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
    let poles_are_found_again = are_found_again(scan);
    for annotation in &scan.annotations {
        let instance = if poles_are_found_again && is_lone_pole(annotation) {
            0
        } else {
            instances.number(annotation).map_err(|error| ConversionError::Unwritable {
                scan: scan.id.to_string(),
                format: "semantic-kitti",
                problem: error.to_string(),
            })?
        };
        for point_idx in &annotation.point_indices {
            labels[*point_idx as usize] = u32::from(number_of(annotation.class)) | u32::from(instance) << 16;
        }
    }
    Ok(labels)
}

fn is_lone_pole(annotation: &Annotation) -> bool {
    annotation.class == AnnotationClass::Pole && annotation.track.is_none()
}

/// Whether the poles without a track are what the reader makes of their points together.
fn are_found_again(scan: &LabeledScan) -> bool {
    let poles = || scan.annotations.iter().filter(|it| is_lone_pole(it)).map(|it| &it.point_indices);
    let mut points: Vec<u32> = poles().flatten().copied().collect();
    points.sort_unstable();
    let mut found = upright_components(&scan.cloud, &points);
    let mut expected: Vec<Vec<u32>> = poles().cloned().collect();
    found.sort();
    expected.sort();
    found == expected
}

fn pose_line(pose: &Isometry3<f64>) -> String {
    let matrix = pose.to_homogeneous();
    let rows = (0..3).flat_map(|row| (0..4).map(move |column| (row, column)));
    let numbers: Vec<String> = rows.map(|at| matrix[at].to_string()).collect();
    numbers.join(" ") + "\n"
}
