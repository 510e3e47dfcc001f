//! Which part of a run the command line, or whoever started the program, asks for.

use reports::vocabulary::shard::Shard;

use crate::cli::{ShardArgs, ShardOption};
use crate::commands::failure::Failure;

/// The part that `arguments` ask for; `None` for the whole run.
///
/// # Errors
///
/// If it is to be found out which part it is, and that cannot be.
pub fn chosen_shard(arguments: &ShardArgs) -> Result<Option<Shard>, Failure> {
    match arguments.shard {
        None => Ok(None),
        Some(ShardOption::Part(shard)) => Ok(Some(shard)),
    }
}
