//! Which part of a run is made.

use clap::Args;
use reports::vocabulary::shard::Shard;

use super::help_text::DATA;

/// Which part of a run is made.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct ShardArgs {
    /// Make only part I of N, counted from 1, some of the scans or objects; `merge` puts all parts together
    ///
    /// -o names the folder of the shards, the same for all of them: each gets a directory in it, such as `shard-3-of-8`.
    /// Scans that intervals are drawn from together stay together. To continue an interrupted shard, give the same command
    /// again.
    #[arg(long, value_name = "I/N", requires = "output", hide_short_help = true)]
    pub shard: Option<Shard>,
}
