//! Shards of a run: which scans one has, what it has done so far, and what it leaves.

pub mod share_of_work;
pub mod shard_entry;
pub mod shard_journal;
pub mod shard_files;
pub mod rows_of_shards;
