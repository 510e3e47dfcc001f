//! `scanbench partial --shard`: some of the objects, by all methods.

use std::collections::BTreeSet;
use std::ops::Range;

use evaluation::partial::experiment::run_by_object;
use reports::files::csv_rows::{csv_head, each_row_of, to_csv_lines};
use reports::numbers::blocks::DriveSecond;
use reports::numbers::shard_cut::{ScanToCut, scans_of_shard};
use reports::rows::partial_row::PartialRow;
use reports::run_folder::partial_manifest::PartialManifest;
use reports::run_folder::run_directory::PARTIAL_CSV;
use reports::run_folder::shard_record::{ShardPart, WorkMeasure};
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;
use scans::dataset::checksum::sha256;
use serde::{Deserialize, Serialize};

use crate::cli::PartialArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::interruption::interruption_flag;
use crate::commands::partial::experiment::{peer_rows, with_experiment};
use crate::commands::partial::files::manifest;
use crate::commands::partial::sets::{Compared, Known, open_all};
use crate::commands::progress::progress_over_results;
use crate::commands::shards::checksummed_file::write_checksummed;
use crate::commands::shards::place::Place;
use crate::commands::shards::share_of_work::ShareOfWork;
use crate::commands::shards::unfinished_work::{UnfinishedWork, identity_of};

/// What one method said of an object: an entry of the journal. Their order is that of rows.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectEntry {
    set_idx: usize,
    method_idx: usize,
    object_idx: usize,
    // Lines of `partial.csv`.
    lines: String,
}

/// Somebody asked for an end.
#[derive(Debug, thiserror::Error)]
#[error("interrupted after object {object_idx} of {set:?}")]
struct Interrupted {
    object_idx: usize,
    set: String,
}

/// Has methods tell what the objects of `shard` are, and leaves the rows in a directory of its own for `merge`.
pub fn partial_shard(arguments: &PartialArgs, shard: Shard) -> Result<(), Failure> {
    let place = Place::claim(Study::Partial, Some(shard), &arguments.output)?;
    let sets = open_all(arguments)?;
    refuse_same_names(&sets)?;
    let ranges = objects_of_shard(&sets, shard);
    let share = ShareOfWork { cut_by: WorkMeasure::Objects, parts: parts(&sets, &ranges) };
    let whole = manifest(arguments, &sets, place.started)?;
    let manifest = PartialManifest { shard: Some(place.record(share)), ..whole };
    let identity = identity_of(&manifest, serde_json::json!({ "model": checksum_of_model(&sets) }));
    let mut done: Vec<ObjectEntry> = Vec::new();
    let n_objects: usize = ranges.iter().map(Range::len).sum();
    let known = (&identity, format!("{n_objects} objects"));
    let unfinished = UnfinishedWork::open(place, "objects", known, |it| done.push(it))?;
    if !done.is_empty() {
        unfinished.tell_of_continuing(done.len(), "all objects of all methods");
    }
    let judged = judge(arguments, (&sets, &ranges), &unfinished, &mut done);
    if let Err(failure) = judged {
        return Err(unfinished.ended_by(failure));
    }
    done.sort();
    let head = String::from_utf8_lossy(&csv_head::<PartialRow>()).into_owned();
    let mut text: String = std::iter::once(head).chain(done.into_iter().map(|it| it.lines)).collect();
    let mut rows: Vec<PartialRow> = Vec::new();
    let path = unfinished.folder.join(PARTIAL_CSV);
    each_row_of(text.as_bytes(), &path, |row| rows.push(row))?;
    text.push_str(&lines_of(&peer_rows(arguments, &rows)?)?);
    let mut manifest = manifest;
    unfinished.finish(|_, _, directory| {
        if let Some(record) = &mut manifest.shard {
            record.files = vec![write_checksummed(directory.folder(), PARTIAL_CSV, text.as_bytes())?];
        }
        Ok(manifest.to_json())
    })
}

/// That of the model that tells the objects of all `sets`; `None` if they are told by what is learned anew. Of what was read, not of a
/// file that may have changed since.
fn checksum_of_model(sets: &[Compared]) -> Option<String> {
    sets.iter().find_map(|it| match &it.known {
        Known::Model(model) => Some(sha256(model.to_bytes())),
        Known::Objects { .. } => None,
    })
}

