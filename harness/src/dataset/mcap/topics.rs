//! Which topics of a recording are read.

use std::collections::BTreeMap;
use std::path::Path;

use super::foxglove_messages::{FRAME_TRANSFORM, FRAME_TRANSFORMS, POINT_CLOUD, SCENE_UPDATE};
use super::recording_index::{ChannelInfo, RecordingIndex};
use super::ros_messages::{DETECTION_3D_ARRAY, POINT_CLOUD_2, TF_MESSAGE};
use crate::dataset::DatasetError;

/// Where annotations are looked for if several topics could hold them.
pub const ANNOTATION_TOPIC: &str = "/annotations";

/// What the messages of a channel are.
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
    /// What the messages of `channel` are; `None` for what is not read.
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

    /// Whether these are clouds.
    pub fn is_cloud(self) -> bool {
        matches!(self, Self::RosCloud | Self::FoxgloveCloud)
    }

    /// Whether these are objects with boxes.
    pub fn is_objects(self) -> bool {
        matches!(self, Self::Scene | Self::RosDetections)
    }

    /// Whether these say how frames lie to each other.
    pub fn is_transforms(self) -> bool {
        matches!(self, Self::RosTransforms | Self::FoxgloveTransform | Self::FoxgloveTransforms)
    }
}

/// Which topics were asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TopicChoice {
    /// That of the clouds; the only one if this is left out.
    pub cloud: Option<String>,
    /// That of the annotations; `/annotations` or the only one if this is left out.
    pub annotations: Option<String>,
}

/// A channel that is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChosenChannel {
    /// Its number.
    pub id: u16,
    /// What its messages are.
    pub kind: MessageKind,
    /// What it carries.
    pub info: ChannelInfo,
}

/// The channels that are read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChosenChannels {
    /// Clouds.
    pub cloud: ChosenChannel,
    /// Annotations, if there are any.
    pub annotations: Option<ChosenChannel>,
    /// Everything that says how frames lie to each other.
    pub transforms: Vec<ChosenChannel>,
}

/// Chooses among the channels of `index`, that of the file at `path`.
///
/// # Errors
///
/// [`DatasetError::Topic`] if there is no such topic, or there are several and none was asked for. It lists what there is.
pub fn choose_channels(
    path: &Path,
    index: &RecordingIndex,
    choice: &TopicChoice,
) -> Result<ChosenChannels, DatasetError> {
    let known = |is_wanted: fn(MessageKind) -> bool| -> Vec<ChosenChannel> {
        let channels = index.channels.iter().filter_map(|(&id, info)| {
            let kind = MessageKind::of(info).filter(|kind| is_wanted(*kind))?;
            Some(ChosenChannel { id, kind, info: info.clone() })
        });
        // A topic may have been announced several times; the one with messages counts.
        let mut by_topic: BTreeMap<String, ChosenChannel> = BTreeMap::new();
        for channel in channels {
            let is_better = by_topic
                .get(&channel.info.topic)
                .is_none_or(|other| n_messages(index, other) < n_messages(index, &channel));
            if is_better {
                by_topic.insert(channel.info.topic.clone(), channel);
            }
        }
        by_topic.into_values().collect()
    };
    let error = |problem: String, candidates: &[ChosenChannel]| DatasetError::Topic {
        path: path.to_path_buf(),
        problem,
        topics: if candidates.is_empty() { all_topics(index) } else { listed(index, candidates) },
    };
    let clouds = known(MessageKind::is_cloud);
    let cloud = match &choice.cloud {
        Some(topic) => clouds
            .iter()
            .find(|it| it.info.topic == *topic)
            .ok_or_else(|| error(format!("has no clouds on the topic {topic:?}"), &clouds)),
        None => match &clouds[..] {
            [] => Err(error("has no clouds".to_owned(), &[])),
            [only] => Ok(only),
            _ => Err(error("has clouds on several topics, name one by --topic".to_owned(), &clouds)),
        },
    }?;
    let objects = known(MessageKind::is_objects);
    let named = |topic: &str| objects.iter().find(|it| it.info.topic == topic);
    let annotations = match (&choice.annotations, &objects[..]) {
        (Some(topic), _) => Some(
            named(topic)
                .ok_or_else(|| error(format!("has no annotations on the topic {topic:?}"), &objects))?,
        ),
        (None, []) => None,
        (None, [only]) => Some(only),
        (None, _) => Some(named(ANNOTATION_TOPIC).ok_or_else(|| {
            let problem = "has objects on several topics, name that of the annotations by --annotation-topic";
            error(problem.to_owned(), &objects)
        })?),
    };
    Ok(ChosenChannels {
        cloud: cloud.clone(),
        annotations: annotations.cloned(),
        transforms: known(MessageKind::is_transforms),
    })
}

fn n_messages(index: &RecordingIndex, channel: &ChosenChannel) -> usize {
    index.messages.get(&channel.id).map_or(0, Vec::len)
}

fn listed(index: &RecordingIndex, channels: &[ChosenChannel]) -> Vec<String> {
    let describe = |it: &ChosenChannel| {
        let (topic, schema) = (it.info.topic.escape_debug(), it.info.schema.escape_debug());
        format!("{topic} ({schema}, {} messages)", n_messages(index, it))
    };
    channels.iter().map(describe).collect()
}

fn all_topics(index: &RecordingIndex) -> Vec<String> {
    let describe = |it: &ChannelInfo| {
        let [topic, schema, encoding] = [&it.topic, &it.schema, &it.encoding].map(|it| it.escape_debug());
        format!("{topic} ({schema} as {encoding})")
    };
    index.channels.values().map(describe).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(topics: &[(&str, &str, &str)]) -> RecordingIndex {
        let channels = (0_u16..).zip(topics).map(|(id, &(topic, schema, encoding))| {
            let [topic, schema, encoding] = [topic, schema, encoding].map(str::to_owned);
            (id, ChannelInfo { topic, schema, encoding })
        });
        RecordingIndex { channels: channels.collect(), ..RecordingIndex::default() }
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
            Err("name one by --topic: /rear (foxglove.PointCloud, 0 messages), /top"),
        );
        check(&[TOP, REAR], [Some("/rear"), None], Ok(("/rear", None)));
        check(&[TOP, LABELS, TRACKS], [None, None], Ok(("/top", Some(ANNOTATION_TOPIC))));
        check(&[TOP, LABELS, TRACKS], [None, Some("/tracks")], Ok(("/top", Some("/tracks"))));
        let other = ("/other", SCENE_UPDATE, "json");
        check(&[TOP, other, TRACKS], [None, None], Err("--annotation-topic: /other"));
    }

    #[test]
    fn what_is_not_there_is_refused_with_what_is() {
        check(&[TOP], [Some("/topp"), None], Err("no clouds on the topic \"/topp\": /top ("));
        check(&[TOP, LABELS], [None, Some("/x")], Err("no annotations on the topic \"/x\": /annotations ("));
        check(
            &[("/imu", "sensor_msgs/msg/Imu", "cdr")],
            [None, None],
            Err("has no clouds: /imu (sensor_msgs"),
        );
        check(
            &[("/top", POINT_CLOUD_2, "ros1")],
            [None, None],
            Err("/top (sensor_msgs/msg/PointCloud2 as ros1)"),
        );
    }
}
