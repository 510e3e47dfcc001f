//! The topics of a recording that are read.

use std::collections::BTreeMap;
use std::path::Path;

use super::foxglove_messages::{FRAME_TRANSFORM, FRAME_TRANSFORMS, POINT_CLOUD, SCENE_UPDATE};
use super::mcap_index::{ChannelInfo, McapIndex};
use super::ros_messages::{DETECTION_3D_ARRAY, POINT_CLOUD_2, TF_MESSAGE};
use crate::dataset::DatasetError;
use crate::dataset::shown_name::shown;
use crate::dataset::source::TopicChoice;

/// The topic of the annotations if several topics could hold them.
pub const ANNOTATION_TOPIC: &str = "/annotations";

/// The kind of the messages of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageKind {
    /// `sensor_msgs/msg/PointCloud2`.
    RosCloud,
    /// `foxglove.PointCloud`.
    FoxgloveCloud,
    /// `foxglove.SceneUpdate`.
    Scene,
    /// `vision_msgs/msg/Detection3DArray`.
    RosDetections,
    /// `tf2_msgs/msg/TFMessage`.
    RosTransforms,
    /// `foxglove.FrameTransform`.
    FoxgloveTransform,
    /// `foxglove.FrameTransforms`.
    FoxgloveTransforms,
}

impl MessageKind {
    /// The kind of the messages of `channel`; `None` if they are not read.
    pub fn of(channel: &ChannelInfo) -> Option<Self> {
        let is_foxglove = matches!(channel.encoding.as_str(), "protobuf" | "json");
        match (channel.schema.as_str(), channel.encoding.as_str()) {
            (POINT_CLOUD_2, "cdr") => Some(Self::RosCloud),
            (DETECTION_3D_ARRAY, "cdr") => Some(Self::RosDetections),
            (TF_MESSAGE, "cdr") => Some(Self::RosTransforms),
            (POINT_CLOUD, _) if is_foxglove => Some(Self::FoxgloveCloud),
            (SCENE_UPDATE, _) if is_foxglove => Some(Self::Scene),
            (FRAME_TRANSFORM, _) if is_foxglove => Some(Self::FoxgloveTransform),
            (FRAME_TRANSFORMS, _) if is_foxglove => Some(Self::FoxgloveTransforms),
            _ => None,
        }
    }

    /// Whether the messages are clouds.
    pub fn is_cloud(self) -> bool {
        matches!(self, Self::RosCloud | Self::FoxgloveCloud)
    }

    /// Whether the messages are objects with boxes.
    pub fn is_objects(self) -> bool {
        matches!(self, Self::Scene | Self::RosDetections)
    }

    /// Whether the messages are transforms between frames.
    pub fn is_transforms(self) -> bool {
        matches!(self, Self::RosTransforms | Self::FoxgloveTransform | Self::FoxgloveTransforms)
    }
}

/// A channel that is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChosenChannel {
    /// Its number, and those of channels with the same kind of messages on the same topic.
    pub ids: Vec<u16>,
    /// The kind of its messages.
    pub kind: MessageKind,
    /// Its topic, schema and encoding.
    pub info: ChannelInfo,
}

/// The channels that are read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChosenChannels {
    /// Clouds.
    pub cloud: ChosenChannel,
    /// Annotations, if there are any.
    pub annotations: Option<ChosenChannel>,
    /// All transforms between frames.
    pub transforms: Vec<ChosenChannel>,
}

/// Chooses among the channels of `index`, which is that of the file at `path`.
pub fn choose_channels(
    path: &Path,
    index: &McapIndex,
    choice: &TopicChoice,
) -> Result<ChosenChannels, DatasetError> {
    let known = |is_wanted: fn(MessageKind) -> bool| known_channels(index, is_wanted);
    let error = |problem: String, candidates: &[ChosenChannel]| refused(path, &problem, index, candidates);
    let unmixed = |chosen: &ChosenChannel, candidates: &[ChosenChannel]| {
        let same: Vec<ChosenChannel> =
            candidates.iter().filter(|it| it.info.topic == chosen.info.topic).cloned().collect();
        match same.len() {
            0 | 1 => Ok(()),
            _ => Err(error(
                format!("has several types of messages on the topic {:?}", chosen.info.topic),
                &same,
            )),
        }
    };
    let clouds = known(MessageKind::is_cloud);
    let cloud = match &choice.cloud {
        Some(topic) => clouds
            .iter()
            .find(|it| it.info.topic == *topic)
            .ok_or_else(|| error(format!("has no point clouds on the topic {topic:?}"), &clouds)),
        None => match &clouds[..] {
            [] => Err(error("has no point clouds".to_owned(), &[])),
            [only, others @ ..] if others.iter().all(|it| it.info.topic == only.info.topic) => Ok(only),
            _ => {
                Err(error("has point clouds on several topics; choose one with --topic".to_owned(), &clouds))
            }
        },
    }?;
    unmixed(cloud, &clouds)?;
    let objects = known(MessageKind::is_objects);
    let named = |topic: &str| objects.iter().find(|it| it.info.topic == topic);
    let annotations = match (&choice.annotations, &objects[..]) {
        (Some(topic), _) => Some(
            named(topic)
                .ok_or_else(|| error(format!("has no annotations on the topic {topic:?}"), &objects))?,
        ),
        (None, []) => None,
        (None, [only, others @ ..]) if others.iter().all(|it| it.info.topic == only.info.topic) => Some(only),
        (None, _) => Some(named(ANNOTATION_TOPIC).ok_or_else(|| {
            let problem =
                "has objects on several topics; choose that of the annotations with --annotation-topic";
            error(problem.to_owned(), &objects)
        })?),
    };
    annotations.map_or(Ok(()), |it| unmixed(it, &objects))?;
    Ok(ChosenChannels {
        cloud: cloud.clone(),
        annotations: annotations.cloned(),
        transforms: known(MessageKind::is_transforms),
    })
}

