//! Does work that can be cut into shards: all in one piece, or a shard.
//!
//! Finished work is kept at once as events in a journal. A shard leaves these for `merge`, which makes the result of them.
//! Interrupted work continues when the same command is run again.

use std::path::PathBuf;

use evaluation::journal::Journal;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::run_folder::shard_record::ShardRecord;
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::shard_log::{ShardLog, leave_log};
use super::share_of_work::ShareOfWork;
use super::unfinished_work::{KeptFiles, UnfinishedWork, identity_of};
use super::work_output::WorkOutput;
use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::{Verbosity, is_said, print_diagnostic, print_result};

/// Result of all shards, with its files.
pub trait WholeResult: Sized {
    /// Makes the result of `shards`, whose manifests are `manifests`, both in order, in `directory`.
    fn of_shards(
        study: Study,
        shards: &[ShardLog<'_>],
        manifests: &[&Manifest],
        directory: &RunDirectory,
    ) -> Result<Self, Failure>;
}

/// Work that can be cut into shards. It is done part by part, with an event in the journal for each.
pub trait SharedWork {
    /// A line of the journal.
    type Event: DeserializeOwned;
    type Whole: WholeResult;

    /// Cuts the work to the part of `shard`.
    fn claim_share(&mut self, shard: Shard) -> ShareOfWork;

    /// The manifest of the work; with `shard`, of that shard.
    fn manifest(&self, shard: Option<ShardRecord>) -> Manifest;

    /// Facts that decide the result and that the manifest lacks.
    fn rules(&self) -> Value {
        Value::Null
    }

    /// Ids that a directory is named after if the user gives it no name.
    fn ids(&self) -> String;

    /// Extent of the work, such as `60 scans`.
    fn extent(&self) -> String;

    /// Whether all has to be seen at once, so that nothing is kept to continue from.
    fn sees_all(&self) -> bool {
        false
    }

    /// Adds `event`, which was done before; `false` if it cannot be of this work, or cannot come next.
    fn add_done(&mut self, event: Self::Event) -> bool;

    /// How much was done before, such as `7 of 60 scans`; `None` if nothing was.
    fn done(&self) -> Option<String>;

    /// Does the rest of the shard of `record`, or of work in one piece.
    fn resume(&mut self, unfinished: &UnfinishedWork, record: &ShardRecord) -> Result<(), Failure>;

    /// Ends work in one piece that failed with `failure`, which it returns: keeps what can be continued, or removes it.
    fn ended_by(&mut self, failure: Failure, unfinished: UnfinishedWork) -> Failure {
        if unfinished.is_begun() { unfinished.ended_by(failure) } else { unfinished.discarded_by(failure) }
    }

    /// The manifest once all is done and in `journal`; its shard becomes `record`.
    fn finished_manifest(&mut self, journal: &Journal, record: ShardRecord) -> Result<Manifest, Failure>;

    /// Makes the result of work in one piece, whose manifest is `manifest`, in `directory`.
    fn whole(
        &mut self,
        study: Study,
        kept: &KeptFiles,
        manifest: &Manifest,
        directory: &RunDirectory,
    ) -> Result<Self::Whole, Failure> {
        let record = manifest.shard.as_ref().expect("its shard was just written into it");
        let log = ShardLog::of_journal(&kept.folder, record, &kept.journal);
        Self::Whole::of_shards(study, &[log], &[manifest], directory)
    }

    /// Gives `directory` the other files that belong to the result, such as those beside the journal.
    fn move_beside_files(
        &self,
        _: &KeptFiles,
        _manifest: &Manifest,
        _directory: &RunDirectory,
    ) -> Result<(), Failure> {
        Ok(())
    }
}

/// A result in one piece, to which a verb may add files of its own.
pub struct Finished<Whole> {
    // Invariant: before the directory, which removes the folders that were made for both.
    kept: KeptFiles,
    pub directory: RunDirectory,
    pub whole: Whole,
}

impl<Whole> Finished<Whole> {
    /// Gives the directory its name, and returns its path with the result.
    pub fn finish(self) -> Result<(PathBuf, Whole), Failure> {
        let finished = self.directory.finish()?;
        self.kept.clear();
        Ok((finished, self.whole))
    }
}

/// Does `work` in `output`: a shard is left there for `merge`, and a result in one piece is returned.
pub fn execute<W: SharedWork>(
    work: &mut W,
    mut output: WorkOutput,
) -> Result<Option<Finished<W::Whole>>, Failure> {
    output.is_kept &= !work.sees_all();
    let (part, study, is_kept) = (output.shard, output.study, output.is_kept);
    let share = work.claim_share(part.unwrap_or(Shard::ONLY));
    let record = output.record(share);
    let identity = identity_of(&work.manifest(Some(record.clone())), work.rules());
    let (ids, extent) = (work.ids(), work.extent());
    let unfinished = UnfinishedWork::open(output, &ids, &identity, extent, |it| work.add_done(it))?;
    if let Some(done) = work.done() {
        unfinished.report_continuing(&done);
    }
    if let Err(failure) = work.resume(&unfinished, &record) {
        return Err(match part {
            Some(_) => unfinished.ended_by(failure),
            None => work.ended_by(failure, unfinished),
        });
    }
    if part.is_some() {
        leave_shard(work, unfinished, record)?;
        return Ok(None);
    }
    let (claimed, kept) = unfinished.into_parts();
    let directory = RunDirectory::begin(claimed)?;
    match whole_in_one_piece(work, study, record, &kept, &directory) {
        Ok(whole) => Ok(Some(Finished { kept, directory, whole })),
        Err(failure) => {
            if !is_kept || matches!(failure, Failure::NothingEvaluated(_)) {
                kept.clear();
            }
            Err(failure)
        }
    }
}

/// Makes the directory of a shard, and removes what was kept until then.
fn leave_shard<W: SharedWork>(
    work: &mut W,
    unfinished: UnfinishedWork,
    record: ShardRecord,
) -> Result<(), Failure> {
    let words = unfinished.part_in_words();
    let (claimed, kept) = unfinished.into_parts();
    let directory = RunDirectory::begin(claimed)?;
    let record = ShardRecord { log: Some(leave_log(&kept.journal, &directory)?), ..record };
    let manifest = work.finished_manifest(&kept.journal, record)?;
    work.move_beside_files(&kept, &manifest, &directory)?;
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    let finished = directory.finish()?;
    kept.clear();
    if !is_said(Verbosity::Usual) {
        return print_result(finished.display());
    }
    print_diagnostic(format_args!("{words}, {}", finished.display()));
    Ok(())
}

/// The result of the work that `kept` holds, written into `directory`.
fn whole_in_one_piece<W: SharedWork>(
    work: &mut W,
    study: Study,
    record: ShardRecord,
    kept: &KeptFiles,
    directory: &RunDirectory,
) -> Result<W::Whole, Failure> {
    let manifest = work.finished_manifest(&kept.journal, record)?;
    work.move_beside_files(kept, &manifest, directory)?;
    work.whole(study, kept, &manifest, directory)
}
