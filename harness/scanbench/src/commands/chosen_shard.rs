//! Which part of a run the command line, or whoever started the program, asks for.

use reports::files::archive::ArchiveError;
use reports::vocabulary::shard::Shard;

use crate::cli::{ShardArgs, ShardOption};
use crate::commands::failure::{Failure, Usage};
use crate::commands::shard_auto::engine_shard::{engine_shard, variables_of_process};
use crate::commands::standard_streams::print_diagnostic;

/// The part that `arguments` ask for; `None` for the whole run.
///
/// # Errors
///
/// [`Usage`] if it is to be found out which part it is, and that cannot be; if the engine cannot be told that it was understood.
pub fn chosen_shard(arguments: &ShardArgs) -> Result<Option<Shard>, Failure> {
    match (arguments.shard, arguments.shards) {
        (None, _) => Ok(None),
        (Some(ShardOption::Part(shard)), None) => Ok(Some(shard)),
        (Some(ShardOption::Part(shard)), Some(n_shards)) => Err(Usage(format!(
            "--shard {shard} says how many shards there are; leave --shards {n_shards} away"
        ))
        .into()),
        (Some(ShardOption::Auto), n_shards) => {
            let found = engine_shard(&variables_of_process(), n_shards)?;
            if let Some(path) = found.status_file {
                std::fs::write(&path, "").map_err(|source| ArchiveError::Write { path, source })?;
            }
            print_diagnostic(format_args!("Shard {}, says {} ({})", found.shard, found.engine, found.said));
            Ok(Some(found.shard))
        }
    }
}
