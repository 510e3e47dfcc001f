//! Cuts the objects of `scanbench partial` into shards, and judges them one after the other.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use detector::partial::partial_model::PartialModel;
use evaluation::journal::Journal;
use evaluation::partial::experiment::run;
use reports::numbers::blocks::DriveSecond;
use reports::numbers::shard_cut::{ScanToCut, scans_of_shard};
use reports::run_folder::manifest::Manifest;
use reports::run_folder::partial_entry::PartialEntry;
use reports::run_folder::run_directory::{PARTIAL_RRD, RunDirectory};
use reports::run_folder::shard_record::{ShardPart, ShardRecord, WorkMeasure};
use reports::vocabulary::shard::Shard;
use scans::dataset::checksum::sha256;
use serde_json::{Value, json};

use crate::cli::PartialArgs;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::progress::progress_over_results;
use crate::plumbing::recorder::{record_growths, records_growths};
use crate::plumbing::shards::executor::SharedWork;
use crate::plumbing::shards::share_of_work::ShareOfWork;
use crate::plumbing::shards::unfinished_work::{KeptFiles, UnfinishedWork};
use crate::plumbing::shards::work_output::WorkOutput;
use crate::verbs::partial::experiment::{peer_rows, with_experiment};
use crate::verbs::partial::files::manifest;
use crate::verbs::partial::growths::first_growths;
use crate::verbs::partial::object_event::{Answer, ObjectEvent, answers_in};
use crate::verbs::partial::sets::{Compared, Known, open_all};
use crate::verbs::partial::whole_partial::WholePartial;

/// Sets of objects to be judged, and how far that is.
pub struct SharedObjects<'a> {
    arguments: &'a PartialArgs,
    sets: Vec<Compared>,
    manifest: Manifest,
    // Of each set, the objects that are to be judged, as a range of indices among all.
    ranges: Vec<Range<usize>>,
    // Pairs of a method and an object that are judged, of each set.
    done: Vec<BTreeSet<(usize, usize)>>,
    // By set, the model that our method has learned, if objects are recorded as they grow.
    models: Vec<Option<Arc<PartialModel>>>,
}

/// The user asked for an end.
#[derive(Debug, thiserror::Error)]
#[error("interrupted after object {object_idx} of {set:?}")]
pub struct Interrupted {
    /// The last object that was judged.
    pub object_idx: usize,
    pub set: String,
}

impl From<Interrupted> for Failure {
    fn from(error: Interrupted) -> Self {
        Self::Interrupted(error.into())
    }
}

impl<'a> SharedObjects<'a> {
    /// Opens the sets that `arguments` name, to be judged in `output`.
    pub fn open(arguments: &'a PartialArgs, output: &WorkOutput) -> Result<Self, Failure> {
        let sets = open_all(arguments)?;
        if output.shard.is_some() {
            refuse_same_names(&sets)?;
        }
        let manifest = manifest(arguments, &sets, output.started)?;
        let done = vec![BTreeSet::new(); sets.len()];
        Ok(Self { arguments, sets, manifest, ranges: Vec::new(), done, models: Vec::new() })
    }

    fn n_objects(&self) -> usize {
        self.ranges.iter().map(Range::len).sum()
    }

    /// Adds the missing answers of set `set_idx` to `journal`, and returns the model of our method if that is `wanted`.
    fn judge(
        &self,
        set_idx: usize,
        journal: &Journal,
        wanted: bool,
    ) -> Result<Option<Arc<PartialModel>>, Failure> {
        let (set, done) = (&self.sets[set_idx], &self.done[set_idx]);
        let mut object_indices = set.judged_indices();
        object_indices.retain(|it| self.ranges[set_idx].contains(it));
        let name = &set.judged.description().id;
        with_experiment(set, &object_indices, self.arguments, |experiment| {
            let progress = progress_over_results(experiment.n_answered_objects(), done.len(), name);
            let is_done = |method_idx, object_idx| done.contains(&(method_idx, object_idx));
            let ended = run(experiment, is_done, wanted, |it| {
                let (method_idx, object_idx) = (it.method_idx, it.object_idx);
                journal.add(&ObjectEvent::Answer(Answer {
                    set_idx,
                    method_idx,
                    object_idx,
                    rows: it.rows,
                }))?;
                progress.inc(1);
                if interruption_flag().load(Ordering::Relaxed) {
                    return Err(Interrupted { object_idx, set: name.clone() }.into());
                }
                Ok(())
            });
            progress.finish_and_clear();
            ended
        })
    }
}

