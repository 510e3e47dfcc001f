//! Does work that can be shared out: all in one piece, or a shard.
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
use super::unfinished_work::{Remains, UnfinishedWork, identity_of};
use super::work_output::WorkOutput;
use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::{Verbosity, is_said, print_diagnostic, print_result};

/// What all shards come to, with its files.
pub trait WholeResult: Sized {
    /// Makes that of `shards`, whose manifests are `manifests`, both in order, in `directory`.
    fn of_shards(
        study: Study,
        shards: &[ShardLog<'_>],
        manifests: &[&Manifest],
        directory: &RunDirectory,
    ) -> Result<Self, Failure>;
}

/// What is done part by part, with an event in the journal for each.
pub trait SharedWork {
    /// A line of the journal.
    type Event: DeserializeOwned;
    /// What comes of it.
    type Whole: WholeResult;

    /// Leaves the part of `shard` to be done.
    fn take_share(&mut self, shard: Shard) -> ShareOfWork;

    /// How it comes about; with `shard`, of a shard.
    fn manifest(&self, shard: Option<ShardRecord>) -> Manifest;

    /// What decides the result beside all that the manifest says.
    fn rules(&self) -> Value {
        Value::Null
    }

    /// What a directory without a name is called after.
    fn ids(&self) -> String;

    /// What there is to do, such as `60 scans`.
    fn extent(&self) -> String;

    /// Whether nothing is kept to go on with, because all has to be seen at once.
    fn sees_all(&self) -> bool {
        false
    }

    /// Takes in what was done before, unless it cannot be of this work, or cannot come next.
    fn add_done(&mut self, event: Self::Event) -> bool;

    /// How much was done before, such as `7 of 60 scans`; `None` if nothing was.
    fn done(&self) -> Option<String>;

    /// Does what is left of the shard that `record` is of, or of work in one piece.
    fn go_on(&mut self, unfinished: &UnfinishedWork, record: &ShardRecord) -> Result<(), Failure>;

    /// What is said of work in one piece that `failure` has ended, and what is left of it.
    fn ended_by(&mut self, failure: Failure, unfinished: UnfinishedWork) -> Failure {
        if unfinished.is_begun() { unfinished.ended_by(failure) } else { unfinished.discarded_by(failure) }
    }

    /// How it came about, now that all is done and in `journal`; its shard becomes `record`.
    fn finished_manifest(&mut self, journal: &Journal, record: ShardRecord) -> Result<Manifest, Failure>;

    /// Makes the result of work in one piece, whose manifest is `manifest`, in `directory`.
    fn whole(
        &mut self,
        study: Study,
        remains: &Remains,
        manifest: &Manifest,
        directory: &RunDirectory,
    ) -> Result<Self::Whole, Failure> {
        let record = manifest.shard.as_ref().expect("its shard was just written into it");
        let log = ShardLog::of_journal(&remains.folder, record, &remains.journal);
        Self::Whole::of_shards(study, &[log], &[manifest], directory)
    }

    /// Has `directory` take what else lies beside the journal and belongs to the result.
    fn carry_over(
        &self,
        _: &Remains,
        _manifest: &Manifest,
        _directory: &RunDirectory,
    ) -> Result<(), Failure> {
        Ok(())
    }
}

/// A result in one piece, to which a verb may add files of its own.
pub struct Made<Whole> {
    // Invariant: before the directory, which removes the folders that were made for both.
    remains: Remains,
    /// Its directory.
    pub directory: RunDirectory,
    /// What it came to.
    pub whole: Whole,
}

impl<Whole> Made<Whole> {
    /// Gives the directory its name, and returns where it is, with what it came to.
    pub fn finish(self) -> Result<(PathBuf, Whole), Failure> {
        let finished = self.directory.finish()?;
        self.remains.clear();
        Ok((finished, self.whole))
    }
}

/// Does `work` in `output`: a shard is left there for `merge`, and all in one piece is handed back.
pub fn execute<W: SharedWork>(
    work: &mut W,
    mut output: WorkOutput,
) -> Result<Option<Made<W::Whole>>, Failure> {
    output.is_kept &= !work.sees_all();
    let (part, study, is_kept) = (output.shard, output.study, output.is_kept);
    let share = work.take_share(part.unwrap_or(Shard::ONLY));
    let record = output.record(share);
    let identity = identity_of(&work.manifest(Some(record.clone())), work.rules());
    let (ids, extent) = (work.ids(), work.extent());
    let unfinished = UnfinishedWork::open(output, &ids, &identity, extent, |it| work.add_done(it))?;
    if let Some(done) = work.done() {
        unfinished.report_continuing(&done);
    }
    if let Err(failure) = work.go_on(&unfinished, &record) {
        return Err(match part {
            Some(_) => unfinished.ended_by(failure),
            None => work.ended_by(failure, unfinished),
        });
    }
    if part.is_some() {
        leave_shard(work, unfinished, record)?;
        return Ok(None);
    }
    let (claimed, remains) = unfinished.into_parts();
    let directory = RunDirectory::begin(claimed)?;
    match put_in_one_piece(work, study, record, &remains, &directory) {
        Ok(whole) => Ok(Some(Made { remains, directory, whole })),
        Err(failure) => {
            if !is_kept || matches!(failure, Failure::NothingEvaluated(_)) {
                remains.clear();
            }
            Err(failure)
        }
    }
}

/// Makes the directory of a shard. What was kept until then is not needed any more.
fn leave_shard<W: SharedWork>(
    work: &mut W,
    unfinished: UnfinishedWork,
    record: ShardRecord,
) -> Result<(), Failure> {
    let words = unfinished.part_in_words();
    let (claimed, remains) = unfinished.into_parts();
    let directory = RunDirectory::begin(claimed)?;
    let record = ShardRecord { log: Some(leave_log(&remains.journal, &directory)?), ..record };
    let manifest = work.finished_manifest(&remains.journal, record)?;
    work.carry_over(&remains, &manifest, &directory)?;
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    let finished = directory.finish()?;
    remains.clear();
    if !is_said(Verbosity::Usual) {
        return print_result(finished.display());
    }
    print_diagnostic(format_args!("{words}, {}", finished.display()));
    Ok(())
}

/// The result of what was kept in `remains`, written into `directory`.
fn put_in_one_piece<W: SharedWork>(
    work: &mut W,
    study: Study,
    record: ShardRecord,
    remains: &Remains,
    directory: &RunDirectory,
) -> Result<W::Whole, Failure> {
    let manifest = work.finished_manifest(&remains.journal, record)?;
    work.carry_over(remains, &manifest, directory)?;
    work.whole(study, remains, &manifest, directory)
}
