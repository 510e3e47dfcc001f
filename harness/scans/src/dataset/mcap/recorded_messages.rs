//! The messages of a recording about objects and frames, read one at a time.

use super::foxglove_messages::{CloudTime, decode};
use super::frame_tree::{FrameTree, transforms_of_message};
use super::mcap_file::{McapFile, MessageBytes};
use super::mcap_index::{McapIndex, MessagePosition, window};
use super::ros_messages::{self, StampedTransform};
use super::scene_objects::{SceneObject, objects_of_message};
use super::topics::{ChosenChannel, MessageKind};
use crate::dataset::DatasetError;
use crate::dataset::time_pairs::{Moment, usual_delay_ns};

/// Transforms that are stamped within this time before and after a scan are used, in nanoseconds.
const TRANSFORM_WINDOW_NS: u64 = 1_000_000_000;

/// This many transforms of each topic are read at the start: constant ones are often sent only once.
const N_FIRST_TRANSFORMS: usize = 200;

/// Larger messages of objects and transforms are not read: small on disk, they may be large in memory.
const MAX_SMALL_MESSAGE_BYTES: usize = 4 << 20;

/// A channel with the positions of its messages, by time.
#[derive(Debug)]
pub struct Channel {
    /// The kind of its messages.
    pub kind: MessageKind,
    /// The encoding of its messages.
    pub encoding: String,
    /// The positions of its messages.
    pub positions: Vec<MessagePosition>,
}

impl Channel {
    /// Takes the positions of the messages of `chosen` out of `index`.
    pub fn take(index: &mut McapIndex, chosen: ChosenChannel) -> Self {
        let positions = chosen.ids.iter().filter_map(|id| index.messages.remove(id));
        let mut positions: Vec<MessagePosition> = positions.flatten().collect();
        positions.sort_by_key(|position| position.log_time_ns);
        Self { kind: chosen.kind, encoding: chosen.info.encoding, positions }
    }
}

/// A recording with its transforms between frames.
#[derive(Debug)]
pub struct RecordedMessages {
    file: McapFile,
    transforms: Vec<TransformChannel>,
    first_transforms: Vec<LoggedTransform>,
}

/// A channel of transforms, and how much later than their stamps the first ones are logged, in nanoseconds.
#[derive(Debug)]
struct TransformChannel {
    channel: Channel,
    delay_ns: Option<i64>,
}

/// A transform with its log time.
#[derive(Debug, Clone)]
struct LoggedTransform {
    log_time_ns: u64,
    transform: StampedTransform,
}

impl RecordedMessages {
    /// The messages of `file`, with `transforms` between frames.
    pub fn new(file: McapFile, transforms: Vec<Channel>) -> Result<Self, DatasetError> {
        let mut messages = Self { file, transforms: Vec::new(), first_transforms: Vec::new() };
        for channel in transforms {
            let mut first_transforms = Vec::new();
            for position in channel.positions.iter().take(N_FIRST_TRANSFORMS) {
                first_transforms.extend(messages.read_transforms(&channel, *position)?);
            }
            let delay_ns = usual_delay_ns(first_transforms.iter().map(LoggedTransform::moment));
            messages.transforms.push(TransformChannel { channel, delay_ns });
            messages.first_transforms.extend(first_transforms);
        }
        Ok(messages)
    }

    /// Whether there are transforms between frames.
    pub fn has_transforms(&self) -> bool {
        !self.transforms.is_empty()
    }

    /// The message at `position`, in its encoding.
    pub fn message(&self, position: MessagePosition) -> Result<MessageBytes, DatasetError> {
        self.file.message(position)
    }

    /// An error about the file.
    pub fn damaged(&self, problem: String) -> DatasetError {
        self.file.damaged(problem)
    }

    /// An error about the message at `position`.
    pub fn damaged_at(&self, position: MessagePosition, problem: &str) -> DatasetError {
        self.damaged(format!("{problem}, logged at {} ns", position.log_time_ns))
    }

    /// The objects in the message at `position` of `channel`, and its time stamp in nanoseconds, if it has one.
    pub fn read_objects(
        &self,
        channel: &Channel,
        position: MessagePosition,
    ) -> Result<(Option<u64>, Vec<SceneObject>), DatasetError> {
        let message = self.file.message(position)?;
        let bytes = message.as_slice();
        let read =
            check_size(bytes).and_then(|()| objects_of_message(channel.kind, &channel.encoding, bytes));
        let (stamp_ns, objects) = read.map_err(|problem| self.damaged_at(position, &problem))?;
        Ok(((stamp_ns > 0).then_some(stamp_ns), objects))
    }

