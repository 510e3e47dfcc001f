//! The folder of a run: how the run came about, how the folder is written, and all of it read back.

pub mod shard_record;
pub mod sweep_entry;
pub mod partial_entry;
pub mod seen_labels;
pub mod manifest;
pub mod command_line;
pub mod comparison_manifest;
pub mod run_target;
mod finished_folder;
pub mod run_directory;
pub mod run_archive;
pub mod detector_changes;
pub mod made_in_shards;
pub mod shard_check;
