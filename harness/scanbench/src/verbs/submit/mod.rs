//! `scanbench submit`: files by which an engine runs shards and merges them.

pub mod template;
pub mod sharded_command;
pub mod job_folder;
pub mod slurm;
pub mod kubernetes;
