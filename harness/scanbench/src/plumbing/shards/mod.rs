//! Work in one piece or in shards: its extent, its progress, and its result.

pub mod share_of_work;
pub mod work_output;
pub mod unfinished_work;
pub mod whole_manifest;
pub mod shard_log;
pub mod executor;
pub mod run_event;
pub mod run_summary;
pub mod run_rows;
pub mod run_log;
pub mod scan_events;
pub mod detection_look;
pub mod whole_run;
pub mod watched_study;
