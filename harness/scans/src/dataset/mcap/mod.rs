//! MCAP files: clouds of ROS 2 or Foxglove, transforms between frames, and boxes around objects.

pub mod chunk;
pub mod record_body;
pub mod mcap_index;
pub mod mcap_file;
pub mod cdr;
pub mod ros_messages;
pub mod foxglove_messages;
pub mod foxglove_scene;
pub mod topics;
pub mod scene_objects;
pub mod frame_tree;
pub mod recorded_messages;
pub mod recorded_cloud;
pub mod mcap_dataset;
