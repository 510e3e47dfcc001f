//! `scanbench merge` of the shards of `partial`.

use std::path::Path;

use reports::files::csv_rows::each_row_of;
use reports::rows::partial_row::PartialRow;
use reports::run_folder::command_line::command_of_whole_run;
use reports::run_folder::partial_manifest::PartialManifest;
use reports::run_folder::run_directory::{PARTIAL_CSV, RunDirectory};
use reports::run_folder::run_target::ClaimedTarget;

use crate::commands::failure::{Failure, NothingEvaluated};
use crate::commands::partial::files::end_partial;
use crate::commands::shards::shard_directory::ShardDirectory;

/// Makes the result of `shards`, whose manifests are `manifests`, both in order.
pub fn merge_partial(
    shards: &[ShardDirectory<'_>],
    manifests: &[&PartialManifest],
    claimed: ClaimedTarget,
) -> Result<(), Failure> {
    let directory = RunDirectory::begin(claimed)?;
    let manifest = whole_manifest(manifests, directory.target());
    let mut rows: Vec<PartialRow> = Vec::new();
    for shard in shards {
        let mut file = shard.open(PARTIAL_CSV)?;
        let path = file.path.clone();
        let read = each_row_of(&mut file, &path, |row| rows.push(row));
        read.map_err(|error| Failure::damaged_run(&shard.folder, error))?;
        file.check(shard)?;
    }
    if rows.is_empty() {
        return Err(NothingEvaluated { reason: "no object is of a class that is judged".to_owned() }.into());
    }
    end_partial(directory, &manifest, &in_order_of_whole(rows))
}

/// Set by set, and of each what one method said of all objects after what another did. Shards have the sets and the methods in the
/// same order.
fn in_order_of_whole(rows: Vec<PartialRow>) -> Vec<PartialRow> {
    let mut groups: Vec<Vec<PartialRow>> = Vec::new();
    for row in rows {
        match groups.iter_mut().find(|it| it.first().is_some_and(|it| it.is_of_same_answers(&row))) {
            Some(group) => group.push(row),
            None => groups.push(vec![row]),
        }
    }
    groups.into_iter().flatten().collect()
}

fn whole_manifest(shards: &[&PartialManifest], target: &Path) -> PartialManifest {
    let whole = shards[0];
    PartialManifest {
        created: shards.iter().map(|it| it.created.clone()).min().unwrap_or_default(),
        argv: command_of_whole_run(&whole.argv, &target.display().to_string()),
        shard: None,
        shards: shards.iter().filter_map(|it| it.shard.clone()).collect(),
        ..whole.clone()
    }
}
