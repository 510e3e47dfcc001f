//! Scans in the layouts of KITTI's tracking and object benchmarks.
//!
//! Objects without a box get the one around their points. Where not all is labelled, a file beside every scan gives the
//! region of each point (see [`point_region_file`]).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use detector::fit::convex_hull_box::ConvexHullBox;
use detector::{OrientedBox, PointCloud};

use super::kitti_label_line::{CALIBRATION, label_line};
use super::whole_folder::WholeFolder;
use super::{ConversionError, ScanToWrite, ScanWriter};
use crate::annotation::{Annotation, LabeledScan, PointRegion};
use crate::dataset::data_sheet::{DATA_SHEET, DataSheet, LabeledRegion};
use crate::dataset::folder_name::folder_name;
use crate::dataset::kitti::region_file::{point_region_file, region_bytes};

/// The least side of a box around points that lie in a line, in metres.
const MIN_SIDE_M: f32 = 0.01;

/// One of the two layouts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KittiLayout {
    /// Whole drives.
    Tracking,
    /// Single scans, which are numbered anew.
    Object,
}

/// A data set that is being written.
pub struct KittiWriter {
    layout: KittiLayout,
    folder: WholeFolder,
    sheet: DataSheet,
    // Tracking: the labels of every drive, and the names of the drives as they were.
    labels_by_drive: BTreeMap<String, String>,
    written: BTreeSet<(String, u32)>,
    n_written: u32,
}

impl KittiWriter {
    /// Begins the folder `path`, with the data sheet `sheet`.
    pub fn create(path: &Path, layout: KittiLayout, sheet: DataSheet) -> Result<Self, ConversionError> {
        let sheet = DataSheet { labeled_region: LabeledRegion::PerPoint, ..sheet };
        Ok(Self {
            layout,
            folder: WholeFolder::create(path)?,
            sheet,
            labels_by_drive: BTreeMap::new(),
            written: BTreeSet::new(),
            n_written: 0,
        })
    }

    fn format(&self) -> &'static str {
        match self.layout {
            KittiLayout::Tracking => "kitti-tracking",
            KittiLayout::Object => "kitti-object",
        }
    }
}

impl ScanWriter for KittiWriter {
    fn write(&mut self, to_write: &ScanToWrite<'_>) -> Result<(), ConversionError> {
        let scan = to_write.scan;
        let drive = folder_name(&scan.id.sequence);
        let number = match self.layout {
            KittiLayout::Tracking => scan.id.index,
            KittiLayout::Object => self.n_written,
        };
        if self.layout == KittiLayout::Tracking && !self.written.insert((drive.clone(), number)) {
            let problem = "its drive already has a scan with this number".to_owned();
            let (scan, format) = (scan.id.to_string(), self.format());
            return Err(ConversionError::Unwritable { scan, format, problem });
        }
        self.n_written += 1;
        let name = match self.layout {
            KittiLayout::Tracking => format!("{drive}/{number:06}"),
            KittiLayout::Object => format!("{number:06}"),
        };
        self.folder.write(&format!("training/velodyne/{name}.bin"), &bin_file(scan)?)?;
        if scan.point_regions.iter().any(|it| *it != PointRegion::Labeled) {
            let regions = region_bytes(&scan.point_regions);
            self.folder.write(&format!("training/{}", point_region_file(&name)), &regions)?;
        }
        let labels = labels_of(scan, self.layout, number);
        match self.layout {
            KittiLayout::Tracking => self.labels_by_drive.entry(drive).or_default().push_str(&labels),
            KittiLayout::Object => {
                self.folder.write(&format!("training/label_2/{name}.txt"), labels.as_bytes())?;
                self.folder.write(&format!("training/calib/{name}.txt"), CALIBRATION.as_bytes())?;
            }
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), ConversionError> {
        for (drive, labels) in &self.labels_by_drive {
            self.folder.write(&format!("training/label_02/{drive}.txt"), labels.as_bytes())?;
            self.folder.write(&format!("training/calib/{drive}.txt"), CALIBRATION.as_bytes())?;
        }
        self.folder.write(&format!("training/{DATA_SHEET}"), self.sheet.to_json().as_bytes())?;
        self.folder.finish()
    }
}

/// The points of `scan` as a `.bin` file.
///
/// # Errors
///
/// If there are no points: such a file is taken for a damaged one.
pub fn bin_file(scan: &LabeledScan) -> Result<Vec<u8>, ConversionError> {
    if scan.cloud.is_empty() {
        let problem =
            "it has no points; leave it out with --scans, or write a recording, --to mcap".to_owned();
        return Err(ConversionError::Unwritable { scan: scan.id.to_string(), format: ".bin", problem });
    }
    Ok(bin_bytes(&scan.cloud))
}

/// The points as rows of four numbers.
pub fn bin_bytes(cloud: &PointCloud) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(cloud.len() * 16);
    for ([x, y, z], &intensity) in cloud.positions_m().zip(cloud.intensity()) {
        bytes.extend([x, y, z, intensity].into_iter().flat_map(f32::to_le_bytes));
    }
    bytes
}

fn labels_of(scan: &LabeledScan, layout: KittiLayout, number: u32) -> String {
    let mut labels = String::new();
    for annotation in &scan.annotations {
        let around_points = || box_around(&scan.cloud, &annotation.point_indices);
        let Some(bounding_box) = annotation.bounding_box.or_else(around_points) else { continue };
        let line = match layout {
            KittiLayout::Tracking => {
                let track = annotation.track.map_or("-1".to_owned(), |track| track.to_string());
                let line = label_line(annotation, &bounding_box, &tracking_truncation(annotation));
                format!("{number} {track} {line}\n")
            }
            KittiLayout::Object => {
                let truncation = annotation.truncation.map_or("-1".to_owned(), |share| share.to_string());
                format!("{}\n", label_line(annotation, &bounding_box, &truncation))
            }
        };
        labels.push_str(&line);
    }
    labels
}

/// The share as the tracking benchmark is read, where a whole 1 stands for an unknown one.
fn tracking_truncation(annotation: &Annotation) -> String {
    match annotation.truncation {
        Some(share) if share < 1.0 => share.to_string(),
        Some(_) => "0.9999".to_owned(),
        None => "-1".to_owned(),
    }
}

/// The upright box around these points; `None` if there are none.
fn box_around(cloud: &PointCloud, point_indices: &[u32]) -> Option<OrientedBox> {
    let positions = point_indices.iter().map(|it| cloud.position_m(*it as usize));
    let positions: Vec<[f32; 3]> = positions.filter(|it| it.iter().all(|value| value.is_finite())).collect();
    let z_m = positions.iter().map(|it| it[2]);
    let z_range_m = [z_m.clone().fold(f32::INFINITY, f32::min), z_m.fold(f32::NEG_INFINITY, f32::max)];
    let around = ConvexHullBox::default().fit(positions.iter().map(|it| [it[0], it[1]]), z_range_m)?;
    let length_width_height_m = around.length_width_height_m.map(|side_m| side_m.max(MIN_SIDE_M));
    Some(OrientedBox { length_width_height_m, ..around })
}
