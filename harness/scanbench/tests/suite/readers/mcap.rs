//! MCAP recordings as others write them: ROS 2 messages, JSON, several topics, frames, cuts and damage.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use base64::Engine as _;
use mcap::records::Metadata;
use mcap::{Channel, Compression, Message, Schema, WriteOptions};
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::PointRegion;
use scans::dataset::DatasetError;
use scans::dataset::source::{DamagePolicy, TopicChoice};
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

use super::{check_damaged, open, try_open};
use crate::program::Workplace;

/// Writes CDR of version 1 in the byte order of this kind.
struct Cdr {
    bytes: Vec<u8>,
    is_big_endian: bool,
}

impl Cdr {
    fn new(is_big_endian: bool) -> Self {
        Self { bytes: vec![0, u8::from(!is_big_endian), 0, 0], is_big_endian }
    }

    fn number<const N: usize>(&mut self, little: [u8; N]) -> &mut Self {
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

    fn u8(&mut self, value: u8) -> &mut Self {
        self.number([value])
    }

    fn u32(&mut self, value: u32) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    fn f64s(&mut self, values: &[f64]) -> &mut Self {
        for value in values {
            self.number(value.to_le_bytes());
        }
        self
    }

    fn text(&mut self, text: &str) -> &mut Self {
        self.u32(text.len() as u32 + 1).bytes.extend(text.bytes().chain([0]));
        self
    }

    fn data(&mut self, data: &[u8]) -> &mut Self {
        self.u32(data.len() as u32).bytes.extend(data);
        self
    }

    fn header(&mut self, stamp_ns: u64, frame: &str) -> &mut Self {
        self.u32((stamp_ns / 1_000_000_000) as u32).u32((stamp_ns % 1_000_000_000) as u32).text(frame)
    }
}

/// Where points are that one scan has after the other, in metres.
const POSITIONS_M: [[f32; 3]; 4] =
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
fn transforms(stamp_ns: u64, parent: &str, child: &str, x_m: f64, yaw_rad: f64) -> Vec<u8> {
    let mut cdr = Cdr::new(false);
    let turn = [0.0, 0.0, (yaw_rad / 2.0).sin(), (yaw_rad / 2.0).cos()];
    cdr.u32(1).header(stamp_ns, parent).text(child).f64s(&[x_m, 0.0, 0.0]).f64s(&turn);
    cdr.bytes
}

const CLOUD: &str = "sensor_msgs/msg/PointCloud2";
const DETECTIONS: &str = "vision_msgs/msg/Detection3DArray";
const TRANSFORMS: &str = "tf2_msgs/msg/TFMessage";

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

#[test]
fn a_cloud_of_ros_is_read_whatever_its_layout() {
    for (options, is_big_endian) in write_options().into_iter().zip([false, true, false, true, false]) {
        let workplace = Workplace::new();
        let messages = [1, 2, 3].map(|second| {
            let time_ns = second * SECOND;
            ("/top", CLOUD, "cdr", time_ns, organised_cloud(time_ns, "lidar", is_big_endian))
        });
        let dataset = open(&write(&workplace, options, &messages));
        assert_eq!(
            (dataset.scan_ids().len(), dataset.scan_ids()[2].to_string()),
            (3, "drive/000002".to_owned())
        );
        assert_eq!(dataset.scan_time_ns(1), Some(2 * SECOND));
        let scan = dataset.read_scan(1).unwrap();
        // The third point has no position.
        assert!(scan.cloud.positions_m().eq([0, 1, 3].map(|index| POSITIONS_M[index])), "{:?}", scan.cloud);
        assert_eq!((scan.cloud.intensity(), &scan.points_left_out[..]), (&[300.0; 3][..], &[2][..]));
        assert_eq!((scan.cloud.ring(), scan.cloud.time_offset_s()), (Some(&[0xbb; 3][..]), None));
        // Nobody labelled anything.
        assert_eq!((scan.annotations.len(), scan.point_regions), (0, vec![PointRegion::Outside; 3]));
        assert_eq!(dataset.world_from_sensor(1).unwrap(), None);
    }
}

#[test]
fn moments_of_points_and_the_stamp_are_distinguished_in_whatever_unit() {
    // The points of one row, of which each has its moment as `f64`.
    let cloud = |stamp_ns: u64, moments: [f64; 2]| {
        let data: Vec<u8> = moments
            .iter()
            .flat_map(|it| {
                let position = [5.0_f32, 1.0, -1.0].into_iter().flat_map(f32::to_le_bytes);
                position.chain(it.to_le_bytes()).collect::<Vec<u8>>()
            })
            .collect();
        let mut cdr = Cdr::new(false);
        cdr.header(stamp_ns, "lidar").u32(1).u32(2).u32(4);
        for (name, offset, number) in [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("timestamp", 12, 8)] {
            cdr.text(name).u32(offset).u8(number).u32(1);
        }
        cdr.u8(0).u32(20).u32(40).data(&data).u8(0);
        cdr.bytes
    };
    let stamp_s = 1_700_000_000.0;
    let check = |moments: [f64; 2], expected: Option<[f32; 2]>| {
        let workplace = Workplace::new();
        let stamp_ns = 1_700_000_000 * SECOND;
        let messages = [("/top", CLOUD, "cdr", stamp_ns, cloud(stamp_ns, moments))];
        let scan = open(&write(&workplace, WriteOptions::new(), &messages)).read_scan(0).unwrap();
        match (scan.cloud.time_offset_s(), expected) {
            (Some(found), Some(expected)) => {
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
            }
            (found, expected) => assert_eq!((found, expected), (None, None)),
        }
    };
    check([stamp_s - 0.05, stamp_s + 0.05], Some([-0.05, 0.05]));
    check([1e9 * (stamp_s - 0.05), 1e9 * (stamp_s + 0.05)], Some([-0.05, 0.05]));
    // Microseconds, since the sensor was switched on, and not at all.
    check([1e6 * stamp_s; 2], None);
    check([12.0, 12.1], None);
    check([stamp_s, f64::NAN], None);
}

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

#[test]
fn boxes_of_another_frame_are_carried_over() {
    let workplace = Workplace::new();
    let dataset = open(&write_drive(&workplace, WriteOptions::new()));
    let scan = dataset.read_scan(1).unwrap();
    let [annotation] = &scan.annotations[..] else { panic!("{:?}", scan.annotations) };
    assert_eq!((annotation.class, annotation.track), (AnnotationClass::Car, Some(17)));
    // Halfway between 20 and 30 m the sensor is at (25, 1) and looks along y: the box is 5 m ahead.
    let bounding_box = annotation.bounding_box.unwrap();
    for (found, expected) in bounding_box.center_m.into_iter().zip([5.0, 0.0, -0.7]) {
        assert!((found - expected).abs() < 1e-5, "{bounding_box:?}");
    }
    assert!(bounding_box.yaw_rad.abs() < 1e-6 && bounding_box.length_width_height_m == [4.0, 2.0, 1.5]);
    assert_eq!(annotation.point_indices, [0, 1]);
    assert_eq!(scan.point_regions, [PointRegion::Labeled; 3]);
    let at = dataset.world_from_sensor(1).unwrap().unwrap().translation.vector;
    assert!((at - nalgebra::Vector3::new(25.0, 1.0, 0.0)).norm() < 1e-9, "{at}");
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

#[test]
fn foxglove_in_json_is_read() {
    let workplace = Workplace::new();
    let messages = foxglove_messages(SECOND, &category("REGULAR_VEHICLE"));
    let scan = open(&write(&workplace, WriteOptions::new(), &messages)).read_scan(0).unwrap();
    let [car] = &scan.annotations[..] else { panic!("{:?}", scan.annotations) };
    // The origin is the sensor's, which is at (1, 0, 2) in the frame.
    assert_eq!(car.bounding_box.unwrap().center_m, [5.0, 1.0, -1.0]);
    assert_eq!((car.class, &car.point_indices[..]), (AnnotationClass::Car, &[0][..]));
}

#[test]
fn of_several_topics_one_is_chosen() {
    let workplace = Workplace::new();
    let rear = ("/rear", CLOUD, "cdr", SECOND, organised_cloud(SECOND, "rear", false));
    let path = write(&workplace, WriteOptions::new(), &[cloud_at(SECOND), cloud_at(2 * SECOND), rear]);
    let error = try_open(&path).err().expect("several topics");
    assert!(error.is_usage_error());
    let message = error.to_string();
    for part in
        ["--topic", "/rear (sensor_msgs/msg/PointCloud2, 1 messages)", "/top (sensor_msgs/msg/PointCloud2, 2"]
    {
        assert!(message.contains(part), "{message}");
    }
    let topics = TopicChoice { cloud: Some("/rear".to_owned()), annotations: None };
    let options = OpenOptions { topics, ..OpenOptions::default() };
    let dataset = open_dataset(path.to_str().unwrap(), &options, &built_in_catalogue().unwrap()).unwrap();
    assert_eq!(dataset.scan_ids().len(), 1);
    // The option reaches the program.
    workplace.succeed("detect drive.mcap --scan 0 --topic /rear");
}

fn open_skipping(path: &std::path::Path) -> Result<Box<dyn scans::dataset::Dataset>, DatasetError> {
    let options = OpenOptions { damage: DamagePolicy::Skip, ..OpenOptions::default() };
    open_dataset(path.to_str().unwrap(), &options, &built_in_catalogue().unwrap())
}

#[test]
fn a_recording_that_was_cut_off_is_refused_or_read_to_the_cut() {
    let workplace = Workplace::new();
    let messages: Vec<Logged> = (1..20).map(|second| cloud_at(second * SECOND)).collect();
    let path = write(&workplace, WriteOptions::new().chunk_size(Some(100)).compression(None), &messages);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    check_damaged(&path, &["drive.mcap", "is cut off"]);
    let dataset = open_skipping(&path).unwrap();
    let n_scans = dataset.scan_ids().len();
    assert!((5..15).contains(&n_scans), "{n_scans}");
    (0..n_scans).for_each(|scan_idx| assert_eq!(dataset.read_scan(scan_idx).unwrap().cloud.len(), 3));
}

#[test]
fn damage_is_named() {
    let check = |cloud: Vec<u8>, parts: &[&str]| {
        let workplace = Workplace::new();
        let messages = [cloud_at(SECOND), ("/top", CLOUD, "cdr", 2 * SECOND, cloud)];
        let path = write(&workplace, WriteOptions::new(), &messages);
        check_damaged(&path, &[&["drive.mcap", "logged at 2000000000 ns"], parts].concat());
    };
    let sound = organised_cloud(SECOND, "lidar", false);
    check(sound[..40].to_vec(), &["CDR message that needs"]);
    let changed = |position: usize, value: u8| {
        let mut cloud = sound.clone();
        cloud[position] = value;
        cloud
    };
    check(changed(1, 9), &["unknown representation 0009"]);
    // Rows and columns follow stamp and frame: 4 + 8 + 4 + 6 + 2 bytes on.
    check(changed(27, 255), &["announces 4278190082 x 2 points"]);
    check(changed(31, 255), &["announces 2 x 4278190082 points"]);
    check_damaged(
        &{
            let workplace = Box::leak(Box::new(Workplace::new()));
            let path = write(workplace, WriteOptions::new(), &[cloud_at(SECOND)]);
            let mut bytes = std::fs::read(&path).unwrap();
            // Within the compressed records of the first chunk.
            bytes[120] ^= 0xff;
            std::fs::write(&path, bytes).unwrap();
            path
        },
        &["drive.mcap", "chunk"],
    );
}

#[test]
fn a_file_that_is_no_recording_is_refused() {
    let workplace = Workplace::new();
    workplace.write("drive.mcap", "no recording");
    let error = try_open(&workplace.path("drive.mcap")).err().expect("no recording");
    assert!(error.to_string().contains("has no data set in a known format"), "{error}");
}
