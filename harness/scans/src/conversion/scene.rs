//! Annotations as a Foxglove scene.

use detector::OrientedBox;

use crate::annotation::Annotation;
use crate::dataset::mcap::foxglove_messages::{Pose, Quaternion, Timestamp, Vector3};
use crate::dataset::mcap::foxglove_scene::{
    Color, CubePrimitive, KeyValuePair, LinePrimitive, SceneEntity, SceneEntityDeletion, SceneUpdate,
};
use crate::dataset::mcap::scene_objects::keys;

/// The kind of deletion that removes everything.
const DELETE_ALL: i32 = 1;

/// The frame that everything is written in.
pub const SENSOR_FRAME: &str = "lidar";

/// The scene at `time_ns` that replaces everything there.
pub fn scene_of(time_ns: u64, entities: Vec<SceneEntity>) -> SceneUpdate {
    let timestamp = Some(Timestamp::from_nanoseconds(time_ns));
    let deletion = SceneEntityDeletion { timestamp, kind: DELETE_ALL, id: String::new() };
    SceneUpdate { deletions: vec![deletion], entities }
}

/// One entity for each annotation, in order, with everything but its points.
pub fn entities_of(time_ns: u64, annotations: &[Annotation]) -> Vec<SceneEntity> {
    let blue = Color { r: 0.2, g: 0.5, b: 1.0, a: 0.4 };
    let entity = |(number, it): (usize, &Annotation)| {
        let mut metadata = vec![pair(keys::CLASS, it.class.name().to_owned())];
        metadata.extend(it.track.map(|track| pair(keys::TRACK, track.to_string())));
        metadata.extend(it.occlusion.map(|occlusion| pair(keys::OCCLUSION, occlusion.name().to_owned())));
        metadata.extend(it.truncation.map(|share| pair(keys::TRUNCATION, share.to_string())));
        entity_of(time_ns, number, it.bounding_box.as_ref(), metadata, blue)
    };
    (1..).zip(annotations).map(entity).collect()
}

/// The entity called `number` with this box.
pub fn entity_of(
    time_ns: u64,
    number: usize,
    bounding_box: Option<&OrientedBox>,
    metadata: Vec<KeyValuePair>,
    color: Color,
) -> SceneEntity {
    SceneEntity {
        timestamp: Some(Timestamp::from_nanoseconds(time_ns)),
        frame_id: SENSOR_FRAME.to_owned(),
        id: number.to_string(),
        metadata,
        cubes: bounding_box.map(|it| cube_of(it, color)).into_iter().collect(),
        lines: Vec::new(),
    }
}

/// A line between two points whose thickness is the same at all distances.
pub fn line_between(ends_m: [[f32; 3]; 2], color: Color) -> LinePrimitive {
    let points = ends_m.map(|it| {
        let [x, y, z] = it.map(f64::from);
        Vector3 { x, y, z }
    });
    let orientation = Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 });
    LinePrimitive {
        kind: 0,
        pose: Some(Pose { position: Some(Vector3::default()), orientation }),
        thickness: 2.0,
        scale_invariant: true,
        points: points.to_vec(),
        color: Some(color),
    }
}

/// A name with a value.
pub fn pair(key: &str, value: String) -> KeyValuePair {
    KeyValuePair { key: key.to_owned(), value }
}

fn cube_of(bounding_box: &OrientedBox, color: Color) -> CubePrimitive {
    let [x, y, z] = bounding_box.center_m.map(f64::from);
    let [length, width, height] = bounding_box.length_width_height_m.map(f64::from);
    let (sin, cos) = (f64::from(bounding_box.yaw_rad) / 2.0).sin_cos();
    let orientation = Some(Quaternion { x: 0.0, y: 0.0, z: sin, w: cos });
    CubePrimitive {
        pose: Some(Pose { position: Some(Vector3 { x, y, z }), orientation }),
        size: Some(Vector3 { x: length, y: width, z: height }),
        color: Some(color),
    }
}
