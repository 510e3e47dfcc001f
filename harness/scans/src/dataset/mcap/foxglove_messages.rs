//! The messages of Foxglove that are read and written, in protobuf and in JSON.
//!
//! Only the fields that are used here are declared; both decoders skip the others.

use std::fmt;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Isometry3;
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::ros_messages::StampedTransform;
use crate::dataset::packed_points::{ByteOrder, NumberType, PackedField, PackedPoints};
use crate::dataset::pose::isometry;
use crate::dataset::python_json::quoted;

/// `foxglove.PointCloud`.
pub const POINT_CLOUD: &str = "foxglove.PointCloud";

/// `foxglove.SceneUpdate`.
pub const SCENE_UPDATE: &str = "foxglove.SceneUpdate";

/// `foxglove.FrameTransform`.
pub const FRAME_TRANSFORM: &str = "foxglove.FrameTransform";

/// `foxglove.FrameTransforms`.
pub const FRAME_TRANSFORMS: &str = "foxglove.FrameTransforms";

/// A point has fewer fields than this.
const MAX_FIELDS: usize = 256;

/// A moment or a duration.
#[derive(Clone, Copy, PartialEq, Eq, prost::Message, Deserialize)]
#[serde(default)]
pub struct Timestamp {
    /// Whole seconds.
    #[prost(int64, tag = "1")]
    #[serde(rename = "sec")]
    pub seconds: i64,
    /// Billionths of a second beyond them.
    #[prost(int32, tag = "2")]
    #[serde(rename = "nsec")]
    pub nanos: i32,
}

impl Timestamp {
    /// The time in nanoseconds; 0 if it is before the start of time.
    pub fn nanoseconds(self) -> u64 {
        let nanoseconds = self.seconds.saturating_mul(1_000_000_000).saturating_add(i64::from(self.nanos));
        u64::try_from(nanoseconds).unwrap_or(0)
    }

    /// The time stamp for a time in nanoseconds.
    pub fn from_nanoseconds(nanoseconds: u64) -> Self {
        let (seconds, nanos) = (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000);
        Self { seconds: seconds as i64, nanos: nanos as i32 }
    }
}

/// Three numbers.
#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct Vector3 {
    /// Along x.
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Along y.
    #[prost(double, tag = "2")]
    pub y: f64,
    /// Along z.
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// A turn.
#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct Quaternion {
    /// First part of the axis.
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Second part of the axis.
    #[prost(double, tag = "2")]
    pub y: f64,
    /// Third part of the axis.
    #[prost(double, tag = "3")]
    pub z: f64,
    /// The real part.
    #[prost(double, tag = "4")]
    pub w: f64,
}

/// Position and turn of an object.
#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct Pose {
    /// Its position.
    #[prost(message, optional, tag = "1")]
    pub position: Option<Vector3>,
    /// Its turn.
    #[prost(message, optional, tag = "2")]
    pub orientation: Option<Quaternion>,
}

impl Pose {
    /// The pose as a transform. Errors are the rest of a sentence about the file.
    pub fn isometry(&self) -> Result<Isometry3<f64>, String> {
        let (at, turn) = (self.position.unwrap_or_default(), self.orientation.unwrap_or_default());
        isometry([at.x, at.y, at.z], [turn.x, turn.y, turn.z, turn.w])
    }
}

/// One number of every point.
#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct PackedElementField {
    /// Its name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// Its start in a point, in bytes.
    #[prost(fixed32, tag = "2")]
    pub offset: u32,
    /// Foxglove's number for its type.
    #[prost(int32, tag = "3")]
    #[serde(rename = "type")]
    pub number: i32,
}

/// A cloud.
#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct PointCloud {
    /// When it was taken.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The frame that `pose` is in.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// The pose of the origin of the points.
    #[prost(message, optional, tag = "3")]
    pub pose: Option<Pose>,
    /// Number of bytes of a point.
    #[prost(fixed32, tag = "4")]
    pub point_stride: u32,
    /// The fields of a point.
    #[prost(message, repeated, tag = "5")]
    #[serde(deserialize_with = "few_fields")]
    pub fields: Vec<PackedElementField>,
    /// The points.
    #[prost(bytes = "vec", tag = "6")]
    #[serde(deserialize_with = "base64_bytes")]
    pub data: Vec<u8>,
}

impl PointCloud {
    /// The points in the layout of the message. Errors are the rest of a sentence about the file.
    pub fn packed(&self) -> Result<PackedPoints<'_>, String> {
        let field = |field: &PackedElementField| {
            let (name, offset) = (field.name.clone(), field.offset as usize);
            number_type(field.number).map(|number| PackedField { name, offset, number })
        };
        let fields = self.fields.iter().map(field).collect::<Result<_, String>>()?;
        let (point_step, n_bytes) = (self.point_stride as usize, self.data.len());
        if n_bytes % point_step.max(1) != 0 || (point_step == 0 && n_bytes > 0) {
            return Err(format!("has a cloud of {n_bytes} bytes in points of {point_step}"));
        }
        Ok(PackedPoints {
            fields,
            n_columns: n_bytes / point_step.max(1),
            n_rows: 1,
            point_step,
            row_step: n_bytes,
            byte_order: ByteOrder::Little,
            data: &self.data,
        })
    }
}

fn number_type(number: i32) -> Result<NumberType, String> {
    Ok(match number {
        1 => NumberType::U8,
        2 => NumberType::I8,
        3 => NumberType::U16,
        4 => NumberType::I16,
        5 => NumberType::U32,
        6 => NumberType::I32,
        7 => NumberType::F32,
        8 => NumberType::F64,
        _ => return Err(format!("has a cloud with a field of the unknown type {number}")),
    })
}

