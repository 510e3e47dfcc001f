//! Makes a run, or a study that is one: all in one piece, or a shard.
//!
//! Every scan is kept as soon as it is judged, and all numbers are made of what was kept. All in one piece is the only shard, put together
//! with no other. What was ended goes on when it is asked for again.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use evaluation::run::scan_recorder::Served;
use evaluation::run::sink::Sinks;
use reports::files::archive::ArchiveError;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::shard_record::{ShardRecord, ShardRecording};
use reports::vocabulary::protocol::Protocol;
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;
use serde_json::Value;

use super::place::Place;
use super::shard_directory::ShardDirectory;
use super::shard_entry::{ShardEntry, ShardProgress};
use super::shard_files::write_shard_files;
use super::shard_journal::ShardJournal;
use super::share_of_work::take_share;
use super::unfinished_work::{Remains, UnfinishedWork, identity_of};
use super::whole_manifest::Pieces;
use super::whole_run::WholeRun;
use crate::commands::failure::Failure;
use crate::commands::open_datasets::{OpenedDataset, ids_of};
use crate::commands::progress::RunProgress;
use crate::commands::provenance::machine;
use crate::commands::recorder::Recorder;
use crate::commands::sinks::rerun_recording::RerunRecording;
use crate::commands::sinks::terminal::Terminal;
use crate::commands::standard_streams::print_diagnostic;
use crate::commands::watched_run::WatchedRun;

/// What goes over data sets scan by scan and is made of the rows of a run.
pub trait WatchedStudy {
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
    fn watched<'a>(&'a self, progress: &'a RunProgress) -> WatchedRun<'a>;

    /// Begins the recording `file`, which is called `name`, of every so many scans; `None` if none is wanted, as of studies.
    fn begin_recording(&self, _name: &str, _file: PathBuf) -> Result<Option<(Recorder, u64)>, Failure> {
        Ok(None)
    }

    /// What else watches all scans, and may leave files in `folder` that belong to the result.
    fn sinks<'a>(&'a self, _folder: &'a Path) -> Result<Sinks<'a, Failure>, Failure> {
        Ok(Vec::new())
    }

    /// Whether one of these has to see all scans at once. Then nothing is kept to go on with.
    fn sees_all(&self) -> bool {
        false
    }
}

/// A result in one piece, to which a study adds files of its own.
pub struct Made {
    // Invariant: before the directory, which removes the folders that were made for both.
    remains: Remains,
    /// Its directory.
    pub directory: RunDirectory,
    /// Its numbers, which are written.
    pub run: WholeRun,
    /// What still serves its recording.
    pub served: Option<Box<dyn Served>>,
}

impl Made {
    /// Gives the directory its name, and returns where it is, with the numbers.
    pub fn finish(self) -> Result<(PathBuf, WholeRun), Failure> {
        let finished = self.directory.finish()?;
        self.remains.clear();
        Ok((finished, self.run))
    }
}

/// Makes `study` in `place`: a shard is left there for `merge`, and all in one piece is handed back.
pub fn execute(study: &mut impl WatchedStudy, mut place: Place) -> Result<Option<Made>, Failure> {
    place.is_kept &= !study.sees_all();
    let (part, kind, is_kept) = (place.shard, place.study, place.is_kept);
    let share = take_share(study.datasets_mut(), part.unwrap_or(Shard::ONLY));
    let manifest = Manifest { shard: Some(place.record(share)), ..study.manifest() };
    let n_scans: usize = study.datasets().iter().map(|it| it.part.len()).sum();
    let mut progress = ShardProgress::default();
    let identity = identity_of(&manifest, study.rules());
    let (ids, extent) = (ids_of(study.datasets()), format!("{n_scans} scans"));
    let unfinished = UnfinishedWork::open(place, &ids, (&identity, extent), |it| progress.add(&it))?;
    if progress.n_scans > 0 {
        unfinished.tell_of_continuing(progress.n_scans, &format!("{n_scans} scans"));
    }
    unfinished.journal.add(&ShardEntry::Began { cpu_model: machine().cpu_model })?;
    leave_out_what_is_done(study.datasets_mut(), &progress);
    let n_starts = if progress.n_scans > 0 { progress.n_starts } else { 0 };
    let pass = Pass { unfinished: &unfinished, n_starts, has_all: part.is_none() };
    let end = Cell::new(None);
    let passed = pass.make(study, &manifest.protocols, &end);
    let has_scans = progress.n_scans > 0 || end.get().is_some();
    let record = manifest.shard.expect("it was just put there");
    let served = match passed {
        Ok(served) => served,
        Err(failure) if part.is_some() => return Err(unfinished.ended_by(failure)),
        Err(failure) => {
            let is_kept = is_kept && has_scans;
            return Err(ended_in_one_piece(unfinished, failure, (study, record, [is_kept, has_scans])));
        }
    };
    // Programs of others have introduced themselves by now.
    let manifest = study.manifest();
    if part.is_some() {
        let finished = unfinished.finish(|folder, journal, directory| {
            let (mut manifest, mut record) = (manifest, record);
            write_shard_files(journal, directory.folder(), (&mut manifest, &mut record))?;
            for recording in &record.recordings {
                keep(&folder.join(&recording.file), &directory.path_of(&recording.file))?;
            }
            manifest.shard = Some(record);
            Ok(manifest.to_json())
        });
        return finished.map(|()| None);
    }
    let (claimed, remains) = unfinished.into_parts();
    let directory = RunDirectory::begin(claimed)?;
    match put_in_one_piece(kind, (manifest, record), &remains, &directory) {
        Ok(run) => Ok(Some(Made { remains, directory, run, served })),
        Err(failure) => {
            if !is_kept || matches!(failure, Failure::NothingEvaluated(_)) {
                remains.clear();
            }
            Err(failure)
        }
    }
}

