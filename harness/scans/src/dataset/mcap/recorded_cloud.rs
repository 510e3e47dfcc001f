//! One cloud of a recording, from a message of any kind.

use detector::PointCloud;
use nalgebra::{Isometry3, Point3};

use super::foxglove_messages::decode_cloud;
use super::ros_messages::point_cloud_2;
use super::topics::MessageKind;
use crate::annotation::Annotation;
use crate::dataset::packed_points::{NumberType, PackedField, PackedPoints};
use crate::dataset::positioned_points::PositionedPoints;

/// The fields of points in which scanbench writes labels that boxes cannot express.
pub mod own_fields {
    /// The number of its [`PointRegion`](crate::annotation::PointRegion): 0 labelled, 1 unscorable, 2 outside.
    pub const REGION: &str = "region";
    /// The index of the point's annotation in its message, from 1; 0 for none.
    pub const OBJECT: &str = "object";
}

/// A cloud as it was recorded.
pub struct RecordedCloud {
    /// The points, along the axes of the frame, from the sensor.
    pub cloud: PointCloud,
    /// Indices in the message of the points that are not in the cloud since they have no position, ascending.
    pub points_left_out: Vec<u32>,
    /// The frame stated in the message.
    pub frame: String,
    /// The time stamp of the message, in nanoseconds; 0 if it has none.
    pub stamp_ns: u64,
    /// From the frame to the sensor's.
    pub sensor_from_frame: Isometry3<f64>,
    /// [`own_fields::REGION`] of every point.
    pub regions: Option<Vec<f64>>,
    /// [`own_fields::OBJECT`] of every point.
    pub objects: Option<Vec<f64>>,
}

impl RecordedCloud {
    /// The cloud in `bytes`, a message of this kind in the encoding of its channel. Errors are the rest of a sentence about
    /// the file.
    pub fn read(kind: MessageKind, encoding: &str, bytes: &[u8]) -> Result<Self, String> {
        if kind == MessageKind::RosCloud {
            let (header, packed) = point_cloud_2(bytes)?;
            return Self::of_packed(&packed, header.frame, header.stamp_ns, &Isometry3::identity());
        }
        let message = decode_cloud(encoding, bytes)?;
        let pose = message.pose.unwrap_or_default().isometry()?;
        let stamp_ns = message.timestamp.unwrap_or_default().nanoseconds();
        Self::of_packed(&message.packed()?, message.frame_id.clone(), stamp_ns, &pose)
    }

    fn of_packed(
        packed: &PackedPoints<'_>,
        frame: String,
        stamp_ns: u64,
        frame_from_points: &Isometry3<f64>,
    ) -> Result<Self, String> {
        let mut points = packed.positioned()?;
        take_moments(packed, stamp_ns, &mut points)?;
        let of_points = |name: &str| -> Result<Option<Vec<f64>>, String> {
            Ok(packed.column(name)?.map(|of_all| points.values_of_kept(&of_all)))
        };
        let (regions, objects) = (of_points(own_fields::REGION)?, of_points(own_fields::OBJECT)?);
        let (mut cloud, points_left_out) = points.into_parts();
        // The axes become those of the frame, the origin stays with the sensor.
        if frame_from_points.rotation.angle() > 0.0 {
            let turned = |[x, y, z]: [f32; 3]| {
                let turned = frame_from_points.rotation * Point3::from([x, y, z].map(f64::from));
                [turned.x as f32, turned.y as f32, turned.z as f32]
            };
            cloud.move_points(turned);
        }
        Ok(Self {
            cloud,
            points_left_out,
            frame,
            stamp_ns,
            sensor_from_frame: frame_from_points.translation.inverse() * Isometry3::identity(),
            regions,
            objects,
        })
    }

    /// Gives every annotation the points whose [`own_fields::OBJECT`] is its index in the message.
    pub fn assign_points(&self, annotations: &mut [Annotation]) {
        for (point_idx, number) in (0_u32..).zip(self.objects.iter().flatten()) {
            let annotation = (*number as usize).checked_sub(1).and_then(|idx| annotations.get_mut(idx));
            if let Some(annotation) = annotation {
                annotation.point_indices.push(point_idx);
            }
        }
    }
}

/// Takes times of points by the clock of `stamp_ns`, in seconds or nanoseconds: times that are near the stamp in one of
/// these units cannot be so in the other.
fn take_moments(
    packed: &PackedPoints<'_>,
    stamp_ns: u64,
    points: &mut PositionedPoints,
) -> Result<(), String> {
    let is_moment = |it: &PackedField| it.name == "timestamp" && it.number == NumberType::F64;
    if points.cloud().time_offset_s().is_some() || !packed.fields.iter().any(is_moment) || stamp_ns == 0 {
        return Ok(());
    }
    let moments = packed.column("timestamp")?.unwrap_or_default();
    for unit_s in [1.0, 1e-9] {
        let stamp = stamp_ns as f64 * 1e-9 / unit_s;
        let offsets_s: Vec<f64> = moments.iter().map(|it| (it - stamp) * unit_s).collect();
        points.take_time_offsets_s(&offsets_s);
        if points.cloud().time_offset_s().is_some() {
            break;
        }
    }
    Ok(())
}
