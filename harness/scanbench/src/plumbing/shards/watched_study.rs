//! Studies that go over data sets scan by scan, and are made of the rows of a run.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use evaluation::journal::Journal;
use evaluation::run::config::VehicleModels;
use evaluation::run::scan_recorder::Served;
use evaluation::run::sink::Sinks;
use reports::files::archive::ArchiveError;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{RECORDING, RunDirectory};
use reports::run_folder::shard_record::{ProcessorRows, ShardRecord, ShardRecording};
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;
use serde_json::{Value, json};

use super::detection_look::DetectionLook;
use super::executor::{Finished, SharedWork, execute};
use super::run_event::{EventProgress, RunEvent};
use super::run_log::{EventsMade, RunLog};
use super::run_rows::RunRows;
use super::scan_events::ScanEvents;
use super::share_of_work::{ShareOfWork, claim_share};
use super::unfinished_work::{KeptFiles, UnfinishedWork};
use super::whole_run::WholeRun;
use super::work_output::WorkOutput;
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::{OpenedDataset, ids_of};
use crate::plumbing::progress::RunProgress;
use crate::plumbing::provenance::machine;
use crate::plumbing::recorder::Recorder;
use crate::plumbing::second_names::keep;
use crate::plumbing::sinks::rerun_recording::RerunRecording;
use crate::plumbing::sinks::terminal::Terminal;
use crate::plumbing::standard_streams::print_diagnostic;
use crate::plumbing::watched_run::WatchedRun;

/// A study that goes over data sets scan by scan, and is made of the rows of a run.
pub trait WatchedStudy {
    fn datasets(&self) -> &[OpenedDataset];

    /// The data sets, to be cut.
    fn datasets_mut(&mut self) -> &mut [OpenedDataset];

    fn manifest(&self) -> Manifest;

    /// Facts that decide the rows and that the manifest lacks; null for all but `scanbench run`.
    fn rules(&self) -> Value {
        Value::Null
    }

    /// The run over its data sets.
    fn watched<'a>(&'a self, progress: &'a RunProgress) -> WatchedRun<'a>;

    /// Begins the recording in `folder`, called `name`, and returns it with the n of one scan in n; `None` if none is wanted.
    fn begin_recording(&self, _name: &str, _folder: PathBuf) -> Result<Option<(Recorder, u64)>, Failure> {
        Ok(None)
    }

    /// Other sinks of all scans, which may leave files in `folder` that belong to the result.
    fn sinks<'a>(&'a self, _folder: &'a Path) -> Result<Sinks<'a, Failure>, Failure> {
        Ok(Vec::new())
    }

    /// Whether one of these has to see all scans at once. Then nothing is kept to continue from.
    fn sees_all(&self) -> bool {
        false
    }
}

/// A run in one piece, or a study that is one, with the server that still serves its recording.
pub type FinishedRun = (Finished<WholeRun>, Option<Box<dyn Served>>);

/// Makes `study` in `output`: a shard is left there for `merge`, and a result in one piece is returned.
pub fn execute_watched(
    study: &mut impl WatchedStudy,
    output: WorkOutput,
) -> Result<Option<FinishedRun>, Failure> {
    let mut work = Watched {
        study,
        progress: EventProgress::default(),
        made: EventsMade::default(),
        end: Cell::new(None),
        served: None,
    };
    let made = execute(&mut work, output)?;
    Ok(made.map(|it| (it, work.served)))
}

/// A study, and how far it is.
struct Watched<'a, S> {
    study: &'a mut S,
    progress: EventProgress,
    made: EventsMade,
    // The number after that of the last scan that was judged now.
    end: Cell<Option<u64>>,
    served: Option<Box<dyn Served>>,
}

