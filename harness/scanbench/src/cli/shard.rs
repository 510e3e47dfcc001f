//! Which part of a run is made.

use std::num::NonZeroU32;
use std::str::FromStr;

use clap::Args;
use reports::vocabulary::shard::{Shard, ShardError};

use super::help_text::DATA;

/// Which part of a run is made.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct ShardArgs {
    /// Make only part I of N, counted from 1, some of the scans or objects; `merge` puts all parts together
    ///
    /// -o names the folder of the shards, the same for all of them: each gets a directory in it, such as `shard-3-of-8`. Scans that
    /// intervals are drawn from together stay together. To continue an interrupted shard, give the same command again.
    ///
    /// `auto` takes what an engine says: an array of Slurm, PBS or LSF, an indexed job of Kubernetes, AWS Batch, parallel jobs of
    /// GitLab, Buildkite and CircleCI, shards of Bazel. It fails where none says it.
    #[arg(long, value_name = "I/N|auto", requires = "output", hide_short_help = true)]
    pub shard: Option<ShardOption>,
    /// With `--shard auto`: the number of shards; tasks of arrays are numbered from 1 to N then
    ///
    /// Kubernetes and PBS do not say how many tasks there are. With it, a part of an array can be run again.
    #[arg(long, value_name = "N", requires = "shard", hide_short_help = true)]
    pub shards: Option<NonZeroU32>,
}

/// A part, as the command line names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShardOption {
    /// This one.
    Part(Shard),
    /// The one that the engine says.
    Auto,
}

impl FromStr for ShardOption {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        if text == "auto" { Ok(Self::Auto) } else { text.parse().map(Self::Part) }
    }
}