/// The channels of a recording of detections.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DetectionChannels {
    /// The detected objects.
    pub objects: ChosenChannel,
    /// Clouds, if they are on a single topic.
    pub cloud: Option<ChosenChannel>,
    /// All transforms between frames.
    pub transforms: Vec<ChosenChannel>,
}

/// Chooses the objects on `topic`; without it, those of the only topic beside [`ANNOTATION_TOPIC`], or of this if alone.
pub fn choose_detections(
    path: &Path,
    index: &McapIndex,
    topic: Option<&str>,
) -> Result<DetectionChannels, DatasetError> {
    let objects = known_channels(index, MessageKind::is_objects);
    let error = |problem: String| refused(path, &problem, index, &objects);
    let is_wanted = |it: &&ChosenChannel| match topic {
        Some(topic) => it.info.topic == topic,
        None => objects.len() == 1 || it.info.topic != ANNOTATION_TOPIC,
    };
    let wanted: Vec<&ChosenChannel> = objects.iter().filter(is_wanted).collect();
    let objects_of = match (&wanted[..], topic) {
        ([only], _) => *only,
        ([], Some(topic)) => return Err(error(format!("has no objects on the topic {topic:?}"))),
        ([], None) => return Err(error("has no objects".to_owned())),
        (_, Some(topic)) => {
            return Err(error(format!("has several types of messages on the topic {topic:?}")));
        }
        (_, None) => {
            let problem = "has objects on several topics; name one behind the file, as in a.mcap:/topic";
            return Err(error(problem.to_owned()));
        }
    };
    let clouds = known_channels(index, MessageKind::is_cloud);
    Ok(DetectionChannels {
        objects: objects_of.clone(),
        cloud: clouds.first().filter(|_| clouds.len() == 1).cloned(),
        transforms: known_channels(index, MessageKind::is_transforms),
    })
}

/// The channels whose messages are wanted, by topic.
///
/// A topic may have been announced several times: channels of the same schema and encoding count as one, and those without
/// messages do not count beside others.
fn known_channels(index: &McapIndex, is_wanted: fn(MessageKind) -> bool) -> Vec<ChosenChannel> {
    let channels = index.channels.iter().filter_map(|(&id, info)| {
        let kind = MessageKind::of(info).filter(|kind| is_wanted(*kind))?;
        Some(ChosenChannel { ids: vec![id], kind, info: info.clone() })
    });
    let mut by_topic: BTreeMap<String, Vec<ChosenChannel>> = BTreeMap::new();
    for channel in channels {
        let of_topic = by_topic.entry(channel.info.topic.clone()).or_default();
        match of_topic.iter_mut().find(|it| it.info == channel.info) {
            Some(same) => same.ids.extend(channel.ids),
            None => of_topic.push(channel),
        }
    }
    for of_topic in by_topic.values_mut() {
        of_topic.sort_by_key(|it| std::cmp::Reverse(n_messages(index, it)));
        let n_with_messages = of_topic.iter().filter(|it| n_messages(index, it) > 0).count();
        of_topic.truncate(n_with_messages.max(1));
    }
    by_topic.into_values().flatten().collect()
}

fn n_messages(index: &McapIndex, channel: &ChosenChannel) -> usize {
    channel.ids.iter().filter_map(|id| index.messages.get(id)).map(Vec::len).sum()
}

