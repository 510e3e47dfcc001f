//! Which part of a run is made.

use clap::Args;
use reports::vocabulary::shard::Shard;

use super::help_text::DATA;

/// Which part of a run is made.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct ShardArgs {
    /// Make only shard I of N, counted from 1: a part of the scans or objects; `merge` puts all shards together
    ///
    /// -o names the folder of all shards: each gets a directory in it, such as `shard-3-of-8`. Blocks that intervals are
    /// drawn from stay whole. To continue an interrupted shard, give the same command again.
    #[arg(long, value_name = "I/N", requires = "output", hide_short_help = true)]
    pub shard: Option<Shard>,
}
