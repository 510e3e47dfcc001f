//! A run that is made: all of it in one piece, or a shard.

use std::path::{Path, PathBuf};

use evaluation::run::counter::Counter;
use evaluation::run::scan_recorder::Served;
use evaluation::run::sink::Sinks;
use jiff::Timestamp;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RECORDING;
use reports::vocabulary::study::Study;
use scans::conversion::results::result_folder::ResultFolder;
use serde_json::Value;

use crate::cli::{ResultFilesArgs, RunArgs};
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::progress::RunProgress;
use crate::plumbing::recorder::{Recorder, RecordingPlace, begin_recording};
use crate::plumbing::shards::watched_study::{WatchedStudy, execute_watched};
use crate::plumbing::shards::whole_run::WholeRun;
use crate::plumbing::shards::work_output::{WorkOutput, refuse_what_is_for_whole_runs};
use crate::plumbing::sinks::detection_files::DetectionFiles;
use crate::plumbing::sinks::mcap_results::McapResults;
use crate::plumbing::watched_run::WatchedRun;
use crate::verbs::run::counted::counter_of;
use crate::verbs::run::setup::{ChosenRun, OpenedRun};

/// A finished run: its directory, its facts, and the server that still serves its recording.
pub type MadeRun = (PathBuf, WholeRun, Option<Box<dyn Served>>);

/// Makes a run; `None` if it is a shard.
pub fn made_run(arguments: &RunArgs) -> Result<Option<MadeRun>, Failure> {
    refuse_what_is_for_whole_runs(arguments.shard.shard, &arguments.stream)?;
    let counter = counter_of(arguments)?;
    let chosen = ChosenRun::of(arguments)?;
    let mut output = WorkOutput::claim(Study::Run, arguments.shard.shard, &arguments.output)?;
    output.is_kept &= arguments.add_to.is_none();
    let started = output.started;
    let mut study = RunStudy { arguments, opened: chosen.open(arguments)?, counter, started };
    let Some((made, served)) = execute_watched(&mut study, output)? else { return Ok(None) };
    let (finished, run) = made.finish()?;
    Ok(Some((finished, run, served)))
}

struct RunStudy<'a> {
    arguments: &'a RunArgs,
    opened: OpenedRun,
    counter: Option<Counter>,
    started: Timestamp,
}

impl WatchedStudy for RunStudy<'_> {
    fn datasets(&self) -> &[OpenedDataset] {
        &self.opened.datasets
    }

    fn datasets_mut(&mut self) -> &mut [OpenedDataset] {
        &mut self.opened.datasets
    }

    fn manifest(&self) -> Manifest {
        let counted_by = self.counter.as_ref().map(|it| it.name().to_owned());
        Manifest { counted_by, ..self.opened.manifest(self.arguments, self.started) }
    }

    fn rules(&self) -> Value {
        serde_json::json!({
            "on_detector_failure": format!("{:?}", self.arguments.on_detector_failure),
            "skip_damaged": self.arguments.damage.skip_damaged,
            "rerun_every": self.arguments.stream.rerun_every,
        })
    }

    fn watched<'a>(&'a self, progress: &'a RunProgress) -> WatchedRun<'a> {
        WatchedRun { counter: self.counter.as_ref(), ..self.opened.watched(self.arguments, progress) }
    }

    fn begin_recording(&self, name: &str, folder: PathBuf) -> Result<Option<(Recorder, u64)>, Failure> {
        let OpenedRun { compared_detectors, datasets, .. } = &self.opened;
        let joins = self.arguments.add_to.as_ref().map(|it| it.join(RECORDING));
        let place = RecordingPlace::Layers { folder, joins };
        begin_recording(&self.arguments.stream, &[], compared_detectors, datasets, name, place)
    }

    fn sinks<'a>(&'a self, folder: &'a Path) -> Result<Sinks<'a, Failure>, Failure> {
        let datasets = &self.opened.datasets;
        Ok(vec![
            Box::new(self.arguments.mcap.then(|| McapResults::new(folder, datasets.len()))),
            Box::new(detection_files(&self.arguments.result_files, datasets)?),
        ])
    }

    fn sees_all(&self) -> bool {
        let RunArgs { mcap, result_files, stream, .. } = self.arguments;
        *mcap || result_files.detections_out.is_some() || matches!(stream.save_rrd, Some(Some(_)))
    }
}

fn detection_files(
    arguments: &ResultFilesArgs,
    datasets: &[OpenedDataset],
) -> Result<Option<DetectionFiles>, Failure> {
    let Some((path, format)) = arguments.detections_out.as_deref().zip(arguments.result_format) else {
        return Ok(None);
    };
    for OpenedDataset { dataset, scan_indices, .. } in datasets {
        // A damaged scan is reported when it is its turn.
        let frames = scan_indices.iter().filter_map(|it| Some((*it, dataset.foreign_frame(*it).ok()?)));
        if let Some((scan_idx, frame)) = { frames }.next() {
            format.output().check(&dataset.scan_ids()[scan_idx], &frame)?;
        }
    }
    let folder = ResultFolder::create(path, format.output(), datasets.len() > 1)?;
    Ok(Some(DetectionFiles::new(folder)))
}
