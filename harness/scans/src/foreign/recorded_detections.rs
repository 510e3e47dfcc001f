//! Detections in an MCAP recording: `foxglove.SceneUpdate` or `vision_msgs/Detection3DArray`, a message for each scan.
//!
//! A message belongs to the scan with the nearest time stamp (see [`time_pairs`](crate::dataset::time_pairs)). Its boxes may
//! be in another frame than the cloud, if the recording of the results has the transform. The score is that of the likeliest
//! hypothesis, or the metadata `score`, `confidence` or `probability` of a scene entity; an empty class is an unknown one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use reports::vocabulary::class::AnnotationClass;

use super::detections::{ForeignBox, ForeignDetections};
use super::result_reader::{FoundInScan, OpenResults, ResultReader, ResultsOf};
use crate::annotation::LabeledScan;
use crate::dataset::DatasetError;
use crate::dataset::class_table::{ClassReader, ClassRules};
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::mcap::frame_tree::FrameTree;
use crate::dataset::mcap::mcap_dataset::own_metadata;
use crate::dataset::mcap::mcap_file::McapFile;
use crate::dataset::mcap::mcap_index::{MessagePosition, index_mcap};
use crate::dataset::mcap::recorded_cloud::RecordedCloud;
use crate::dataset::mcap::recorded_messages::{Channel, RecordedMessages};
use crate::dataset::mcap::scene_objects::SceneObject;
use crate::dataset::mcap::topics::{DetectionChannels, MessageKind, choose_detections};
use crate::dataset::time_pairs::{Moment, TimePairs, times_ns};
use crate::foreign::foreign_class::ForeignClass;

/// The frame of scans that are not recorded, as `data convert` names it.
const SENSOR_FRAME: &str = "lidar";

/// `path` without the topic behind `.mcap:`, and this topic, if there is no file with the whole name.
pub fn split_topic(path: &Path) -> (PathBuf, Option<String>) {
    match path.to_str().and_then(|it| it.split_once(":/")) {
        Some((file, topic)) if !path.exists() && Path::new(file).is_file() => {
            (PathBuf::from(file), Some(format!("/{topic}")))
        }
        _ => (path.to_path_buf(), None),
    }
}

/// The detections of a topic.
pub struct RecordedDetections {
    name: String,
    classes: ClassRules,
    messages: RecordedMessages,
    channel: Channel,
    asked: BTreeMap<usize, ScanFrame>,
    // The message of each scan.
    by_scan: BTreeMap<usize, MessagePosition>,
}

/// The time of a scan, and the frame of its cloud.
struct ScanFrame {
    moment: Moment,
    frame: String,
    sensor_from_frame: Isometry3<f64>,
}

impl ScanFrame {
    /// For a scan taken at `time_ns`; `own_frame` is the frame of scans that are not recorded. `None` without a time.
    fn of(frame: &ForeignFrame, time_ns: Option<u64>, own_frame: &str) -> Option<Self> {
        match frame {
            ForeignFrame::Recording { moment, frame, sensor_from_frame } => {
                Some(Self { moment: *moment, frame: frame.clone(), sensor_from_frame: *sensor_from_frame })
            }
            _ => Some(Self {
                moment: Moment { stamp_ns: Some(time_ns?), log_time_ns: time_ns? },
                frame: own_frame.to_owned(),
                sensor_from_frame: Isometry3::identity(),
            }),
        }
    }
}

impl RecordedDetections {
    /// Opens the recording at `path`, and notes the times of all its results.
    pub fn open(path: &Path, topic: Option<&str>, of: &ResultsOf<'_>) -> Result<OpenResults, DatasetError> {
        let mut index = index_mcap(path, own_metadata::RECORD, |channel| MessageKind::of(channel).is_some())?;
        if let Some(problem) = index.cut_off.take() {
            return Err(DatasetError::Damaged { path: path.to_path_buf(), problem });
        }
        let DetectionChannels { objects, cloud, transforms } = choose_detections(path, &index, topic)?;
        let chunks = std::mem::take(&mut index.chunks);
        let channel = Channel::take(&mut index, objects);
        let cloud = cloud.map(|it| Channel::take(&mut index, it));
        let transforms = transforms.into_iter().map(|it| Channel::take(&mut index, it)).collect();
        let messages = RecordedMessages::new(McapFile::new(path, chunks), transforms)?;
        let found = moments_of(&messages, &channel)?;
        // The frame of the clouds in the recording of the results.
        let own_frame = cloud.as_ref().map(|it| frame_of_clouds(&messages, it)).transpose()?.flatten();
        let own_frame = own_frame.unwrap_or_else(|| SENSOR_FRAME.to_owned());
        let frame_of = |(&scan_idx, frame): (&usize, &ForeignFrame)| {
            let time_ns = of.dataset.scan_time_ns(scan_idx);
            Some((scan_idx, ScanFrame::of(frame, time_ns, &own_frame)?))
        };
        let asked: Option<BTreeMap<usize, ScanFrame>> = of.asked.iter().map(frame_of).collect();
        let has_times = asked.is_some();
        of.require(path, |_| has_times, "names scans by their times", "has none")?;
        let asked = asked.unwrap_or_default();
        let (of_scans, scans) = scans_to_pair(&asked, of);
        let pairs = TimePairs::of(&scans, &found);
        let message_of = |(at, scan_idx): (usize, &usize)| Some((*scan_idx, pairs.message_of(at)?));
        let by_scan: BTreeMap<usize, usize> = of_scans.iter().enumerate().filter_map(message_of).collect();
        // Only known if all scans are asked for.
        let are_all = asked.len() >= of.dataset.scan_ids().len();
        let taken = pairs.taken();
        let left_over =
            times_ns(&found).into_iter().enumerate().filter(|(it, _)| are_all && !taken.contains(it));
        let left_over = left_over.map(|(_, time_ns)| format!("{time_ns} ns")).collect();
        let oddities = pairs.note("results").into_iter().collect();
        let by_scan = by_scan.into_iter().map(|(scan_idx, it)| (scan_idx, channel.positions[it])).collect();
        let (name, classes) = (path.display().to_string(), of.classes.clone());
        let results = Self { name, classes, messages, channel, asked, by_scan };
        Ok(OpenResults { oddities, ..OpenResults::new(results, left_over) })
    }