impl<S: WatchedStudy> SharedWork for Watched<'_, S> {
    type Event = RunEvent;
    type Whole = WholeRun;

    fn claim_share(&mut self, shard: Shard) -> ShareOfWork {
        claim_share(self.study.datasets_mut(), shard)
    }

    fn manifest(&self, shard: Option<ShardRecord>) -> Manifest {
        Manifest { shard, ..self.study.manifest() }
    }

    fn rules(&self) -> Value {
        let progress = RunProgress::new();
        let compared_detectors = self.study.watched(&progress).compared_detectors;
        let models = compared_detectors.iter().filter_map(|it| it.config.vehicle_models.as_ref());
        json!({
            "of_study": self.study.rules(),
            // The models themselves, beyond the names of their directories.
            "vehicle_models": models.map(VehicleModels::identity).collect::<Vec<_>>(),
        })
    }

    fn ids(&self) -> String {
        ids_of(self.study.datasets())
    }

    fn extent(&self) -> String {
        format!("{} scans", self.n_scans())
    }

    fn sees_all(&self) -> bool {
        self.study.sees_all()
    }

    fn add_done(&mut self, event: RunEvent) -> bool {
        let parts: Vec<_> = self.study.datasets().iter().map(|it| it.part.clone()).collect();
        let is_next = self.progress.allows(&event, &parts);
        if is_next {
            self.progress.add(&event);
            self.made.summary.add(&event);
        }
        is_next
    }

    fn done(&self) -> Option<String> {
        let n_done = self.progress.n_scans;
        (n_done > 0).then(|| format!("{n_done} of {} scans", self.n_scans()))
    }

    fn resume(&mut self, unfinished: &UnfinishedWork, record: &ShardRecord) -> Result<(), Failure> {
        if unfinished.is_in_one_piece() {
            self.made.rows = Some(self.rows_so_far(unfinished, record.clone())?);
        }
        leave_out_what_is_done(self.study.datasets_mut(), &self.progress);
        let log = RunLog::new(unfinished.kept_journal(), std::mem::take(&mut self.made));
        let ended = self.pass(unfinished, &log);
        self.made = log.into_made();
        self.served = ended?;
        Ok(())
    }

    fn ended_by(&mut self, failure: Failure, unfinished: UnfinishedWork) -> Failure {
        let has_scans = self.progress.n_scans > 0 || self.end.get().is_some();
        // Its files are finished or removed before their folder.
        let rows = self.made.rows.take();
        match failure {
            // The disk is full, or the machine is needed: the same command continues.
            Failure::Interrupted(_) | Failure::Internal(_) | Failure::Unwritten(_) if has_scans => {
                unfinished.ended_by(failure)
            }
            // After a detector is mended, the run starts again.
            Failure::Detector(_) if has_scans => leave_rows(rows, unfinished).err().unwrap_or(failure),
            failure => {
                drop(rows);
                unfinished.discarded_by(failure)
            }
        }
    }

    fn finished_manifest(&mut self, _: &Journal, record: ShardRecord) -> Result<Manifest, Failure> {
        // Programs of others have introduced themselves by now.
        let mut manifest = self.study.manifest();
        std::mem::take(&mut self.made.summary).write_to(&mut manifest, record);
        Ok(manifest)
    }

    fn whole(
        &mut self,
        study: Study,
        _: &KeptFiles,
        manifest: &Manifest,
        directory: &RunDirectory,
    ) -> Result<WholeRun, Failure> {
        let rows = self.made.rows.take().expect("work in one piece has rows");
        WholeRun::in_one_piece(study, rows, manifest, directory)
    }

    fn move_beside_files(
        &self,
        kept: &KeptFiles,
        manifest: &Manifest,
        directory: &RunDirectory,
    ) -> Result<(), Failure> {
        let recordings = manifest.shard.iter().flat_map(|it| &it.recordings);
        let recordings: Vec<&str> = recordings.map(|it| it.file.as_str()).collect();
        for file in std::fs::read_dir(&kept.folder).into_iter().flatten().flatten() {
            let (path, name) = (file.path(), file.file_name().to_string_lossy().into_owned());
            // Only a run that sees all scans writes MCAP. In a folder that is kept, such a file is of an earlier run.
            let is_mcap = kept.is_passing() && path.extension().is_some_and(|it| it == "mcap");
            if is_mcap || recordings.contains(&name.as_str()) {
                keep(&path, &directory.path_of(&name))?;
            }
        }
        Ok(())
    }
}

