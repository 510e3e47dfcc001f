//! A submission of nuScenes: `results_nusc.json`, boxes in the frame of the world.
//!
//! Vehicles are `car`: detectors do not tell them from trucks. Other objects have no class there and are left out. The score is that of the box. A detection without one has 1.
//! Velocities are 0 and attributes empty.

use detector::{DetectedClass, Detections};
use serde_json::{Map, Value, json};

use super::detection_rows::SCORE_OF_NONE;
use super::{ResultFile, ResultWriter, unwritable};
use crate::annotation::LabeledScan;
use crate::conversion::ConversionError;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::upright_box::pose_of_box;

/// The name of the file.
const NAME: &str = "results_nusc.json";

/// A submission that grows.
#[derive(Default)]
pub struct NuScenesResults {
    boxes_by_sample: Map<String, Value>,
    n_left_out: u64,
}

impl ResultWriter for NuScenesResults {
    fn add(
        &mut self,
        scan: &LabeledScan,
        frame: &ForeignFrame,
        detections: &Detections,
    ) -> Result<Vec<ResultFile>, ConversionError> {
        let ForeignFrame::World { sample_token, world_from_sensor } = frame else {
            return Err(unwritable(scan, "nuscenes", "its data set has no samples of nuScenes"));
        };
        let mut boxes = Vec::new();
        for detection in detections.iter() {
            if detection.class != DetectedClass::Vehicle {
                self.n_left_out += 1;
                continue;
            }
            let world_from_box = world_from_sensor * pose_of_box(&detection.bounding_box);
            let at = world_from_box.translation.vector;
            let turn = world_from_box.rotation;
            let [length_m, width_m, height_m] = detection.bounding_box.length_width_height_m.map(f64::from);
            boxes.push(json!({
                "sample_token": sample_token,
                "translation": [at.x, at.y, at.z],
                "size": [width_m, length_m, height_m],
                "rotation": [turn.w, turn.i, turn.j, turn.k],
                "velocity": [0.0, 0.0],
                "detection_name": "car",
                "detection_score": detection.box_score().unwrap_or(SCORE_OF_NONE),
                "attribute_name": "",
            }));
        }
        self.boxes_by_sample.insert(sample_token.clone(), Value::Array(boxes));
        Ok(Vec::new())
    }

    fn finish(self: Box<Self>) -> Result<Vec<ResultFile>, ConversionError> {
        let uses = |sensor: &str| (format!("use_{sensor}"), Value::Bool(sensor == "lidar"));
        let meta: Map<String, Value> =
            ["camera", "lidar", "radar", "map", "external"].into_iter().map(uses).collect();
        let submission = json!({"meta": meta, "results": self.boxes_by_sample});
        Ok(vec![ResultFile { name: NAME.to_owned(), content: submission.to_string().into_bytes() }])
    }

    fn n_left_out(&self) -> u64 {
        self.n_left_out
    }
}