impl SharedWork for SharedObjects<'_> {
    type Event = ObjectEvent;
    type Whole = WholePartial;

    fn claim_share(&mut self, shard: Shard) -> ShareOfWork {
        self.ranges = objects_of_shard(&self.sets, shard);
        ShareOfWork { cut_by: WorkMeasure::Objects, parts: parts(&self.sets, &self.ranges) }
    }

    fn manifest(&self, shard: Option<ShardRecord>) -> Manifest {
        Manifest { shard, ..self.manifest.clone() }
    }

    fn rules(&self) -> Value {
        json!({ "model": checksum_of_model(&self.sets) })
    }

    fn ids(&self) -> String {
        "objects".to_owned()
    }

    fn extent(&self) -> String {
        format!("{} objects", self.n_objects())
    }

    fn add_done(&mut self, event: ObjectEvent) -> bool {
        let ObjectEvent::Answer(answer) = event else { return true };
        let of_set = self.done.get_mut(answer.set_idx);
        of_set.is_some_and(|it| it.insert((answer.method_idx, answer.object_idx)))
    }

    fn done(&self) -> Option<String> {
        let n_done: usize = self.done.iter().map(BTreeSet::len).sum();
        (n_done > 0).then(|| format!("{n_done} of all objects of all methods"))
    }

    fn resume(&mut self, unfinished: &UnfinishedWork, _: &ShardRecord) -> Result<(), Failure> {
        let journal = &unfinished.journal;
        let wanted = unfinished.is_in_one_piece() && records_growths(self.arguments);
        for set_idx in 0..self.sets.len() {
            let model = self.judge(set_idx, journal, wanted)?;
            self.models.push(model.filter(|_| wanted));
        }
        let ours = answers_in(journal)?;
        if !ours.is_empty() || !unfinished.is_in_one_piece() {
            journal.add(&ObjectEvent::Peers { rows: peer_rows(self.arguments, &ours)? })?;
        }
        Ok(())
    }

    fn finished_manifest(&mut self, _: &Journal, record: ShardRecord) -> Result<Manifest, Failure> {
        Ok(SharedWork::manifest(self, Some(record)))
    }

    fn move_beside_files(
        &self,
        _: &KeptFiles,
        manifest: &Manifest,
        directory: &RunDirectory,
    ) -> Result<(), Failure> {
        let mut growths = Vec::new();
        for (set, model) in self.sets.iter().zip(&self.models) {
            if let Some(model) = model {
                growths.extend(first_growths(self.arguments, set, model)?);
            }
        }
        if growths.is_empty() {
            return Ok(());
        }
        let title = manifest.partial.as_ref().map(PartialEntry::title).unwrap_or_default();
        record_growths(&directory.path_of(PARTIAL_RRD), &title, &growths)
    }
}

/// Checksum of the model that classifies the objects of all `sets`; `None` if that is learned anew. It is of the model that
/// was read, not of a file that may have changed since.
fn checksum_of_model(sets: &[Compared]) -> Option<String> {
    sets.iter().find_map(|it| match &it.known {
        Known::Model(model) => Some(sha256(model.to_bytes())),
        Known::Objects { .. } => None,
    })
}

/// Refuses sets of the same name: names distinguish the rows of several sets when these are merged.
fn refuse_same_names(sets: &[Compared]) -> Result<(), Usage> {
    let mut names = BTreeSet::new();
    match sets.iter().map(|it| &it.judged.description().id).find(|it| !names.insert(*it)) {
        Some(twice) => {
            Err(Usage(format!("two sets of objects are called {twice:?}, which shards cannot have")))
        }
        None => Ok(()),
    }
}

/// Of each set, a range of indices among all its objects. Each object is drawn by itself where intervals are estimated.
fn objects_of_shard(sets: &[Compared], shard: Shard) -> Vec<Range<usize>> {
    let object = |idx: usize| ScanToCut { second: DriveSecond::of(&idx.to_string(), 0.0), work: 1 };
    let objects = |it: &Compared| (0..it.judged.classes().len()).map(object).collect();
    scans_of_shard(&sets.iter().map(objects).collect::<Vec<_>>(), shard)
}

fn parts(sets: &[Compared], ranges: &[Range<usize>]) -> Vec<ShardPart> {
    let part = |(set, range): (&Compared, &Range<usize>)| {
        let classes: Vec<&str> = set.judged.classes().iter().map(|it| it.name()).collect();
        let selected = sha256(classes.join("\n").as_str());
        ShardPart {
            first: range.start as u64,
            end: range.end as u64,
            selected,
            n_labels: 0,
            n_labeled_scans: 0,
        }
    };
    sets.iter().zip(ranges).map(part).collect()
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

    /// Checksum of `model`, whose file is gone once it was read.
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
    fn a_model_is_known_though_its_file_is_gone() {
        let shipped = PartialModel::clone(&PartialModel::shipped());
        assert!(checksum_of(&shipped).is_some());
        let mut other = shipped.clone();
        other.made.command = "another".to_owned();
        assert_ne!(checksum_of(&shipped), checksum_of(&other));
    }
}
