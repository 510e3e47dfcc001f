//! A submission of nuScenes: `results_nusc.json`, boxes in the frame of the world.
//!
//! Detections have the name for the class that their detector gives. Vehicles without one are `car`. Other objects have no
//! name there and are left out. Velocities are those that the detector gives, or 0; attributes are empty.
//!
//! The score is that of the box; a detection without one has 1. The format wants it between 0 and 1: where any is outside,
//! all are taken as log odds and written as probabilities, in the same order. A key of ours says which vehicles are unlikely.

use detector::DetectorOutput;
use reports::vocabulary::protocol::Protocol;
use serde_json::{Map, Value, json};

use super::class_words::word_among;
use super::detection_rows::SCORE_OF_NONE;
use super::{CompleteFiles, ResultFile, ResultWriter, ranked, unwritable};
use crate::annotation::LabeledScan;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::official::{UNLIKELY, turned_velocity};
use crate::dataset::upright_box::pose_of_box;

/// The name of the file.
const NAME: &str = "results_nusc.json";

/// A submission that is being filled.
#[derive(Default)]
pub struct NuScenesResults {
    boxes_by_sample: Map<String, Value>,
    has_log_odds: bool,
}

impl ResultWriter for NuScenesResults {
    fn add(&mut self, scan: &LabeledScan, frame: &ForeignFrame, output: &DetectorOutput) -> CompleteFiles {
        let ForeignFrame::World { sample_token, world_from_sensor } = frame else {
            return Err(unwritable(scan, "nuscenes", "its data set has no samples of nuScenes"));
        };
        let mut boxes = Vec::new();
        let words = Protocol::Nuscenes.ranked_classes();
        for (detection, is_unlikely) in ranked(output) {
            let Some(name) = word_among(&detection, words, |it| it.nuscenes.as_deref()) else { continue };
            let score = f64::from(detection.box_score().unwrap_or(SCORE_OF_NONE));
            self.has_log_odds |= !(0.0..=1.0).contains(&score);
            let world_from_box = world_from_sensor * pose_of_box(&detection.bounding_box);
            let at = world_from_box.translation.vector;
            let turn = world_from_box.rotation;
            let [length_m, width_m, height_m] = detection.bounding_box.length_width_height_m.map(f64::from);
            // Without a velocity an object counts as standing still.
            let velocity = detection.box_details.velocity_m_per_s.unwrap_or_default().map(f64::from);
            let velocity = turned_velocity(velocity, &world_from_sensor.rotation);
            let mut record = json!({
                "sample_token": sample_token,
                "translation": [at.x, at.y, at.z],
                "size": [width_m, length_m, height_m],
                "rotation": [turn.w, turn.i, turn.j, turn.k],
                "velocity": velocity,
                "detection_name": name,
                "detection_score": score,
                "attribute_name": "",
            });
            if is_unlikely {
                record[UNLIKELY] = Value::Bool(true);
            }
            boxes.push(record);
        }
        self.boxes_by_sample.insert(sample_token.clone(), Value::Array(boxes));
        Ok(Vec::new())
    }

    fn finish(mut self: Box<Self>) -> CompleteFiles {
        if self.has_log_odds {
            let boxes = self.boxes_by_sample.values_mut().filter_map(Value::as_array_mut).flatten();
            for score in boxes.filter_map(|it| it.get_mut("detection_score")) {
                *score = json!(probability(score.as_f64().unwrap_or_default()));
            }
        }
        let uses = |sensor: &str| (format!("use_{sensor}"), Value::Bool(sensor == "lidar"));
        let meta: Map<String, Value> =
            ["camera", "lidar", "radar", "map", "external"].into_iter().map(uses).collect();
        let submission = json!({"meta": meta, "results": self.boxes_by_sample});
        Ok(vec![ResultFile { name: NAME.to_owned(), content: submission.to_string().into_bytes() }])
    }

    fn has_objects(&self) -> bool {
        false
    }
}

fn probability(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

#[cfg(test)]
mod tests {
    use detector::{DetectedClass, Detection, Detections, OrientedBox};
    use nalgebra::Isometry3;

    use super::*;
    use crate::annotation::ScanId;
    use crate::dataset::positioned_points::PositionedPoints;

    fn written(scores: &[Option<f32>]) -> Vec<f64> {
        let scan = PositionedPoints::default()
            .labeled_everywhere(ScanId { sequence: "scene-0103".to_owned(), index: 0 }, Vec::new());
        let frame = ForeignFrame::World {
            sample_token: "sample".to_owned(),
            world_from_sensor: Isometry3::identity(),
        };
        let bounding_box =
            OrientedBox { center_m: [8.0, 3.0, -1.0], length_width_height_m: [4.2, 1.8, 1.3], yaw_rad: 0.0 };
        let mut detections = Detections::default();
        for score in scores {
            detections.push(Detection::new(&[], bounding_box, DetectedClass::Vehicle, *score));
        }
        let mut results = Box::<NuScenesResults>::default();
        let output = DetectorOutput { detections, ..DetectorOutput::default() };
        results.add(&scan, &frame, &output).unwrap();
        let files = results.finish().unwrap();
        let submission: Value = serde_json::from_slice(&files[0].content).unwrap();
        let boxes = submission["results"]["sample"].as_array().unwrap();
        boxes.iter().map(|it| it["detection_score"].as_f64().unwrap()).collect()
    }

    #[test]
    fn scores_are_between_0_and_1_and_stay_as_they_are_where_all_were() {
        assert_eq!(written(&[Some(0.25), None, Some(0.0)]), [0.25, 1.0, 0.0]);
        let odds = [1.0 / 3.0, 9.0];
        let as_probabilities = written(&odds.map(|it: f32| Some(it.ln())));
        assert!((as_probabilities[0] - 0.25).abs() < 1e-6 && (as_probabilities[1] - 0.9).abs() < 1e-6);
        let apart = written(&[Some(-40.0), Some(0.0), Some(30.0)]);
        assert!(0.0 < apart[0] && apart[0] < apart[1] && apart[1] < apart[2] && apart[2] < 1.0, "{apart:?}");
    }
}
