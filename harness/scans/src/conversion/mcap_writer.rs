//! Scans as an MCAP recording: `foxglove.PointCloud`, `foxglove.SceneUpdate` and `foxglove.FrameTransform` in protobuf, in
//! chunks with indexes.
//!
//! Values that these messages have no place for are in further fields of the points (see [`own_fields`]) and in a metadata
//! record (see [`own_metadata`]), so that reading a recording gives back all that was written.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions, Writer};
use nalgebra::Isometry3;
use prost::Message;
use reports::files::whole_file::WholeFile;
use serde::Serialize;

use super::scene::{SENSOR_FRAME, entities_of, scene_of};
use super::stable_summary::{Ending, StableSummary};
use super::{ConversionError, ScanToWrite, ScanWriter};
use crate::annotation::{LabeledScan, PointRegion};
use crate::dataset::data_sheet::DataSheet;
use crate::dataset::mcap::foxglove_messages::{
    FRAME_TRANSFORM, FrameTransform, POINT_CLOUD, PackedElementField, PointCloud, Pose, Quaternion,
    SCENE_UPDATE, Timestamp, Vector3, number_of,
};
use crate::dataset::mcap::foxglove_scene::SceneUpdate;
use crate::dataset::mcap::mcap_dataset::own_metadata;
use crate::dataset::mcap::recorded_cloud::own_fields;
use crate::dataset::mcap::topics::ANNOTATION_TOPIC;
use crate::dataset::packed_points::{NumberType, RING, TIME_OFFSET};
use crate::dataset::points_of_boxes::points_of_boxes;

/// The topic of the clouds.
pub const CLOUD_TOPIC: &str = "/lidar/points";

/// Descriptions of the messages, so that other programs can read them: `foxglove.proto` as a serialised `FileDescriptorSet`.
const DESCRIPTIONS: &[u8] = include_bytes!("foxglove.desc");

const TRANSFORM_TOPIC: &str = "/tf";

/// The frame that the sensor moves in.
const WORLD_FRAME: &str = "map";

/// How chunks are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChunkCompression {
    /// Smallest.
    Zstd,
    /// Fastest to read of the compressed ones.
    Lz4,
    /// Not at all.
    None,
}

impl ChunkCompression {
    fn method(self) -> Option<Compression> {
        match self {
            Self::Zstd => Some(Compression::Zstd),
            Self::Lz4 => Some(Compression::Lz4),
            Self::None => None,
        }
    }
}

type McapFile = Writer<NoSeek<StableSummary<WholeFile>>>;

/// A recording that is being written.
pub struct McapWriter {
    path: PathBuf,
    writer: McapFile,
    ending: Ending,
    channels: BTreeMap<String, u16>,
    n_written: u32,
    sheet: DataSheet,
    scan_ids: Vec<(String, u32)>,
}

impl McapWriter {
    /// Begins the recording `path`, with the data sheet `sheet`.
    pub fn create(
        path: &Path,
        compression: ChunkCompression,
        sheet: DataSheet,
    ) -> Result<Self, ConversionError> {
        let (file, ending) = StableSummary::new(WholeFile::create(path)?);
        let options = WriteOptions::new()
            .compression(compression.method())
            .compression_threads(0)
            .disable_seeking(true)
            .library(concat!("scanbench ", env!("CARGO_PKG_VERSION")));
        let writer = options.create(NoSeek::new(file)).map_err(refused(path))?;
        let (path, channels) = (path.to_path_buf(), BTreeMap::new());
        Ok(Self { path, writer, ending, channels, n_written: 0, sheet, scan_ids: Vec::new() })
    }

