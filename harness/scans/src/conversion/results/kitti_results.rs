//! KITTI's text files of results, in `data` as its evaluators look for them.
//!
//! Detections have KITTI's word for the class that their detector gives. Vehicles without one are `Car`, everything else is
//! `Misc`, which the evaluators pass over as they do unknown words. Boxes that the camera does not see have no
//! rectangle in the image (-1), and the evaluators pass over these as well. The score is that of the box. A detection
//! without one has 1. Unlikely vehicles have an occlusion of their own, which evaluators do not look at.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use detector::DetectorOutput;

use super::class_words::kitti_word;
use super::detection_rows::SCORE_OF_NONE;
use super::{CompleteFiles, ResultFile, ResultWriter, ranked, unwritable};
use crate::annotation::LabeledScan;
use crate::conversion::kitti_label_line::wrapped;
use crate::conversion::kitti_writer::KittiLayout;
use crate::dataset::folder_name::folder_name;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::kitti::box_in_velodyne::box_in_camera;
use crate::dataset::kitti::image_box::image_box;
use crate::dataset::kitti::label::UNLIKELY_OCCLUSION;

/// Results in one of KITTI's layouts.
pub struct KittiResults {
    layout: KittiLayout,
    // Tracking: the lines of every drive.
    lines_by_drive: BTreeMap<String, String>,
}

impl KittiResults {
    /// Begins results without any lines.
    pub fn new(layout: KittiLayout) -> Self {
        Self { layout, lines_by_drive: BTreeMap::new() }
    }
}

impl ResultWriter for KittiResults {
    fn add(&mut self, scan: &LabeledScan, frame: &ForeignFrame, output: &DetectorOutput) -> CompleteFiles {
        let ForeignFrame::Camera { velodyne_from_camera, image_from_velodyne, image_size_px } = frame else {
            return Err(unwritable(scan, "kitti", "its data set has no calibration of KITTI's cameras"));
        };
        let mut lines = String::new();
        for (detection, is_unlikely) in ranked(output) {
            let camera_box = box_in_camera(&detection.bounding_box, velodyne_from_camera);
            let [left_px, top_px, right_px, bottom_px] =
                image_box(&detection.bounding_box, image_from_velodyne, *image_size_px).unwrap_or([-1.0; 4]);
            let [x, y, z] = camera_box.bottom_center_m;
            let [height_m, width_m, length_m] = camera_box.height_width_length_m;
            let rotation_y_rad = camera_box.rotation_y_rad;
            let alpha_rad = wrapped(rotation_y_rad - x.atan2(z));
            if self.layout == KittiLayout::Tracking {
                let _ = write!(lines, "{} -1 ", scan.id.index);
            }
            let occlusion = if is_unlikely { UNLIKELY_OCCLUSION } else { -1 };
            let _ = writeln!(
                lines,
                "{} -1 {occlusion} {alpha_rad:.6} {left_px:.2} {top_px:.2} {right_px:.2} {bottom_px:.2} {height_m} {width_m} {length_m} \
                 {x:.6} {y:.6} {z:.6} {rotation_y_rad:.7} {}",
                kitti_word(&detection),
                detection.box_score().unwrap_or(SCORE_OF_NONE)
            );
        }
        Ok(match self.layout {
            KittiLayout::Object => {
                vec![ResultFile {
                    name: format!("data/{:06}.txt", scan.id.index),
                    content: lines.into_bytes(),
                }]
            }
            KittiLayout::Tracking => {
                self.lines_by_drive.entry(folder_name(&scan.id.sequence)).or_default().push_str(&lines);
                Vec::new()
            }
        })
    }

    fn finish(self: Box<Self>) -> CompleteFiles {
        let files = self.lines_by_drive.into_iter();
        let file = |(drive, lines): (String, String)| ResultFile {
            name: format!("data/{drive}.txt"),
            content: lines.into_bytes(),
        };
        Ok(files.map(file).collect())
    }
}
