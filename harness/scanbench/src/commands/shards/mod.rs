//! Shards of runs and studies: which scans one has, what it has done so far, and what it leaves.

pub mod share_of_work;
pub mod finished_shard;
pub mod unfinished_shard;
pub mod checksummed_file;
pub mod shard_entry;
pub mod shard_journal;
pub mod shard_files;
pub mod watched_shard;
pub mod shard_directory;
pub mod rows_of_shards;
