//! A part of a run, or of a study that is one, which goes on where it was if it was interrupted.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use reports::files::archive::ArchiveError;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::shard_record::ShardRecording;
use reports::vocabulary::protocol::Protocol;
use serde_json::Value;

use super::shard_entry::{ShardEntry, ShardProgress};
use super::shard_files::write_shard_files;
use super::shard_journal::ShardJournal;
use super::share_of_work::take_share;
use super::unfinished_shard::{ShardPlan, UnfinishedShard, identity_of_shard};
use crate::commands::failure::Failure;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::progress::RunProgress;
use crate::commands::provenance::machine;
use crate::commands::recorder::Recorder;
use crate::commands::sinks::rerun_recording::RerunRecording;
use crate::commands::sinks::terminal::Terminal;
use crate::commands::watched_run::{WatchedRun, WithoutLabels};

/// What goes over data sets scan by scan and is made of the rows of a run.
pub trait ShardedRun {
    /// The data sets.
    fn datasets(&self) -> &[OpenedDataset];

    /// The same, to be cut.
    fn datasets_mut(&mut self) -> &mut [OpenedDataset];

    /// How it comes about.
    fn manifest(&self) -> Manifest;

    /// What decides rows beside all that the manifest says; nothing of studies.
    fn rules(&self) -> Value {
        Value::Null
    }

    /// How it goes over the data sets.
    fn watched<'a>(
        &'a self,
        without_labels: WithoutLabels,
        watching: (&'a AtomicBool, &'a RunProgress),
    ) -> WatchedRun<'a>;

    /// Begins the recording `file`, which is called `name`, of every so many scans; `None` if none is wanted, as of studies.
    fn begin_recording(&self, _name: &str, _file: PathBuf) -> Result<Option<(Recorder, u64)>, Failure> {
        Ok(None)
    }
}

/// Makes the shard of `plan` of `run`, and leaves its rows in a directory of its own for `merge`.
///
/// Every scan is kept as soon as it is judged, beside that directory; so a shard that was ended goes on when it is asked for again.
pub fn make_watched_shard(plan: ShardPlan, run: &mut impl ShardedRun) -> Result<(), Failure> {
    let share = take_share(run.datasets_mut(), plan.shard);
    let manifest = Manifest { shard: Some(plan.record(share)), ..run.manifest() };
    let n_scans: usize = run.datasets().iter().map(|it| it.part.len()).sum();
    let mut progress = ShardProgress::default();
    let identity = identity_of_shard(&manifest, run.rules());
    let unfinished =
        UnfinishedShard::open(plan, &identity, format!("{n_scans} scans"), |it| progress.add(&it))?;
    if progress.n_starts > 0 {
        unfinished.tell_of_continuing(progress.n_scans, &format!("{n_scans} scans"));
    }
    unfinished.journal.add(&ShardEntry::Began { cpu_model: machine().cpu_model })?;
    leave_out_what_is_done(run.datasets_mut(), &progress);
    let made =
        WatchedShard { unfinished: &unfinished, n_starts: progress.n_starts }.make(run, &manifest.protocols);
    made.map_err(|it| unfinished.ended_by(it))?;
    // Programs of others have introduced themselves by now.
    let manifest = Manifest { shard: manifest.shard, ..run.manifest() };
    unfinished.finish(|folder, journal, directory| {
        let mut manifest = manifest;
        if let Some(mut record) = manifest.shard.take() {
            write_shard_files(journal, directory, (&mut manifest, &mut record))?;
            for recording in &record.recordings {
                keep(&folder.join(&recording.file), &directory.path_of(&recording.file))?;
            }
            manifest.shard = Some(record);
        }
        Ok(manifest.to_json())
    })
}

/// Begins each data set behind the last scan that was judged.
fn leave_out_what_is_done(datasets: &mut [OpenedDataset], progress: &ShardProgress) {
    for (dataset_idx, place) in &progress.next_places {
        let part = &mut datasets[*dataset_idx].part;
        part.start = (*place).clamp(part.start, part.end);
    }
}

/// A shard of a run that is being made.
struct WatchedShard<'a> {
    unfinished: &'a UnfinishedShard,
    n_starts: usize,
}

impl WatchedShard<'_> {
    /// Goes over the scans that are left.
    fn make(&self, run: &impl ShardedRun, protocols: &[Protocol]) -> Result<(), Failure> {
        let Some(first) = first_number(run.datasets()) else { return Ok(()) };
        let UnfinishedShard { folder, journal, .. } = self.unfinished;
        let progress = RunProgress::new();
        let file = match self.n_starts {
            0 => "run.rrd".to_owned(),
            n => format!("run-{}.rrd", n + 1),
        };
        let name = folder.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let recorder = run.begin_recording(&name, folder.join(&file))?;
        let every = recorder.as_ref().map(|(_, every)| *every);
        let (end, mut served) = (Cell::new(None), None);
        let watched = run.watched(WithoutLabels::AskLater, (interruption_flag(), &progress));
        let ended = watched.run(vec![
            Box::new(recorder.map(|(it, _)| RerunRecording::new(it, &progress, &mut served))),
            Box::new(ShardJournal::new(journal, (run.datasets(), protocols), &end)),
            Box::new(Terminal::new(&progress)),
        ]);
        let is_complete = matches!(ended, Ok(()) | Err(Failure::Interrupted(_) | Failure::Detector(_)));
        if let Some((end, every)) = end.get().zip(every).filter(|_| is_complete) {
            journal.add(&ShardEntry::Recorded(ShardRecording { file, first, end, every }))?;
        }
        ended
    }
}

/// The number of the first scan that is left, among all scans of the run; `None` if none is.
fn first_number(datasets: &[OpenedDataset]) -> Option<u64> {
    let mut n_before = 0;
    datasets.iter().find_map(|it| {
        let first = (!it.part.is_empty()).then_some(n_before + it.part.start as u64);
        n_before += it.scan_indices.len() as u64;
        first
    })
}

/// Gives a file a second name; where there are none, a second file.
fn keep(file: &Path, name: &Path) -> Result<(), ArchiveError> {
    let copied = std::fs::hard_link(file, name).or_else(|_| std::fs::copy(file, name).map(|_| ()));
    copied.map_err(|source| ArchiveError::Write { path: name.to_owned(), source })
}
