//! The messages of Foxglove about objects, in protobuf and in JSON.

use serde::Deserialize;

use super::foxglove_messages::{Pose, Timestamp, Vector3};

/// A name with a value.
#[derive(Clone, PartialEq, Eq, prost::Message, Deserialize)]
#[serde(default)]
pub struct KeyValuePair {
    /// The name.
    #[prost(string, tag = "1")]
    pub key: String,
    /// The value.
    #[prost(string, tag = "2")]
    pub value: String,
}

/// A colour, each part from 0 to 1.
#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct Color {
    /// Red.
    #[prost(double, tag = "1")]
    pub r: f64,
    /// Green.
    #[prost(double, tag = "2")]
    pub g: f64,
    /// Blue.
    #[prost(double, tag = "3")]
    pub b: f64,
    /// Opacity.
    #[prost(double, tag = "4")]
    pub a: f64,
}

/// A box.
#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct CubePrimitive {
    /// Its centre and turn.
    #[prost(message, optional, tag = "1")]
    pub pose: Option<Pose>,
    /// Its extent along its own axes.
    #[prost(message, optional, tag = "2")]
    pub size: Option<Vector3>,
    /// Its colour.
    #[prost(message, optional, tag = "3")]
    pub color: Option<Color>,
}

/// Lines through points.
#[derive(Clone, PartialEq, prost::Message)]
pub struct LinePrimitive {
    /// 0 for one line through all points, 2 for one between each two of them.
    #[prost(int32, tag = "1")]
    pub kind: i32,
    /// The pose of the origin of the points.
    #[prost(message, optional, tag = "2")]
    pub pose: Option<Pose>,
    /// Thickness of the lines, in metres or in pixels.
    #[prost(double, tag = "3")]
    pub thickness: f64,
    /// Whether the thickness is in pixels.
    #[prost(bool, tag = "4")]
    pub scale_invariant: bool,
    /// The points.
    #[prost(message, repeated, tag = "5")]
    pub points: Vec<Vector3>,
    /// Their colour.
    #[prost(message, optional, tag = "6")]
    pub color: Option<Color>,
}

/// An object of a scene.
#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct SceneEntity {
    /// The time from which on it is there.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The frame of its shapes.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// Its name.
    #[prost(string, tag = "3")]
    pub id: String,
    /// More facts about it.
    #[prost(message, repeated, tag = "6")]
    pub metadata: Vec<KeyValuePair>,
    /// Its boxes.
    #[prost(message, repeated, tag = "8")]
    pub cubes: Vec<CubePrimitive>,
    /// Its lines, which are written but never read.
    #[prost(message, repeated, tag = "11")]
    #[serde(skip)]
    pub lines: Vec<LinePrimitive>,
}

/// A deletion of objects.
#[derive(Clone, PartialEq, Eq, prost::Message, Deserialize)]
#[serde(default)]
pub struct SceneEntityDeletion {
    /// When they are deleted.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// 0 for the object `id`, 1 for all.
    #[prost(int32, tag = "2")]
    #[serde(rename = "type")]
    pub kind: i32,
    /// The object to delete.
    #[prost(string, tag = "3")]
    pub id: String,
}

/// A scene.
#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct SceneUpdate {
    /// Deletions of objects.
    #[prost(message, repeated, tag = "1")]
    pub deletions: Vec<SceneEntityDeletion>,
    /// The objects that are there.
    #[prost(message, repeated, tag = "2")]
    pub entities: Vec<SceneEntity>,
}
