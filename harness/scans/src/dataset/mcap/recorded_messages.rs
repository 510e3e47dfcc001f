//! The messages of a recording about objects and frames, read one at a time.

use super::frame_tree::{FrameTree, transforms_of_message};
use super::mcap_file::{McapFile, MessageBytes};
use super::mcap_index::{McapIndex, MessagePosition, window};
use super::ros_messages::StampedTransform;
use super::scene_objects::{SceneObject, objects_of_message};
use super::topics::{ChosenChannel, MessageKind};
use crate::dataset::DatasetError;

/// Transforms this far before and after a scan are looked at, in nanoseconds.
const TRANSFORM_WINDOW_NS: u64 = 1_000_000_000;

/// This many transforms of each topic are read at the start: those that never change are often sent only once.
const N_FIRST_TRANSFORMS: usize = 200;

/// Messages of objects and transforms that are larger than this are not read: small on disk, they may be large in memory.
const MAX_SMALL_MESSAGE_BYTES: usize = 4 << 20;

/// A channel with the positions of its messages, by time.
#[derive(Debug)]
pub struct Channel {
    /// What its messages are.
    pub kind: MessageKind,
    /// How they are encoded.
    pub encoding: String,
    /// Where they are.
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

/// A file, and what it says about frames.
#[derive(Debug)]
pub struct RecordedMessages {
    file: McapFile,
    transforms: Vec<Channel>,
    first_transforms: Vec<StampedTransform>,
}

impl RecordedMessages {
    /// Those of `file`, which says on `transforms` how frames lie to each other.
    pub fn new(file: McapFile, transforms: Vec<Channel>) -> Result<Self, DatasetError> {
        let mut messages = Self { file, transforms, first_transforms: Vec::new() };
        let mut first_transforms = Vec::new();
        for channel in &messages.transforms {
            for position in channel.positions.iter().take(N_FIRST_TRANSFORMS) {
                first_transforms.extend(messages.read_transforms(channel, *position)?);
            }
        }
        messages.first_transforms = first_transforms;
        Ok(messages)
    }

    /// Whether anything is said about frames.
    pub fn has_transforms(&self) -> bool {
        !self.transforms.is_empty()
    }

    /// The message at `position`, as it is encoded.
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

    /// The objects in the message at `position` of `channel`, and the moment it is about, if it says so.
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

    /// How the frames lie to each other at `stamp_ns`, of what was logged around `log_time_ns`.
    pub fn frames_at(&self, stamp_ns: u64, log_time_ns: u64) -> Result<FrameTree, DatasetError> {
        let mut transforms = self.first_transforms.clone();
        for channel in &self.transforms {
            let begin_ns = log_time_ns.saturating_sub(TRANSFORM_WINDOW_NS);
            for position in
                window(&channel.positions, begin_ns, log_time_ns.saturating_add(TRANSFORM_WINDOW_NS))
            {
                transforms.extend(self.read_transforms(channel, *position)?);
            }
        }
        Ok(FrameTree::at(stamp_ns, transforms))
    }

    fn read_transforms(
        &self,
        channel: &Channel,
        position: MessagePosition,
    ) -> Result<Vec<StampedTransform>, DatasetError> {
        let message = self.file.message(position)?;
        let bytes = message.as_slice();
        let read =
            check_size(bytes).and_then(|()| transforms_of_message(channel.kind, &channel.encoding, bytes));
        read.map_err(|problem| self.damaged_at(position, &problem))
    }
}

fn check_size(message: &[u8]) -> Result<(), String> {
    let n_bytes = message.len();
    if n_bytes > MAX_SMALL_MESSAGE_BYTES {
        return Err(format!("has a message of {n_bytes} bytes, too large for its objects"));
    }
    Ok(())
}
