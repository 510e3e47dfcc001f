//! Studies of detectors on scans, each of which is looked at once.

use std::cell::RefCell;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::RunConfig;
use evaluation::run::gap_experiment::PairTally;
use evaluation::run::scan_recorder::FigureView;
use evaluation::run::sink::Sinks;
use jiff::Timestamp;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use serde_json::Value;

use crate::cli::{ExperimentArgs, OutputArgs, StreamArgs};
use crate::plumbing::config::{chosen_detectors, hide_run};
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::progress::RunProgress;
use crate::plumbing::recorder::{Recorder, RecordingPlace, begin_recording};
use crate::plumbing::run_manifest::{RunSettings, detector_entry, run_manifest};
use crate::plumbing::shards::watched_study::{WatchedStudy, execute_watched};
use crate::plumbing::shards::whole_run::WholeRun;
use crate::plumbing::shards::work_output::WorkOutput;
use crate::plumbing::standard_streams::print_result_in;
use crate::plumbing::watched_run::WatchedRun;

/// Detectors, and the scans that they look at.
pub struct ScanStudy<'a> {
    /// Parameters of detectors and matching.
    pub config: RunConfig,
    pub compared_detectors: Vec<ComparedDetector>,
    pub datasets: Vec<OpenedDataset>,
    /// Which scans of the data sets were chosen, as the command line writes it; `None` for all.
    pub selection: Option<&'a str>,
    /// Detections of the first scan of each data set that are thrown away.
    pub n_warmup: u16,
    /// Scans that are read at once.
    pub n_jobs: usize,
    pub started: Timestamp,
    /// Scenes that were put up for it, if any.
    pub staged: Option<StagedScenes>,
    /// Arguments of its recording, and the figures that are views of their own; `None` if nothing is recorded.
    pub recorded: Option<(StreamArgs, &'static [FigureView])>,
    /// Tally of pairs, which looks at clusters: no row has these.
    pub pairs: Option<&'a RefCell<PairTally<'a>>>,
}

/// Writes the files that only a study has into the directory of a run, and returns the text to print.
pub type WriteStudy = fn(&RunDirectory, &WholeRun) -> Result<Printed, Failure>;

pub struct Printed {
    /// Kind of its files, such as `Tables`.
    pub files: &'static str,
    /// The result.
    pub text: String,
}

impl Printed {
    /// Prints it; the files are in `finished`.
    pub fn print(self, finished: &Path) -> Result<(), Failure> {
        print_result_in(self.files, finished, self.text)
    }
}

/// Makes `study` in `output` as a run with the files that `write` adds; or a shard of that.
pub fn make_study(study: &mut ScanStudy<'_>, output: WorkOutput, write: WriteStudy) -> Result<(), Failure> {
    let Some((made, _)) = execute_watched(study, output)? else { return Ok(()) };
    let printed = write(&made.directory, &made.whole)?;
    printed.print(&made.finish()?.0)
}

/// Scenes that were put up for a study.
pub struct StagedScenes {
    /// Kind of the scenes, such as `streets`.
    pub drawn: &'static str,
    /// Seed that they are drawn from.
    pub seed: u64,
    pub scenes: Value,
}

impl ScanStudy<'_> {
    /// A study of simulated scans that are still to be put up, by the detectors that `arguments` name, or else `detectors`;
    /// its result goes to `output`.
    pub fn of_simulated_scans(
        arguments: &ExperimentArgs,
        detectors: &[&str],
        output: &OutputArgs,
        started: Timestamp,
    ) -> Result<Self, Failure> {
        let unnamed: Vec<String> = detectors.iter().map(|&it| it.to_owned()).collect();
        let names = if arguments.detectors.is_empty() { &unnamed } else { &arguments.detectors };
        let (chosen, mut config) = chosen_detectors(&arguments.config, names)?;
        output.output.iter().for_each(|it| hide_run(it, &mut config));
        Ok(Self {
            compared_detectors: chosen.into_iter().map(|it| ComparedDetector::of(it, &config)).collect(),
            config,
            datasets: Vec::new(),
            selection: None,
            n_warmup: 1,
            n_jobs: std::thread::available_parallelism().map_or(1, NonZeroUsize::get),
            started,
            staged: None,
            recorded: None,
            pairs: None,
        })
    }

    pub fn compared_detector(&self, name: &str) -> Option<&ComparedDetector> {
        self.compared_detectors.iter().find(|it| it.name == name)
    }
}

impl WatchedStudy for ScanStudy<'_> {
    fn datasets(&self) -> &[OpenedDataset] {
        &self.datasets
    }

    fn datasets_mut(&mut self) -> &mut [OpenedDataset] {
        &mut self.datasets
    }

    fn manifest(&self) -> Manifest {
        let mut manifest = run_manifest(RunSettings {
            selection: self.selection,
            n_warmup: self.n_warmup,
            n_repeats: NonZeroUsize::MIN,
            config: &self.config,
            detectors: self.compared_detectors.iter().map(detector_entry).collect(),
            datasets: &self.datasets,
            protocols: &[],
            started: self.started,
        });
        if let Some(StagedScenes { drawn, seed, scenes }) = &self.staged {
            manifest.seeds.insert((*drawn).to_owned(), *seed);
            manifest.experiment = Some(scenes.clone());
        }
        manifest
    }

    fn watched<'a>(&'a self, progress: &'a RunProgress) -> WatchedRun<'a> {
        WatchedRun::of_study(&self.compared_detectors, &self.datasets, self.n_warmup, self.n_jobs, progress)
    }

    fn begin_recording(&self, name: &str, folder: PathBuf) -> Result<Option<(Recorder, u64)>, Failure> {
        let Some((stream, figures)) = &self.recorded else { return Ok(None) };
        let place = RecordingPlace::Layers { folder, joins: None };
        begin_recording(stream, figures, &self.compared_detectors, &self.datasets, name, place)
    }

    fn sinks<'a>(&'a self, _: &'a Path) -> Result<Sinks<'a, Failure>, Failure> {
        Ok(vec![Box::new(self.pairs)])
    }

    fn sees_all(&self) -> bool {
        self.pairs.is_some()
    }
}