    /// Appends a message in protobuf; its topic is announced before the first one.
    pub fn write_message(
        &mut self,
        topic: &str,
        schema: &str,
        time_ns: u64,
        message: &impl Message,
    ) -> Result<(), ConversionError> {
        let announce = |writer: &mut McapFile| {
            let schema = writer.add_schema(schema, "protobuf", DESCRIPTIONS)?;
            writer.add_channel(schema, topic, "protobuf", &BTreeMap::new())
        };
        self.write_bytes(topic, announce, time_ns, &message.encode_to_vec())
    }

    /// Appends a message in JSON, which `schema` describes by its name and as JSON schema.
    pub fn write_json(
        &mut self,
        topic: &str,
        schema: [&str; 2],
        time_ns: u64,
        message: &impl Serialize,
    ) -> Result<(), ConversionError> {
        let [name, description] = schema;
        let announce = |writer: &mut McapFile| {
            let schema = writer.add_schema(name, "jsonschema", description.as_bytes())?;
            writer.add_channel(schema, topic, "json", &BTreeMap::new())
        };
        let bytes = serde_json::to_vec(message).expect("messages have text keys only");
        self.write_bytes(topic, announce, time_ns, &bytes)
    }

    fn write_bytes(
        &mut self,
        topic: &str,
        announce: impl FnOnce(&mut McapFile) -> Result<u16, McapError>,
        time_ns: u64,
        bytes: &[u8],
    ) -> Result<(), ConversionError> {
        let refused = refused(&self.path);
        let channel_id = if let Some(id) = self.channels.get(topic) {
            *id
        } else {
            let id = announce(&mut self.writer).map_err(&refused)?;
            self.channels.insert(topic.to_owned(), id);
            id
        };
        let header =
            MessageHeader { channel_id, sequence: self.n_written, log_time: time_ns, publish_time: time_ns };
        self.n_written = self.n_written.wrapping_add(1);
        self.writer.write_to_known_channel(&header, bytes).map_err(refused)
    }

    /// Appends a scene on `topic`.
    pub fn write_scene(
        &mut self,
        topic: &str,
        time_ns: u64,
        scene: &SceneUpdate,
    ) -> Result<(), ConversionError> {
        self.write_message(topic, SCENE_UPDATE, time_ns, scene)
    }
}

impl ScanWriter for McapWriter {
    fn write(&mut self, to_write: &ScanToWrite<'_>) -> Result<(), ConversionError> {
        let &ScanToWrite { scan, time_ns, world_from_sensor } = to_write;
        if let Some(world_from_sensor) = world_from_sensor {
            self.write_message(
                TRANSFORM_TOPIC,
                FRAME_TRANSFORM,
                time_ns,
                &transform(time_ns, &world_from_sensor),
            )?;
        }
        // Before the cloud, so that both are in one chunk. A scan without labels gets no scene.
        let says_something = scan.point_regions.iter().any(|it| *it != PointRegion::Outside);
        if says_something || !scan.annotations.is_empty() {
            let scene = scene_of(time_ns, entities_of(time_ns, &scan.annotations));
            self.write_scene(ANNOTATION_TOPIC, time_ns, &scene)?;
        }
        self.write_message(CLOUD_TOPIC, POINT_CLOUD, time_ns, &cloud_of(scan, time_ns))?;
        self.scan_ids.push((scan.id.sequence.clone(), scan.id.index));
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), ConversionError> {
        let refused = refused(&self.path);
        let scan_ids = serde_json::to_string(&self.scan_ids).expect("texts and numbers");
        let metadata = BTreeMap::from([
            (own_metadata::DATA_SHEET.to_owned(), self.sheet.to_json()),
            (own_metadata::SCAN_IDS.to_owned(), scan_ids),
        ]);
        let record = Metadata { name: own_metadata::RECORD.to_owned(), metadata };
        self.writer.write_metadata(&record).map_err(&refused)?;
        self.ending.begin();
        self.writer.finish().map_err(&refused)?;
        let file = self.writer.into_inner().into_inner().finish();
        file.map_err(|source| refused(McapError::Io(source)))?.finish()?;
        Ok(())
    }
}

