//! The descriptions of Foxglove's messages that go into a recording, so that others can read them.
//!
//! They name the fields that are written here and no others; a reader skips what a message does not have.

use prost::Message as _;

use crate::dataset::mcap::foxglove_messages::{FRAME_TRANSFORM, POINT_CLOUD, SCENE_UPDATE};

/// The field types of protobuf that occur.
#[derive(Clone, Copy)]
enum FieldType {
    Double,
    Int64,
    Int32,
    Fixed32,
    Flag,
    Text,
    Bytes,
    Message(&'static str),
    Repeated(&'static str),
    Enum(&'static str),
}

use FieldType::{Bytes, Double, Enum, Fixed32, Flag, Int32, Int64, Message, Repeated, Text};

type MessageDescription = (&'static str, &'static [(&'static str, i32, FieldType)]);

const TIMESTAMP: &str = ".google.protobuf.Timestamp";

/// Messages in the package `foxglove`.
const MESSAGES: &[MessageDescription] = &[
    ("Vector3", &[("x", 1, Double), ("y", 2, Double), ("z", 3, Double)]),
    ("Quaternion", &[("x", 1, Double), ("y", 2, Double), ("z", 3, Double), ("w", 4, Double)]),
    (
        "Pose",
        &[("position", 1, Message(".foxglove.Vector3")), ("orientation", 2, Message(".foxglove.Quaternion"))],
    ),
    ("Color", &[("r", 1, Double), ("g", 2, Double), ("b", 3, Double), ("a", 4, Double)]),
    (
        "PackedElementField",
        &[("name", 1, Text), ("offset", 2, Fixed32), ("type", 3, Enum(".foxglove.NumericType"))],
    ),
    (
        "PointCloud",
        &[
            ("timestamp", 1, Message(TIMESTAMP)),
            ("frame_id", 2, Text),
            ("pose", 3, Message(".foxglove.Pose")),
            ("point_stride", 4, Fixed32),
            ("fields", 5, Repeated(".foxglove.PackedElementField")),
            ("data", 6, Bytes),
        ],
    ),
    ("KeyValuePair", &[("key", 1, Text), ("value", 2, Text)]),
    (
        "CubePrimitive",
        &[
            ("pose", 1, Message(".foxglove.Pose")),
            ("size", 2, Message(".foxglove.Vector3")),
            ("color", 3, Message(".foxglove.Color")),
        ],
    ),
    ("Point3", &[("x", 1, Double), ("y", 2, Double), ("z", 3, Double)]),
    (
        "LinePrimitive",
        &[
            ("type", 1, Enum(".foxglove.LineType")),
            ("pose", 2, Message(".foxglove.Pose")),
            ("thickness", 3, Double),
            ("scale_invariant", 4, Flag),
            ("points", 5, Repeated(".foxglove.Point3")),
            ("color", 6, Message(".foxglove.Color")),
        ],
    ),
    (
        "SceneEntity",
        &[
            ("timestamp", 1, Message(TIMESTAMP)),
            ("frame_id", 2, Text),
            ("id", 3, Text),
            ("metadata", 6, Repeated(".foxglove.KeyValuePair")),
            ("cubes", 8, Repeated(".foxglove.CubePrimitive")),
            ("lines", 11, Repeated(".foxglove.LinePrimitive")),
        ],
    ),
    (
        "SceneEntityDeletion",
        &[("timestamp", 1, Message(TIMESTAMP)), ("type", 2, Enum(".foxglove.DeletionType")), ("id", 3, Text)],
    ),
    (
        "SceneUpdate",
        &[
            ("deletions", 1, Repeated(".foxglove.SceneEntityDeletion")),
            ("entities", 2, Repeated(".foxglove.SceneEntity")),
        ],
    ),
    (
        "FrameTransform",
        &[
            ("timestamp", 1, Message(TIMESTAMP)),
            ("parent_frame_id", 2, Text),
            ("child_frame_id", 3, Text),
            ("translation", 4, Message(".foxglove.Vector3")),
            ("rotation", 5, Message(".foxglove.Quaternion")),
        ],
    ),
];

const ENUMS: &[(&str, &[&str])] = &[
    (
        "NumericType",
        &["UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64"],
    ),
    ("DeletionType", &["MATCHING_ID", "ALL"]),
    ("LineType", &["LINE_STRIP", "LINE_LOOP", "LINE_LIST"]),
];

#[derive(Clone, PartialEq, prost::Message)]
struct FileSet {
    #[prost(message, repeated, tag = "1")]
    files: Vec<FileDescription>,
}

#[derive(Clone, PartialEq, prost::Message)]
struct FileDescription {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(string, tag = "2")]
    package: String,
    #[prost(string, repeated, tag = "3")]
    dependencies: Vec<String>,
    #[prost(message, repeated, tag = "4")]
    messages: Vec<DescribedMessage>,
    #[prost(message, repeated, tag = "5")]
    enums: Vec<DescribedEnum>,
    #[prost(string, tag = "12")]
    syntax: String,
}

#[derive(Clone, PartialEq, prost::Message)]
struct DescribedMessage {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(message, repeated, tag = "2")]
    fields: Vec<DescribedField>,
}

#[derive(Clone, PartialEq, prost::Message)]
struct DescribedField {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(int32, tag = "3")]
    number: i32,
    #[prost(int32, tag = "4")]
    label: i32,
    #[prost(int32, tag = "5")]
    kind: i32,
    #[prost(string, optional, tag = "6")]
    type_name: Option<String>,
}

#[derive(Clone, PartialEq, prost::Message)]
struct DescribedEnum {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(message, repeated, tag = "2")]
    values: Vec<DescribedValue>,
}

#[derive(Clone, PartialEq, prost::Message)]
struct DescribedValue {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(int32, tag = "2")]
    number: i32,
}

/// The schemas that are written.
pub const SCHEMAS: [&str; 3] = [POINT_CLOUD, SCENE_UPDATE, FRAME_TRANSFORM];

/// A serialised `FileDescriptorSet` that has all messages of [`SCHEMAS`].
pub fn file_descriptor_set() -> Vec<u8> {
    let timestamp = FileDescription {
        name: "google/protobuf/timestamp.proto".to_owned(),
        package: "google.protobuf".to_owned(),
        messages: vec![described(&("Timestamp", &[("seconds", 1, Int64), ("nanos", 2, Int32)]))],
        syntax: "proto3".to_owned(),
        ..FileDescription::default()
    };
    let foxglove = FileDescription {
        name: "foxglove.proto".to_owned(),
        package: "foxglove".to_owned(),
        dependencies: vec![timestamp.name.clone()],
        messages: MESSAGES.iter().map(described).collect(),
        enums: ENUMS.iter().map(described_enum).collect(),
        syntax: "proto3".to_owned(),
    };
    FileSet { files: vec![timestamp, foxglove] }.encode_to_vec()
}

fn described((name, fields): &MessageDescription) -> DescribedMessage {
    let field = |&(name, number, field_type): &(&str, i32, FieldType)| {
        // The numbers that descriptors have for labels and types.
        let (optional, repeated) = (1, 3);
        let (kind, type_name, label) = match field_type {
            Double => (1, None, optional),
            Int64 => (3, None, optional),
            Int32 => (5, None, optional),
            Fixed32 => (7, None, optional),
            Flag => (8, None, optional),
            Text => (9, None, optional),
            Message(name) => (11, Some(name), optional),
            Repeated(name) => (11, Some(name), repeated),
            Bytes => (12, None, optional),
            Enum(name) => (14, Some(name), optional),
        };
        let type_name = type_name.map(str::to_owned);
        DescribedField { name: name.to_owned(), number, label, kind, type_name }
    };
    DescribedMessage { name: (*name).to_owned(), fields: fields.iter().map(field).collect() }
}

fn described_enum((name, values): &(&str, &[&str])) -> DescribedEnum {
    // Names of values share one scope in protobuf.
    let value = |(number, value): (i32, &&str)| DescribedValue { name: format!("{name}_{value}"), number };
    DescribedEnum { name: (*name).to_owned(), values: (0..).zip(*values).map(value).collect() }
}
