//! The messages of ROS 2 that are read.

use nalgebra::Isometry3;

use super::cdr::CdrReader;
use crate::dataset::packed_points::{ByteOrder, NumberType, PackedField, PackedPoints};
use crate::dataset::pose::isometry;

/// `sensor_msgs/msg/PointCloud2`.
pub const POINT_CLOUD_2: &str = "sensor_msgs/msg/PointCloud2";

/// `vision_msgs/msg/Detection3DArray`.
pub const DETECTION_3D_ARRAY: &str = "vision_msgs/msg/Detection3DArray";

/// `tf2_msgs/msg/TFMessage`.
pub const TF_MESSAGE: &str = "tf2_msgs/msg/TFMessage";

/// Time and frame of a measurement.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// Time stamp in nanoseconds; 0 if there is none.
    pub stamp_ns: u64,
    /// The name of the frame.
    pub frame: String,
}

/// The pose of one frame within another.
#[derive(Debug, Clone, PartialEq)]
pub struct StampedTransform {
    /// The time from which on it holds, in nanoseconds.
    pub stamp_ns: u64,
    /// The frame that the other lies in.
    pub parent: String,
    /// The frame that lies in the other.
    pub child: String,
    /// From coordinates of the child to those of the parent, in metres.
    pub parent_from_child: Isometry3<f64>,
}

/// A box of `vision_msgs`.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection3D {
    /// Its own time and frame, if stated.
    pub header: Header,
    /// Its most likely class.
    pub class: String,
    /// Score of this class, if any class is named.
    pub score: Option<f64>,
    /// Pose of its centre.
    pub frame_from_box: Isometry3<f64>,
    /// Its extent along its own x, y and z, in metres.
    pub size_m: [f64; 3],
    /// Its name.
    pub id: String,
}

/// The time stamp in the header at the start of `message`, in nanoseconds; 0 if there is none.
pub fn stamp_ns(message: &[u8]) -> Result<u64, String> {
    Ok(header(&mut CdrReader::new(message)?)?.stamp_ns)
}

/// The cloud in `message`. Errors, here and below, are the rest of a sentence about the file.
pub fn point_cloud_2(message: &[u8]) -> Result<(Header, PackedPoints<'_>), String> {
    let mut reader = CdrReader::new(message)?;
    let header = header(&mut reader)?;
    let (n_rows, n_columns) = (reader.u32()? as usize, reader.u32()? as usize);
    let fields = reader.list(|reader| {
        let (name, offset) = (reader.text()?.to_owned(), reader.u32()? as usize);
        let (number, _count) = (number_type(reader.u8()?)?, reader.u32()?);
        Ok(PackedField { name, offset, number })
    })?;
    let byte_order = if reader.u8()? == 0 { ByteOrder::Little } else { ByteOrder::Big };
    let (point_step, row_step) = (reader.u32()? as usize, reader.u32()? as usize);
    let data = reader.bytes()?;
    Ok((header, PackedPoints { fields, n_columns, n_rows, point_step, row_step, byte_order, data }))
}

fn number_type(number: u8) -> Result<NumberType, String> {
    Ok(match number {
        1 => NumberType::I8,
        2 => NumberType::U8,
        3 => NumberType::I16,
        4 => NumberType::U16,
        5 => NumberType::I32,
        6 => NumberType::U32,
        7 => NumberType::F32,
        8 => NumberType::F64,
        _ => return Err(format!("has a PointCloud2 with a field of the unknown type {number}")),
    })
}

/// The boxes in `message`.
pub fn detection_3d_array(message: &[u8]) -> Result<(Header, Vec<Detection3D>), String> {
    let mut reader = CdrReader::new(message)?;
    let header_of_all = header(&mut reader)?;
    let detections = reader.list(|reader| {
        let header = header(reader)?;
        let hypotheses = reader.list(|reader| {
            let (class, score) = (reader.text()?.to_owned(), reader.f64()?);
            // The pose of the hypothesis, and its covariance.
            reader.f64s::<7>()?;
            reader.f64s::<36>()?;
            Ok((class, score))
        })?;
        let likeliest = hypotheses.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let frame_from_box = pose(reader)?;
        let size_m = reader.f64s()?;
        let id = reader.text()?.to_owned();
        let (class, score) = likeliest.map(|(class, score)| (class, Some(score))).unwrap_or_default();
        Ok(Detection3D { header, class, score, frame_from_box, size_m, id })
    })?;
    Ok((header_of_all, detections))
}

/// The transforms in `message`.
pub fn tf_message(message: &[u8]) -> Result<Vec<StampedTransform>, String> {
    CdrReader::new(message)?.list(|reader| {
        let Header { stamp_ns, frame: parent } = header(reader)?;
        let child = reader.text()?.to_owned();
        Ok(StampedTransform { stamp_ns, parent, child, parent_from_child: pose(reader)? })
    })
}

fn header(reader: &mut CdrReader<'_>) -> Result<Header, String> {
    let (seconds, nanoseconds) = (reader.i32()?, reader.u32()?);
    let stamp_ns = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
    Ok(Header { stamp_ns: u64::try_from(stamp_ns).unwrap_or(0), frame: reader.text()?.to_owned() })
}

fn pose(reader: &mut CdrReader<'_>) -> Result<Isometry3<f64>, String> {
    let ([x, y, z], [i, j, k, w]) = (reader.f64s()?, reader.f64s()?);
    isometry([x, y, z], [i, j, k, w])
}