    /// Times of the messages of `channels`, which are clouds or objects, in the order of their positions. A message that
    /// cannot be read has no stamp.
    pub fn moments<const N: usize>(&self, channels: [&Channel; N]) -> [Vec<Moment>; N] {
        let moment = |it: &MessagePosition| Moment { stamp_ns: None, log_time_ns: it.log_time_ns };
        let mut moments = channels.map(|it| it.positions.iter().map(moment).collect::<Vec<Moment>>());
        let positions = |(channel_idx, channel): (usize, &&Channel)| {
            let of_channel = channel.positions.iter().copied().enumerate();
            of_channel.map(move |(idx, position)| (position, channel_idx, idx)).collect::<Vec<_>>()
        };
        let mut in_file: Vec<_> = channels.iter().enumerate().flat_map(positions).collect();
        // In the order of the file, so that each chunk is opened once.
        in_file.sort_by_key(|(position, ..)| (position.chunk_idx, position.offset));
        for (position, channel_idx, idx) in in_file {
            moments[channel_idx][idx].stamp_ns = self.stamp_of(channels[channel_idx], position);
        }
        moments
    }

    fn stamp_of(&self, channel: &Channel, position: MessagePosition) -> Option<u64> {
        let message = self.file.message(position).ok()?;
        let bytes = message.as_slice();
        let stamp_ns = match channel.kind {
            MessageKind::RosCloud => ros_messages::stamp_ns(bytes).ok()?,
            MessageKind::FoxgloveCloud => {
                let cloud: CloudTime = decode(&channel.encoding, bytes).ok()?;
                cloud.timestamp.unwrap_or_default().nanoseconds()
            }
            _ => {
                check_size(bytes).ok()?;
                objects_of_message(channel.kind, &channel.encoding, bytes).ok()?.0
            }
        };
        (stamp_ns > 0).then_some(stamp_ns)
    }

    /// The tree of frames at `moment` of another message: by the stamps of transforms or, if the message has no stamp, by
    /// their log times.
    pub fn frames_at(&self, moment: Moment) -> Result<FrameTree, DatasetError> {
        let Moment { stamp_ns, log_time_ns } = moment;
        let mut transforms = self.first_transforms.clone();
        for TransformChannel { channel, delay_ns } in &self.transforms {
            // The log time of transforms with this stamp.
            let around_ns = match (stamp_ns, delay_ns) {
                (Some(stamp_ns), Some(delay_ns)) => stamp_ns.saturating_add_signed(*delay_ns),
                _ => log_time_ns,
            };
            let (begin_ns, end_ns) = (
                around_ns.saturating_sub(TRANSFORM_WINDOW_NS),
                around_ns.saturating_add(TRANSFORM_WINDOW_NS),
            );
            for position in window(&channel.positions, begin_ns, end_ns) {
                transforms.extend(self.read_transforms(channel, *position)?);
            }
        }
        let on_clock = |LoggedTransform { log_time_ns: logged_ns, mut transform }: LoggedTransform| {
            match stamp_ns {
                None => transform.stamp_ns = logged_ns,
                // Its log time is as much later.
                Some(stamp_ns) if transform.stamp_ns == 0 => {
                    let later_ns = logged_ns.wrapping_sub(log_time_ns).cast_signed();
                    transform.stamp_ns = stamp_ns.saturating_add_signed(later_ns);
                }
                Some(_) => {}
            }
            transform
        };
        Ok(FrameTree::at(stamp_ns.unwrap_or(log_time_ns), transforms.into_iter().map(on_clock)))
    }

    fn read_transforms(
        &self,
        channel: &Channel,
        position: MessagePosition,
    ) -> Result<Vec<LoggedTransform>, DatasetError> {
        let message = self.file.message(position)?;
        let bytes = message.as_slice();
        let read =
            check_size(bytes).and_then(|()| transforms_of_message(channel.kind, &channel.encoding, bytes));
        let log_time_ns = position.log_time_ns;
        let transforms = read.map_err(|problem| self.damaged_at(position, &problem))?;
        Ok(transforms.into_iter().map(|transform| LoggedTransform { log_time_ns, transform }).collect())
    }
}

impl LoggedTransform {
    fn moment(&self) -> Moment {
        let Self { log_time_ns, transform: StampedTransform { stamp_ns, .. } } = self;
        Moment { stamp_ns: (*stamp_ns > 0).then_some(*stamp_ns), log_time_ns: *log_time_ns }
    }
}

fn check_size(message: &[u8]) -> Result<(), String> {
    let n_bytes = message.len();
    if n_bytes > MAX_SMALL_MESSAGE_BYTES {
        return Err(format!("has a message of {n_bytes} bytes, too large for its objects"));
    }
    Ok(())
}