fn refused(path: &Path) -> impl Fn(McapError) -> ConversionError + use<> {
    let path = path.to_path_buf();
    move |source| ConversionError::Recording { path: path.clone(), source }
}

fn transform(time_ns: u64, world_from_sensor: &Isometry3<f64>) -> FrameTransform {
    let at = world_from_sensor.translation.vector;
    let turn = world_from_sensor.rotation.quaternion();
    FrameTransform {
        timestamp: Some(Timestamp::from_nanoseconds(time_ns)),
        parent_frame_id: WORLD_FRAME.to_owned(),
        child_frame_id: SENSOR_FRAME.to_owned(),
        translation: Some(Vector3 { x: at.x, y: at.y, z: at.z }),
        rotation: Some(Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w }),
    }
}

fn cloud_of(scan: &LabeledScan, time_ns: u64) -> PointCloud {
    let cloud = &scan.cloud;
    let objects = objects_of_points(scan);
    let regions = scan
        .point_regions
        .iter()
        .any(|it| *it != PointRegion::Labeled)
        .then(|| scan.point_regions.iter().map(|it| it.number()).collect::<Vec<u8>>());
    let mut fields = Vec::new();
    let mut point_stride = 0;
    let mut add_field = |name: &str, number: NumberType| {
        fields.push(PackedElementField {
            name: name.to_owned(),
            offset: point_stride,
            number: number_of(number),
        });
        point_stride += number.n_bytes() as u32;
    };
    for name in ["x", "y", "z", "intensity"] {
        add_field(name, NumberType::F32);
    }
    if cloud.ring().is_some() {
        add_field(RING, NumberType::U16);
    }
    if cloud.time_offset_s().is_some() {
        add_field(TIME_OFFSET, NumberType::F32);
    }
    if objects.is_some() {
        add_field(own_fields::OBJECT, NumberType::U32);
    }
    if regions.is_some() {
        add_field(own_fields::REGION, NumberType::U8);
    }
    let mut data = Vec::with_capacity(cloud.len() * point_stride as usize);
    for (point_idx, ([x, y, z], intensity)) in cloud.positions_m().zip(cloud.intensity()).enumerate() {
        for value in [x, y, z, *intensity] {
            data.extend_from_slice(&value.to_le_bytes());
        }
        if let Some(rings) = cloud.ring() {
            data.extend_from_slice(&rings[point_idx].to_le_bytes());
        }
        if let Some(times_s) = cloud.time_offset_s() {
            data.extend_from_slice(&times_s[point_idx].to_le_bytes());
        }
        if let Some(objects) = &objects {
            data.extend_from_slice(&objects[point_idx].to_le_bytes());
        }
        if let Some(regions) = &regions {
            data.push(regions[point_idx]);
        }
    }
    let timestamp = Some(Timestamp::from_nanoseconds(time_ns));
    let orientation = Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 });
    let pose = Some(Pose { position: Some(Vector3::default()), orientation });
    PointCloud { timestamp, frame_id: SENSOR_FRAME.to_owned(), pose, point_stride, fields, data }
}

/// For every point, the number of its annotation from 1 (0 for none); `None` where boxes alone give the same.
fn objects_of_points(scan: &LabeledScan) -> Option<Vec<u32>> {
    let boxes: Vec<_> = scan.annotations.iter().filter_map(|it| it.bounding_box).collect();
    if boxes.len() == scan.annotations.len() {
        let in_boxes = points_of_boxes(&scan.cloud, &boxes);
        if scan.annotations.iter().zip(&in_boxes).all(|(it, points)| it.point_indices == *points) {
            return None;
        }
    }
    let mut objects = vec![0; scan.cloud.len()];
    for (number, annotation) in (1..).zip(&scan.annotations) {
        for point_idx in &annotation.point_indices {
            objects[*point_idx as usize] = number;
        }
    }
    Some(objects)
}