/// The error about the recording at `path` that lists `candidates` or, if there are none, all its channels.
fn refused(path: &Path, problem: &str, index: &McapIndex, candidates: &[ChosenChannel]) -> DatasetError {
    let candidate = |it: &ChosenChannel| {
        format!("{} ({}, {} messages)", shown(&it.info.topic), shown(&it.info.schema), n_messages(index, it))
    };
    let any =
        |it: &ChannelInfo| format!("{} ({} as {})", shown(&it.topic), shown(&it.schema), shown(&it.encoding));
    let topics: Vec<String> = if candidates.is_empty() {
        index.channels.values().map(any).collect()
    } else {
        candidates.iter().map(candidate).collect()
    };
    DatasetError::Usage(format!("{path:?} {problem}: {}", topics.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::mcap::mcap_index::MessagePosition;

    fn index(topics: &[(&str, &str, &str)]) -> McapIndex {
        let channels = (0_u16..).zip(topics).map(|(id, &(topic, schema, encoding))| {
            let [topic, schema, encoding] = [topic, schema, encoding].map(str::to_owned);
            (id, ChannelInfo { topic, schema, encoding })
        });
        McapIndex { channels: channels.collect(), ..McapIndex::default() }
    }

    /// Topics of clouds and annotations, or a part of the error.
    #[track_caller]
    fn check(
        topics: &[(&str, &str, &str)],
        choice: [Option<&str>; 2],
        expected: Result<(&str, Option<&str>), &str>,
    ) {
        let [cloud, annotations] = choice.map(|topic| topic.map(str::to_owned));
        let found = choose_channels(Path::new("a.mcap"), &index(topics), &TopicChoice { cloud, annotations });
        match (found, expected) {
            (Ok(found), Ok(expected)) => {
                let annotations = found.annotations.as_ref().map(|it| it.info.topic.as_str());
                assert_eq!((found.cloud.info.topic.as_str(), annotations), expected);
            }
            (Err(error), Err(part)) => {
                assert!(error.to_string().contains(part), "{error}");
                assert!(error.is_usage_error());
            }
            (found, expected) => panic!("{found:?}, expected {expected:?}"),
        }
    }

    #[test]
    fn channels_that_carry_the_same_are_one_and_others_are_not_guessed() {
        let position = |offset| MessagePosition { log_time_ns: offset, chunk_idx: None, offset };
        let mut index = index(&[TOP, TOP, LABELS, ("/top", POINT_CLOUD, "json")]);
        index.messages.insert(0, vec![position(1)]);
        index.messages.insert(1, vec![position(2), position(3)]);
        let choice = TopicChoice { cloud: Some("/top".to_owned()), annotations: None };
        let found = choose_channels(Path::new("a.mcap"), &index, &choice).unwrap();
        assert_eq!(found.cloud.ids, [0, 1]);
        index.messages.insert(3, vec![position(4)]);
        for choice in [choice, TopicChoice::default()] {
            let error = choose_channels(Path::new("a.mcap"), &index, &choice).expect_err("two kinds");
            let message = error.to_string();
            assert!(
                message.contains("several types of messages on the topic \"/top\": /top (sensor_msgs"),
                "{message}"
            );
        }
    }

    #[test]
    fn what_cannot_be_shown_is_escaped() {
        check(&[("/a\u{1b}[31m", "b\n", "c")], [None, None], Err("/a\\u{1b}[31m (b\\n as c)"));
    }

    const TOP: (&str, &str, &str) = ("/top", POINT_CLOUD_2, "cdr");
    const REAR: (&str, &str, &str) = ("/rear", POINT_CLOUD, "protobuf");
    const LABELS: (&str, &str, &str) = (ANNOTATION_TOPIC, SCENE_UPDATE, "json");
    const TRACKS: (&str, &str, &str) = ("/tracks", DETECTION_3D_ARRAY, "cdr");

    #[test]
    fn the_only_topic_is_taken() {
        check(
            &[TOP, TRACKS, ("/imu", "sensor_msgs/msg/Imu", "cdr")],
            [None, None],
            Ok(("/top", Some("/tracks"))),
        );
        check(&[TOP], [None, None], Ok(("/top", None)));
    }

    #[test]
    fn of_several_one_is_named() {
        check(
            &[TOP, REAR],
            [None, None],
            Err("choose one with --topic: /rear (foxglove.PointCloud, 0 messages), /top"),
        );
        check(&[TOP, REAR], [Some("/rear"), None], Ok(("/rear", None)));
        check(&[TOP, LABELS, TRACKS], [None, None], Ok(("/top", Some(ANNOTATION_TOPIC))));
        check(&[TOP, LABELS, TRACKS], [None, Some("/tracks")], Ok(("/top", Some("/tracks"))));
        let other = ("/other", SCENE_UPDATE, "json");
        check(
            &[TOP, other, TRACKS],
            [None, None],
            Err("choose that of the annotations with --annotation-topic: /other"),
        );
    }

    #[test]
    fn what_is_not_there_is_refused_with_what_is() {
        check(&[TOP], [Some("/topp"), None], Err("no point clouds on the topic \"/topp\": /top ("));
        check(&[TOP, LABELS], [None, Some("/x")], Err("no annotations on the topic \"/x\": /annotations ("));
        check(
            &[("/imu", "sensor_msgs/msg/Imu", "cdr")],
            [None, None],
            Err("has no point clouds: /imu (sensor_msgs"),
        );
        check(
            &[("/top", POINT_CLOUD_2, "ros1")],
            [None, None],
            Err("/top (sensor_msgs/msg/PointCloud2 as ros1)"),
        );
    }
}
