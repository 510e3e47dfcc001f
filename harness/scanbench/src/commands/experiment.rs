//! What experiments on simulated scans have in common.

use std::num::NonZeroUsize;

use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::ChosenDetector;
use evaluation::run::entrant::Entrant;
use jiff::Timestamp;
use reports::run_folder::manifest::Manifest;

use crate::cli::ExperimentArgs;
use crate::commands::config::chosen_detectors;
use crate::commands::failure::Failure;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::run_manifest::{RunSettings, detector_entries, run_manifest};

/// Who looks at the scans of an experiment, and since when.
pub struct Experiment {
    /// Parameters of detectors and matching.
    pub config: RunConfig,
    /// What everything is drawn from.
    pub seed: u64,
    detectors: Vec<ChosenDetector>,
    started: Timestamp,
}

impl Experiment {
    /// Detections of the first scan of each data set that are thrown away.
    const N_WARMUP: u16 = 1;

    /// What `arguments` ask for, begun at `started`; `detectors` if they name none.
    pub fn begin(
        (arguments, detectors): (&ExperimentArgs, &[&str]),
        started: Timestamp,
    ) -> Result<Self, Failure> {
        let unnamed: Vec<String> = detectors.iter().map(|&it| it.to_owned()).collect();
        let names = if arguments.detectors.is_empty() { &unnamed } else { &arguments.detectors };
        let (detectors, config) = chosen_detectors(&arguments.config, names)?;
        Ok(Self { config, detectors, seed: arguments.seed, started })
    }

    /// Detections that are thrown away, and scans that are read at once.
    pub fn timing() -> (u16, usize) {
        (Self::N_WARMUP, std::thread::available_parallelism().map_or(1, NonZeroUsize::get))
    }

    /// Who takes part.
    pub fn entrants(&self) -> Vec<Entrant> {
        self.detectors.iter().map(|it| Entrant::of(it.clone(), &self.config)).collect()
    }

    /// That of a run on `datasets`, which are drawn from the seed of `drawn`; `put_up` is what only this experiment has.
    pub fn manifest(&self, drawn: &str, put_up: serde_json::Value, datasets: &[OpenedDataset]) -> Manifest {
        let mut manifest = run_manifest(RunSettings {
            selection: None,
            n_warmup: Self::N_WARMUP,
            n_repeats: NonZeroUsize::MIN,
            config: &self.config,
            detectors: detector_entries(&self.detectors, &self.config),
            datasets,
            protocols: &[],
            started: self.started,
        });
        manifest.seeds.insert(drawn.to_owned(), self.seed);
        Manifest { experiment: Some(put_up), ..manifest }
    }
}
