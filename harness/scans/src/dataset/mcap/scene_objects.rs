//! Objects with boxes, from messages of any kind, in the sensor frame.

use detector::OrientedBox;
use nalgebra::Isometry3;
use reports::vocabulary::class::{AnnotationClass, Occlusion};

use super::foxglove_messages::{Timestamp, decode};
use super::foxglove_scene::{SceneEntity, SceneUpdate};
use super::ros_messages::{Detection3D, detection_3d_array};
use super::topics::MessageKind;
use crate::annotation::Annotation;
use crate::dataset::upright_box::upright_box;

/// The names of an object's values in the metadata of Foxglove's scene entities.
pub mod keys {
    /// Its class.
    pub const CLASS: &str = "class";
    /// Its number within the drive.
    pub const TRACK: &str = "track";
    /// How much of it is hidden.
    pub const OCCLUSION: &str = "occlusion";
    /// Share of it outside the labelled region.
    pub const TRUNCATION: &str = "truncation";
    /// How sure a detector is of it.
    pub const SCORE: &str = "score";
}

/// The names of the class in the recordings of others.
const CLASS_KEYS: [&str; 5] = [keys::CLASS, "label", "category", "type", "name"];

/// The names of the score.
const SCORE_KEYS: [&str; 3] = [keys::SCORE, "confidence", "probability"];

/// An object in the frame stated in its message.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneObject {
    /// The frame of its box; empty if it is that of the message.
    pub frame: String,
    /// The name of its class; empty if it has none.
    pub class_name: String,
    /// The pose of its box, and its extent along its own axes in metres.
    pub frame_from_box: Option<(Isometry3<f64>, [f64; 3])>,
    /// Its number within the drive.
    pub track: Option<u32>,
    /// How much of it is hidden.
    pub occlusion: Option<Occlusion>,
    /// Share of it outside the labelled region.
    pub truncation: Option<f32>,
    /// How sure a detector is of it.
    pub score: Option<f32>,
}

impl SceneObject {
    /// The object as an annotation of `class` without points, by the transform from its frame to the sensor's.
    ///
    /// The box is set upright. Errors are the rest of a sentence about the file.
    pub fn annotation(
        &self,
        class: AnnotationClass,
        sensor_from_frame: &Isometry3<f64>,
    ) -> Result<Annotation, String> {
        let bounding_box = self
            .frame_from_box
            .as_ref()
            .map(|(frame_from_box, size_m)| sensible_box(&(sensor_from_frame * frame_from_box), *size_m))
            .transpose()?;
        let Self { track, occlusion, truncation, .. } = *self;
        Ok(Annotation { bounding_box, track, occlusion, truncation, ..Annotation::of(class) })
    }
}

fn sensible_box(sensor_from_box: &Isometry3<f64>, size_m: [f64; 3]) -> Result<OrientedBox, String> {
    let center_m: [f64; 3] = sensor_from_box.translation.vector.into();
    // Larger values are mistakes, and their sums of squares would overflow in single precision.
    let is_sensible =
        center_m.iter().all(|it| it.abs() < 1e9) && size_m.iter().all(|it| *it > 0.0 && *it < 1e9);
    if !is_sensible {
        return Err(format!("has a box at {center_m:?} m with sides of {size_m:?} m"));
    }
    Ok(upright_box(sensor_from_box, size_m))
}

/// The objects in `bytes`, a message of this kind in the encoding of its channel, and its time stamp in nanoseconds; 0 if it
/// has none. Errors are the rest of a sentence about the file.
pub fn objects_of_message(
    kind: MessageKind,
    encoding: &str,
    bytes: &[u8],
) -> Result<(u64, Vec<SceneObject>), String> {
    if kind == MessageKind::RosDetections {
        let (header, detections) = detection_3d_array(bytes)?;
        let mut objects = objects_of_detections(&detections);
        for object in objects.iter_mut().filter(|it| it.frame.is_empty()) {
            object.frame.clone_from(&header.frame);
        }
        // Some messages have time stamps only in their objects.
        let stamps_ns = std::iter::once(&header).chain(detections.iter().map(|it| &it.header));
        let stamp_ns = stamps_ns.map(|it| it.stamp_ns).find(|it| *it > 0);
        return Ok((stamp_ns.unwrap_or(0), objects));
    }
    let scene: SceneUpdate = decode(encoding, bytes)?;
    let stamps = scene.entities.iter().map(|it| it.timestamp);
    let stamps = stamps.chain(scene.deletions.iter().map(|it| it.timestamp)).flatten();
    let stamp_ns = stamps.map(Timestamp::nanoseconds).find(|it| *it > 0);
    Ok((stamp_ns.unwrap_or(0), objects_of_scene(&scene)?))
}

/// The objects of a scene, in order. Errors are the rest of a sentence about the file.
fn objects_of_scene(scene: &SceneUpdate) -> Result<Vec<SceneObject>, String> {
    scene.entities.iter().map(object_of_entity).collect()
}

fn object_of_entity(entity: &SceneEntity) -> Result<SceneObject, String> {
    let value = |key: &str| entity.metadata.iter().find(|it| it.key == key).map(|it| it.value.as_str());
    let frame_from_box = match entity.cubes.first() {
        None => None,
        Some(cube) => {
            let size = cube.size.unwrap_or_default();
            Some((cube.pose.unwrap_or_default().isometry()?, [size.x, size.y, size.z]))
        }
    };
    let occlusion = [Occlusion::None, Occlusion::Partly, Occlusion::Largely];
    Ok(SceneObject {
        frame: entity.frame_id.clone(),
        class_name: CLASS_KEYS.iter().find_map(|key| value(key)).unwrap_or_default().to_owned(),
        frame_from_box,
        track: value(keys::TRACK).and_then(|it| it.parse().ok()),
        occlusion: value(keys::OCCLUSION).and_then(|name| occlusion.into_iter().find(|it| it.name() == name)),
        truncation: value(keys::TRUNCATION).and_then(|it| it.parse().ok()),
        score: SCORE_KEYS.iter().find_map(|key| value(key)).and_then(|it| it.parse().ok()),
    })
}

/// The objects of `vision_msgs`, in order.
fn objects_of_detections(detections: &[Detection3D]) -> Vec<SceneObject> {
    let object = |it: &Detection3D| SceneObject {
        frame: it.header.frame.clone(),
        class_name: it.class.clone(),
        frame_from_box: Some((it.frame_from_box, it.size_m)),
        track: it.id.parse().ok(),
        occlusion: None,
        truncation: None,
        score: it.score.map(|it| it as f32),
    };
    detections.iter().map(object).collect()
}
