//! How work is done in one piece or in shards: what there is to do, what is done so far, and what comes of it.

pub mod share_of_work;
pub mod work_output;
pub mod unfinished_work;
pub mod checksummed_file;
pub mod shard_directory;
pub mod whole_manifest;
pub mod executor;
pub mod shard_entry;
pub mod shard_journal;
pub mod detection_look;
pub mod shard_files;
pub mod rows_of_shards;
pub mod whole_run;
pub mod watched_study;