/// All numbers of what was kept in `remains`, written into `directory`.
fn put_in_one_piece(
    study: Study,
    (mut manifest, mut record): (Manifest, ShardRecord),
    remains: &Remains,
    directory: &RunDirectory,
) -> Result<WholeRun, Failure> {
    write_shard_files(&remains.journal, &remains.folder, (&mut manifest, &mut record))?;
    for file in std::fs::read_dir(&remains.folder).into_iter().flatten().flatten() {
        let (path, name) = (file.path(), file.file_name().to_string_lossy().into_owned());
        // Only what sees all scans is written as MCAP. In a folder that is kept it would be that of a run before.
        let is_mcap = remains.is_passing() && path.extension().is_some_and(|it| it == "mcap");
        if is_mcap || record.recordings.iter().any(|it| it.file == name) {
            keep(&path, &directory.path_of(&name))?;
        }
    }
    manifest.shard = Some(record.clone());
    let shards = [ShardDirectory { folder: remains.folder.clone(), record: &record }];
    WholeRun::write(study, (&shards, &[&manifest]), (directory, Pieces::One))
}

/// What is left of a result in one piece that `failure` has ended, of which there may be scans.
fn ended_in_one_piece(
    unfinished: UnfinishedWork,
    failure: Failure,
    (study, mut record, [is_kept, has_scans]): (&impl WatchedStudy, ShardRecord, [bool; 2]),
) -> Failure {
    match failure {
        // The disk is full, or somebody needs the machine: the same command goes on.
        Failure::Interrupted(_) | Failure::Internal(_) if is_kept => unfinished.ended_by(failure),
        // Whoever mends a detector starts again.
        Failure::Detector(_) if has_scans => {
            let rows = (&mut study.manifest(), &mut record);
            let left = write_shard_files(&unfinished.journal, &unfinished.folder, rows);
            match left.and_then(|()| unfinished.leave_files()) {
                Ok(folder) => {
                    print_diagnostic(format_args!(
                        "Rows of the scans before the failure: {}",
                        folder.display()
                    ));
                    failure
                }
                Err(failure) => failure,
            }
        }
        failure => {
            unfinished.discard();
            failure
        }
    }
}

/// Begins each data set behind the last scan that was judged.
fn leave_out_what_is_done(datasets: &mut [OpenedDataset], progress: &ShardProgress) {
    for (dataset_idx, place) in &progress.next_places {
        let part = &mut datasets[*dataset_idx].part;
        part.start = (*place).clamp(part.start, part.end);
    }
}

/// The way over the scans that are left.
struct Pass<'a> {
    unfinished: &'a UnfinishedWork,
    n_starts: usize,
    has_all: bool,
}

impl Pass<'_> {
    /// Goes it, and tells `end` the number behind that of the last scan.
    fn make(
        &self,
        study: &impl WatchedStudy,
        protocols: &[Protocol],
        end: &Cell<Option<u64>>,
    ) -> Result<Option<Box<dyn Served>>, Failure> {
        let mut served = None;
        let Some(first) = first_number(study.datasets()) else { return Ok(served) };
        let UnfinishedWork { folder, journal, claimed, .. } = self.unfinished;
        let progress = RunProgress::new();
        let file = match self.n_starts {
            0 => "run.rrd".to_owned(),
            n => format!("run-{}.rrd", n + 1),
        };
        let name = claimed.target().file_name().unwrap_or_default().to_string_lossy().into_owned();
        let recorder = study.begin_recording(&name, folder.join(&file))?;
        let every = recorder.as_ref().map(|(_, every)| *every);
        let mut sinks = if self.has_all { study.sinks(folder)? } else { Vec::new() };
        sinks.push(Box::new(recorder.map(|(it, _)| RerunRecording::new(it, &progress, &mut served))));
        sinks.push(Box::new(ShardJournal::new(journal, (study.datasets(), protocols), end)));
        sinks.push(Box::new(Terminal::new(&progress)));
        let ended = study.watched(&progress).run(sinks);
        let is_complete = matches!(ended, Ok(()) | Err(Failure::Interrupted(_) | Failure::Detector(_)));
        if let Some((end, every)) = end.get().zip(every).filter(|_| is_complete) {
            journal.add(&ShardEntry::Recorded(ShardRecording { file, first, end, every }))?;
        }
        ended.map(|()| served)
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
