//! Recordings as others write them, made message by message: ROS 2 in CDR, Foxglove in JSON.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use base64::Engine as _;
use mcap::records::Metadata;
use mcap::{Channel, Compression, Message, Schema, WriteOptions};

use crate::program::Workplace;

/// Writes CDR of version 1 in the byte order of this kind.
pub struct Cdr {
    pub bytes: Vec<u8>,
    is_big_endian: bool,
}

impl Cdr {
    pub fn new(is_big_endian: bool) -> Self {
        Self { bytes: vec![0, u8::from(!is_big_endian), 0, 0], is_big_endian }
    }

    pub fn number<const N: usize>(&mut self, little: [u8; N]) -> &mut Self {
        while !(self.bytes.len() - 4).is_multiple_of(N) {
            self.bytes.push(0xee);
        }
        let mut number = little;
        if self.is_big_endian {
            number.reverse();
        }
        self.bytes.extend(number);
        self
    }

    pub fn u8(&mut self, value: u8) -> &mut Self {
        self.number([value])
    }

    pub fn u32(&mut self, value: u32) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    pub fn f64s(&mut self, values: &[f64]) -> &mut Self {
        for value in values {
            self.number(value.to_le_bytes());
        }
        self
    }

    pub fn text(&mut self, text: &str) -> &mut Self {
        self.u32(text.len() as u32 + 1).bytes.extend(text.bytes().chain([0]));
        self
    }

    pub fn data(&mut self, data: &[u8]) -> &mut Self {
        self.u32(data.len() as u32).bytes.extend(data);
        self
    }

    pub fn header(&mut self, stamp_ns: u64, frame: &str) -> &mut Self {
        self.u32((stamp_ns / 1_000_000_000) as u32).u32((stamp_ns % 1_000_000_000) as u32).text(frame)
    }
}

/// Where points are that one scan has after the other, in metres.
pub const POSITIONS_M: [[f32; 3]; 4] =
    [[5.0, 1.0, -1.0], [5.5, 1.0, -0.5], [f32::NAN, 0.0, 0.0], [20.0, 0.0, 0.0]];

/// A cloud of two rows with room between points and rows, z before x as `f64`, and a `u16` for the intensity.
pub fn organised_cloud(stamp_ns: u64, frame: &str, is_big_endian: bool) -> Vec<u8> {
    let put = |data: &mut Vec<u8>, little: &[u8]| {
        if is_big_endian {
            data.extend(little.iter().rev());
        } else {
            data.extend(little);
        }
    };
    let mut data = Vec::new();
    for row in POSITIONS_M.chunks(2) {
        for &[x, y, z] in row {
            put(&mut data, &z.to_le_bytes());
            data.extend([0xaa; 4]);
            put(&mut data, &f64::from(x).to_le_bytes());
            put(&mut data, &y.to_le_bytes());
            put(&mut data, &300_u16.to_le_bytes());
            data.extend([0xbb; 2]);
        }
        data.extend([0xcc; 6]);
    }
    let mut cdr = Cdr::new(is_big_endian);
    cdr.header(stamp_ns, frame).u32(2).u32(2).u32(5);
    for (name, offset, number) in
        [("z", 0, 7), ("x", 8, 8), ("y", 16, 7), ("intensity", 20, 4), ("ring", 22, 2)]
    {
        cdr.text(name).u32(offset).u8(number).u32(1);
    }
    cdr.u8(u8::from(is_big_endian)).u32(24).u32(54).data(&data).u8(0);
    cdr.bytes
}

/// One box, with two hypotheses of which the second is likelier.
pub fn detections(stamp_ns: u64, frame: &str, center_m: [f64; 3], yaw_rad: f64) -> Vec<u8> {
    let mut cdr = Cdr::new(false);
    cdr.header(stamp_ns, frame).u32(1).header(stamp_ns, "").u32(2);
    for (class, score) in [("truck", 0.2), ("car", 0.7)] {
        cdr.text(class).f64s(&[score]).f64s(&[0.0; 7]).f64s(&[0.0; 36]);
    }
    let turn = [0.0, 0.0, (yaw_rad / 2.0).sin(), (yaw_rad / 2.0).cos()];
    cdr.f64s(&center_m).f64s(&turn).f64s(&[4.0, 2.0, 1.5]).text("17");
    cdr.bytes
}

/// `child` at `x_m` in `parent`, turned to the left by `yaw_rad`.
pub fn transforms(stamp_ns: u64, parent: &str, child: &str, x_m: f64, yaw_rad: f64) -> Vec<u8> {
    let mut cdr = Cdr::new(false);
    let turn = [0.0, 0.0, (yaw_rad / 2.0).sin(), (yaw_rad / 2.0).cos()];
    cdr.u32(1).header(stamp_ns, parent).text(child).f64s(&[x_m, 0.0, 0.0]).f64s(&turn);
    cdr.bytes
}

pub const CLOUD: &str = "sensor_msgs/msg/PointCloud2";
pub const DETECTIONS: &str = "vision_msgs/msg/Detection3DArray";
pub const TRANSFORMS: &str = "tf2_msgs/msg/TFMessage";