/// Foxglove's number for a type.
pub fn number_of(number: NumberType) -> i32 {
    match number {
        NumberType::U8 => 1,
        NumberType::I8 => 2,
        NumberType::U16 => 3,
        NumberType::I16 => 4,
        NumberType::U32 => 5,
        NumberType::I32 => 6,
        NumberType::F32 => 7,
        NumberType::F64 => 8,
    }
}

/// A cloud of which only the time is read.
#[derive(Clone, Copy, PartialEq, Eq, prost::Message, Deserialize)]
#[serde(default)]
pub struct CloudTime {
    /// When it was taken.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
}

/// The pose of one frame within another.
#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct FrameTransform {
    /// The time from which on it holds.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The frame that the other lies in.
    #[prost(string, tag = "2")]
    pub parent_frame_id: String,
    /// The frame that lies in the other.
    #[prost(string, tag = "3")]
    pub child_frame_id: String,
    /// Position of the child in the parent.
    #[prost(message, optional, tag = "4")]
    pub translation: Option<Vector3>,
    /// Turn of the child in the parent.
    #[prost(message, optional, tag = "5")]
    pub rotation: Option<Quaternion>,
}

impl FrameTransform {
    /// The transform in the type for both kinds of recordings. Errors are the rest of a sentence about the file.
    pub fn stamped(&self) -> Result<StampedTransform, String> {
        let pose = Pose { position: self.translation, orientation: self.rotation };
        Ok(StampedTransform {
            stamp_ns: self.timestamp.unwrap_or_default().nanoseconds(),
            parent: self.parent_frame_id.clone(),
            child: self.child_frame_id.clone(),
            parent_from_child: pose.isometry()?,
        })
    }
}

/// Several transforms.
#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub struct FrameTransforms {
    /// The transforms, in any order.
    #[prost(message, repeated, tag = "1")]
    pub transforms: Vec<FrameTransform>,
}

/// The message in `bytes`, in the encoding of its channel. Errors are the rest of a sentence about the file.
pub fn decode<M: prost::Message + Default + serde::de::DeserializeOwned>(
    encoding: &str,
    bytes: &[u8],
) -> Result<M, String> {
    match encoding {
        "protobuf" => M::decode(bytes).map_err(|error| format!("has a message that cannot be read: {error}")),
        "json" => std::str::from_utf8(bytes)
            .map_err(|error| error.to_string())
            .and_then(|text| serde_json::from_str(&quoted(text)).map_err(|error| error.to_string()))
            .map_err(|error| format!("has a message that cannot be read: {error}")),
        other => Err(format!("has messages in the unknown encoding {other:?}")),
    }
}

/// The cloud in `bytes`, in the encoding of its channel. Errors are the rest of a sentence about the file.
///
/// # Errors
///
/// As [`decode`]; also if its points have more fields than any real ones, as each takes more memory than bytes.
pub fn decode_cloud(encoding: &str, bytes: &[u8]) -> Result<PointCloud, String> {
    if encoding == "protobuf" && n_fields_in(bytes) > MAX_FIELDS {
        return Err(format!("has a cloud with more than {MAX_FIELDS} fields"));
    }
    decode(encoding, bytes)
}

/// Number of descriptions of fields in a cloud in protobuf, as far as it can be read.
fn n_fields_in(mut bytes: &[u8]) -> usize {
    const FIELDS: u32 = 5;
    let mut n_fields = 0;
    while let Ok((tag, wire_type)) = prost::encoding::decode_key(&mut bytes) {
        n_fields += usize::from(tag == FIELDS);
        let context = prost::encoding::DecodeContext::default();
        if prost::encoding::skip_field(wire_type, tag, &mut bytes, context).is_err() {
            break;
        }
    }
    n_fields
}

fn few_fields<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<PackedElementField>, D::Error> {
    struct FewFields;
    impl<'de> Visitor<'de> for FewFields {
        type Value = Vec<PackedElementField>;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(formatter, "at most {MAX_FIELDS} fields")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
            let mut fields = Vec::new();
            while let Some(field) = list.next_element()? {
                if fields.len() == MAX_FIELDS {
                    return Err(A::Error::invalid_length(MAX_FIELDS + 1, &self));
                }
                fields.push(field);
            }
            Ok(fields)
        }
    }
    deserializer.deserialize_seq(FewFields)
}

fn base64_bytes<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
    let text = String::deserialize(deserializer)?;
    STANDARD.decode(text).map_err(serde::de::Error::custom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost::Message as _;

    #[test]
    fn a_cloud_with_more_fields_than_any_has_is_refused_before_they_take_memory() {
        let cloud = |n_fields| PointCloud {
            fields: vec![PackedElementField::default(); n_fields],
            data: vec![5; 1000],
            ..PointCloud::default()
        };
        assert_eq!(decode_cloud("protobuf", &cloud(4).encode_to_vec()).unwrap(), cloud(4));
        let problem =
            decode_cloud("protobuf", &cloud(1 << 20).encode_to_vec()).expect_err("a million fields");
        assert!(problem.contains("more than 256 fields"), "{problem}");
        let json = |n_fields: usize| format!("{{\"fields\": [{}]}}", vec!["{}"; n_fields].join(","));
        assert_eq!(decode_cloud("json", json(4).as_bytes()).unwrap().fields.len(), 4);
        let problem = decode_cloud("json", json(257).as_bytes()).expect_err("too many");
        assert!(problem.contains("at most 256 fields"), "{problem}");
    }
}
