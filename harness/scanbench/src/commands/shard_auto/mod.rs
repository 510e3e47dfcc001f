//! `--shard auto`: from the environment variables of an engine to a shard.

pub mod engines;
pub mod engine_shard_error;
pub mod engine_shard;