/// Rows of sets are told apart by their names when they are put together.
fn refuse_same_names(sets: &[Compared]) -> Result<(), Usage> {
    let mut names = BTreeSet::new();
    match sets.iter().map(|it| &it.judged.description().id).find(|it| !names.insert(*it)) {
        Some(twice) => {
            Err(Usage(format!("two sets of objects are called {twice:?}, which shards cannot have")))
        }
        None => Ok(()),
    }
}

/// Of each set, a range of places among all its objects. Each object is drawn by itself where intervals are estimated.
fn objects_of_shard(sets: &[Compared], shard: Shard) -> Vec<Range<usize>> {
    let object = |idx: usize| ScanToCut { second: DriveSecond::of(&idx.to_string(), 0.0), work: 1 };
    let objects = |it: &Compared| (0..it.judged.classes().len()).map(object).collect();
    scans_of_shard(&sets.iter().map(objects).collect::<Vec<_>>(), shard)
}

fn parts(sets: &[Compared], ranges: &[Range<usize>]) -> Vec<ShardPart> {
    let part = |(set, range): (&Compared, &Range<usize>)| {
        let classes: Vec<&str> = set.judged.classes().iter().map(|it| it.name()).collect();
        let selected = sha256(classes.join("\n").as_str());
        ShardPart { first: range.start as u64, end: range.end as u64, selected, n_labels: 0 }
    };
    sets.iter().zip(ranges).map(part).collect()
}

/// Adds what is missing in `done`, and keeps it.
fn judge(
    arguments: &PartialArgs,
    (sets, ranges): (&[Compared], &[Range<usize>]),
    unfinished: &UnfinishedWork,
    done: &mut Vec<ObjectEntry>,
) -> Result<(), Failure> {
    for (set_idx, (set, range)) in sets.iter().zip(ranges).enumerate() {
        let of_set = done.iter().filter(|it| it.set_idx == set_idx);
        let there: BTreeSet<(usize, usize)> = of_set.map(|it| (it.method_idx, it.object_idx)).collect();
        let mut object_indices = set.judged_indices();
        object_indices.retain(|it| range.contains(it));
        let name = &set.judged.description().id;
        with_experiment(set, &object_indices, arguments, |experiment| {
            let progress = progress_over_results(experiment.n_answered_objects(), there.len(), name);
            let is_done = |method_idx, object_idx| there.contains(&(method_idx, object_idx));
            let ended = run_by_object(experiment, is_done, |it| {
                let lines = lines_of(&it.rows)?;
                let (method_idx, object_idx) = (it.method_idx, it.object_idx);
                let entry = ObjectEntry { set_idx, method_idx, object_idx, lines };
                unfinished.journal.add(&entry)?;
                done.push(entry);
                progress.inc(1);
                if interruption_flag().load(std::sync::atomic::Ordering::Relaxed) {
                    return Err(Failure::Interrupted(Interrupted { object_idx, set: name.clone() }.into()));
                }
                Ok(())
            });
            progress.finish_and_clear();
            ended
        })?;
    }
    Ok(())
}

fn lines_of(rows: &[PartialRow]) -> Result<String, Failure> {
    Ok(String::from_utf8_lossy(&to_csv_lines(rows)?).into_owned())
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use detector::partial::partial_model::PartialModel;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        arguments: PartialArgs,
    }

    /// What a shard says of `model`, whose file is gone once it was read.
    fn checksum_of(model: &PartialModel) -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("partial.model");
        std::fs::write(&path, model.to_bytes()).unwrap();
        let objects = ["partial", "objects-vlp-16", "--per-class", "1", "--model"];
        let line = Line::parse_from(objects.into_iter().chain(path.to_str()));
        let sets = open_all(&line.arguments).unwrap();
        drop(folder);
        checksum_of_model(&sets)
    }

    #[test]
    fn a_shard_knows_its_model_though_the_file_is_gone() {
        let shipped = PartialModel::clone(&PartialModel::shipped());
        assert!(checksum_of(&shipped).is_some());
        let mut other = shipped.clone();
        other.made.command = "another".to_owned();
        assert_ne!(checksum_of(&shipped), checksum_of(&other));
    }
}
