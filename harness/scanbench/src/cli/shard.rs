//! Which part of a run is made.

use std::str::FromStr;

use clap::Args;
use reports::vocabulary::shard::{Shard, ShardError};

use super::help_text::DATA;

/// Which part of a run is made.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = DATA)]
pub struct ShardArgs {
    /// Run only part I of N of the scans, counted from 1; `merge` puts all parts together
    ///
    /// -o names the folder of the shards, the same for all of them: each gets a directory in it, such as `shard-3-of-8`. Scans that
    /// intervals are drawn from together stay together. To continue an interrupted shard, give the same command again.
    #[arg(long, value_name = "I/N", requires = "output", hide_short_help = true)]
    pub shard: Option<ShardOption>,
}

/// A part, as the command line names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShardOption {
    /// This one.
    Part(Shard),
}

impl FromStr for ShardOption {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        text.parse().map(Self::Part)
    }
}