/// A message on its way into a file: topic, schema, encoding, time and content.
pub type Logged = (&'static str, &'static str, &'static str, u64, Vec<u8>);

pub fn write(workplace: &Workplace, options: WriteOptions, messages: &[Logged]) -> PathBuf {
    write_named(workplace, options, messages, None)
}

/// The same with names of its scans.
pub fn write_named(
    workplace: &Workplace,
    options: WriteOptions,
    messages: &[Logged],
    scan_ids: Option<&str>,
) -> PathBuf {
    let path = workplace.path("drive.mcap");
    let mut writer = options.create(std::fs::File::create(&path).unwrap()).unwrap();
    for (sequence, (topic, schema, encoding, log_time, data)) in (0..).zip(messages) {
        let schema = Schema {
            id: schema_id(schema),
            name: (*schema).to_owned(),
            encoding: "ros2msg".to_owned(),
            data: Cow::Borrowed(b"x"),
        };
        let channel = Arc::new(Channel {
            id: channel_id(topic),
            topic: (*topic).to_owned(),
            schema: Some(Arc::new(schema)),
            message_encoding: (*encoding).to_owned(),
            metadata: BTreeMap::new(),
        });
        let (log_time, data) = (*log_time, Cow::Borrowed(&data[..]));
        writer.write(&Message { channel, sequence, log_time, publish_time: log_time, data }).unwrap();
    }
    if let Some(scan_ids) = scan_ids {
        let metadata = BTreeMap::from([("scan_ids".to_owned(), scan_ids.to_owned())]);
        writer.write_metadata(&Metadata { name: "scanbench".to_owned(), metadata }).unwrap();
    }
    writer.finish().unwrap();
    path
}

fn schema_id(name: &str) -> u16 {
    1 + name.bytes().map(u16::from).sum::<u16>()
}

fn channel_id(topic: &str) -> u16 {
    topic.bytes().map(u16::from).sum()
}

pub fn cloud_at(time_ns: u64) -> Logged {
    ("/top", CLOUD, "cdr", time_ns, organised_cloud(time_ns, "lidar", false))
}

/// Objects that somebody found, one of them as [`detections`] has it.
pub fn found_at(time_ns: u64, frame: &str, center_m: [f64; 3]) -> Logged {
    ("/found", DETECTIONS, "cdr", time_ns, detections(time_ns, frame, center_m, 0.0))
}

pub const SECOND: u64 = 1_000_000_000;

/// Every way to write that readers have to cope with.
pub fn write_options() -> [WriteOptions; 5] {
    [
        WriteOptions::new().compression(Some(Compression::Zstd)),
        WriteOptions::new().compression(Some(Compression::Lz4)),
        WriteOptions::new().use_chunks(false),
        WriteOptions::new().compression(None).emit_message_indexes(false),
        WriteOptions::new().compression(None).emit_summary_records(false).emit_summary_offsets(false),
    ]
}

/// A drive with clouds, boxes in the frame of the map, and transforms.
pub fn write_drive(workplace: &Workplace, options: WriteOptions) -> PathBuf {
    // The car drives 10 m a second along x and looks to the left; the sensor is 1 m ahead of its origin.
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut messages: Vec<Logged> =
        vec![("/tf_static", TRANSFORMS, "cdr", 0, transforms(0, "car", "lidar", 1.0, 0.0))];
    for second in 1..4 {
        let time_ns = second * SECOND;
        let map = transforms(time_ns, "map", "car", 10.0 * second as f64, quarter);
        messages.push(("/tf", TRANSFORMS, "cdr", time_ns, map));
        // Logged late, about a moment halfway.
        let stamp_ns = time_ns + SECOND / 2;
        let boxes = detections(stamp_ns, "map", [10.0 * second as f64 + 5.0, 6.0, -0.7], quarter);
        messages.push(("/labels", DETECTIONS, "cdr", stamp_ns + SECOND / 4, boxes));
        messages.push(("/top", CLOUD, "cdr", stamp_ns, organised_cloud(stamp_ns, "lidar", false)));
    }
    write(workplace, options, &messages)
}

/// A cloud and a scene in JSON, whose object has this metadata.
pub fn foxglove_messages(time_ns: u64, metadata: &serde_json::Value) -> [Logged; 2] {
    let points: Vec<u8> =
        [5.0_f32, 1.0, -1.0, 20.0, 0.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(points);
    let field = |name: &str, offset: u32| serde_json::json!({"name": name, "offset": offset, "type": 7});
    let stamp = serde_json::json!({"sec": time_ns / SECOND, "nsec": time_ns % SECOND});
    let cloud = serde_json::json!({
        "timestamp": stamp, "frame_id": "base", "point_stride": 12, "data": data,
        "fields": [field("x", 0), field("y", 4), field("z", 8)],
        "pose": {"position": {"x": 1.0, "y": 0.0, "z": 2.0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}},
    });
    let scene = serde_json::json!({"deletions": [], "entities": [{
        "timestamp": stamp, "frame_id": "base", "id": "a", "frame_locked": true,
        "metadata": metadata,
        "cubes": [{"pose": {"position": {"x": 6.0, "y": 1.0, "z": 1.0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}},
                   "size": {"x": 4.0, "y": 2.0, "z": 1.5}, "color": {"r": 1, "g": 0, "b": 0, "a": 1}}],
    }]});
    [
        ("/points", "foxglove.PointCloud", "json", time_ns, cloud.to_string().into_bytes()),
        ("/scene", "foxglove.SceneUpdate", "json", time_ns, scene.to_string().into_bytes()),
    ]
}

/// Metadata that say what the object is.
pub fn category(name: &str) -> serde_json::Value {
    serde_json::json!([{"key": "category", "value": name}])
}