    fn boxes_of(
        &self,
        objects: &[SceneObject],
        position: MessagePosition,
        scan: &ScanFrame,
    ) -> Result<Vec<ForeignBox>, DatasetError> {
        let is_elsewhere = |it: &SceneObject| !it.frame.is_empty() && it.frame != scan.frame;
        let tree = if objects.iter().any(is_elsewhere) {
            self.messages.frames_at(Moment { log_time_ns: position.log_time_ns, ..scan.moment })?
        } else {
            FrameTree::default()
        };
        let mut classes = ClassReader::new(&self.classes, &[]);
        let mut boxes = Vec::with_capacity(objects.len());
        for object in objects {
            let class = match object.class_name.as_str() {
                "" => None,
                name => {
                    let class = classes.class_of(name, || position.to_string());
                    class.map(|it| ForeignClass::of(name, it))
                }
            };
            let frame = if object.frame.is_empty() { &scan.frame } else { &object.frame };
            let frame_from_object = tree.to_from(&scan.frame, frame).ok_or_else(|| {
                let ours = &scan.frame;
                self.messages.damaged(format!(
                    "has results in the frame {frame:?}, but no transform from it to that of the scans, {ours:?}"
                ))
            })?;
            let sensor_from_object = scan.sensor_from_frame * frame_from_object;
            let placed = object.annotation(AnnotationClass::Misc, &sensor_from_object);
            let placed = placed.map_err(|problem| self.messages.damaged_at(position, &problem))?;
            // An object without a box, such as a line or a text, is no detection.
            boxes.extend(placed.bounding_box.map(|it| ForeignBox {
                bounding_box: it,
                class,
                score: object.score,
                box_score: None,
                velocity_m_per_s: None,
                is_unlikely: false,
            }));
        }
        classes.unknown().refuse_results(&self.name)?;
        Ok(boxes)
    }
}

impl ResultReader for RecordedDetections {
    fn has(&self, scan_idx: usize) -> bool {
        self.by_scan.contains_key(&scan_idx)
    }

    fn read(&mut self, scan_idx: usize, _scan: &LabeledScan) -> FoundInScan {
        let Some(scan) = self.asked.get(&scan_idx) else { return Ok(None) };
        let Some(&position) = self.by_scan.get(&scan_idx) else { return Ok(None) };
        let (_, objects) = self.messages.read_objects(&self.channel, position)?;
        Ok(Some(ForeignDetections::of_boxes(self.boxes_of(&objects, position, scan)?)))
    }
}

/// Times of all results, which must differ: each belongs to another scan.
fn moments_of(messages: &RecordedMessages, channel: &Channel) -> Result<Vec<Moment>, DatasetError> {
    let mut moments = Vec::with_capacity(channel.positions.len());
    for &position in &channel.positions {
        let (stamp_ns, _) = messages.read_objects(channel, position)?;
        moments.push(Moment { stamp_ns, log_time_ns: position.log_time_ns });
    }
    let mut seen = BTreeSet::new();
    let twice = times_ns(&moments).into_iter().find(|it| !seen.insert(*it));
    let problem = |it| format!("has two messages of results with the time stamp {it} ns");
    twice.map_or(Ok(moments), |it| Err(messages.damaged(problem(it))))
}

/// Scans and their times. If time stamps are known, these are all scans of the data set, so that results of a scan that is
/// not asked for are not given to its neighbour.
fn scans_to_pair(asked: &BTreeMap<usize, ScanFrame>, of: &ResultsOf<'_>) -> (Vec<usize>, Vec<Moment>) {
    if asked.values().all(|it| it.moment.stamp_ns.is_none()) {
        return asked.iter().map(|(scan_idx, it)| (*scan_idx, it.moment)).unzip();
    }
    let moment = |scan_idx: usize| {
        let of_asked = asked.get(&scan_idx).map(|it| it.moment);
        let stamp_ns = of.dataset.scan_time_ns(scan_idx);
        Some((scan_idx, of_asked.or(Some(Moment { stamp_ns, log_time_ns: stamp_ns? }))?))
    };
    (0..of.dataset.scan_ids().len()).filter_map(moment).unzip()
}

/// The frame of the first cloud.
fn frame_of_clouds(messages: &RecordedMessages, clouds: &Channel) -> Result<Option<String>, DatasetError> {
    let Some(&position) = clouds.positions.first() else { return Ok(None) };
    let message = messages.message(position)?;
    let cloud = RecordedCloud::read(clouds.kind, &clouds.encoding, message.as_slice());
    let frame = cloud.map_err(|problem| messages.damaged_at(position, &problem))?.frame;
    Ok(Some(frame).filter(|it| !it.is_empty()))
}