impl<S: WatchedStudy> Watched<'_, S> {
    fn n_scans(&self) -> usize {
        self.study.datasets().iter().map(|it| it.part.len()).sum()
    }

    /// The rows of the scans that are done, to be added to on this processor.
    fn rows_so_far(&self, unfinished: &UnfinishedWork, mut record: ShardRecord) -> Result<RunRows, Failure> {
        let here = ProcessorRows { cpu_model: machine().cpu_model, n_scan_rows: 0 };
        record.processors = self.made.summary.processors().iter().cloned().chain([here]).collect();
        let manifest = Manifest { shards: vec![record], ..self.study.manifest() };
        let mut rows = RunRows::begin(&manifest, &unfinished.folder)?;
        let (journal, mut written) = (&unfinished.journal, Ok(()));
        if journal.n_entries() > 0 {
            Journal::read(journal.path(), |event| {
                written = rows.add(&event, 0);
                written.is_ok()
            })
            .map_err(|source| ArchiveError::Read { path: journal.path().to_owned(), source })?;
        }
        written?;
        Ok(rows)
    }

    /// Goes over the scans that are left.
    fn pass(
        &self,
        unfinished: &UnfinishedWork,
        log: &RunLog<'_>,
    ) -> Result<Option<Box<dyn Served>>, Failure> {
        log.add(&RunEvent::Began { cpu_model: machine().cpu_model })?;
        let (study, mut served) = (&*self.study, None);
        let Some(first) = first_number(study.datasets()) else { return Ok(served) };
        let UnfinishedWork { folder, claimed, .. } = unfinished;
        let progress = RunProgress::new();
        let file = match self.progress.n_starts {
            n if n > 0 && self.progress.n_scans > 0 => format!("{RECORDING}-{}", n + 1),
            _ => RECORDING.to_owned(),
        };
        let name = claimed.target().file_name().unwrap_or_default().to_string_lossy().into_owned();
        let recorder = study.begin_recording(&name, folder.join(&file))?;
        let every = recorder.as_ref().map(|(_, every)| *every);
        let manifest = study.manifest();
        let mut sinks = if unfinished.is_in_one_piece() { study.sinks(folder)? } else { Vec::new() };
        sinks.push(Box::new(recorder.map(|(it, _)| RerunRecording::new(it, &progress, &mut served))));
        sinks.push(Box::new(ScanEvents::new(log, study.datasets(), &manifest.protocols, &self.end)));
        sinks.push(Box::new(DetectionLook::new(log, &progress, &manifest)));
        sinks.push(Box::new(Terminal::new(&progress)));
        let ended = study.watched(&progress).run(sinks);
        let is_complete = matches!(ended, Ok(()) | Err(Failure::Interrupted(_) | Failure::Detector(_)));
        if let Some((end, every)) = self.end.get().zip(every).filter(|_| is_complete) {
            log.add(&RunEvent::Recorded(ShardRecording { file, first, end, every }))?;
        }
        ended.map(|()| served)
    }
}

/// Leaves the rows of the scans before a failure, but no journal to continue from.
fn leave_rows(rows: Option<RunRows>, unfinished: UnfinishedWork) -> Result<(), Failure> {
    rows.map_or(Ok(()), |it| it.files.finish())?;
    let folder = unfinished.leave_files()?;
    print_diagnostic(format_args!("Rows of the scans before the failure: {}", folder.display()));
    Ok(())
}

/// Begins each data set behind the last scan that was judged.
fn leave_out_what_is_done(datasets: &mut [OpenedDataset], progress: &EventProgress) {
    for (dataset_idx, index) in &progress.next_indices {
        let part = &mut datasets[*dataset_idx].part;
        part.start = (*index).clamp(part.start, part.end);
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
