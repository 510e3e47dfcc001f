//! What experiments on simulated scans have in common.

use evaluation::metrics::counts::SCORING_VERSION;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::{ListedDetector, detectors_named};
use jiff::Timestamp;
use reports::files::archive::SCHEMA;
use reports::run_folder::experiment_manifest::ExperimentManifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::LatestPointer;
use simulator::SIMULATOR_VERSION;

use crate::cli::{ExperimentArgs, OutputArgs};
use crate::commands::config::detector_config;
use crate::commands::failure::Failure;
use crate::commands::provenance::{command_line, compact_utc, git_state, rfc3339_utc, rustc_version};
use crate::commands::run_directory::begin_run_directory;

/// Who looks at the scans of an experiment, and since when.
pub struct Experiment {
    /// Parameters of detectors and matching.
    pub config: RunConfig,
    /// The detectors.
    pub detectors: Vec<ListedDetector>,
    /// What everything is drawn from.
    pub seed: u64,
    /// When it began.
    pub started: Timestamp,
}

impl Experiment {
    /// What `arguments` ask for; `detectors` if they name none.
    ///
    /// # Errors
    ///
    /// If there is no such detector, or the configuration cannot be used.
    pub fn begin(arguments: &ExperimentArgs, detectors: &[&str]) -> Result<Self, Failure> {
        let unnamed: Vec<String> = detectors.iter().map(|&it| it.to_owned()).collect();
        let names = if arguments.detectors.is_empty() { &unnamed } else { &arguments.detectors };
        let detectors = detectors_named(names)?;
        Ok(Self {
            config: detector_config(&arguments.config, &detectors)?,
            detectors,
            seed: arguments.seed,
            started: Timestamp::now(),
        })
    }

    /// Begins the directory, called after the experiment `name` unless `output` says otherwise.
    ///
    /// # Errors
    ///
    /// If the directory exists or cannot be written.
    pub fn begin_directory(&self, output: &OutputArgs, name: &str) -> Result<RunDirectory, Failure> {
        begin_run_directory(output, &format!("{}-{name}", compact_utc(self.started)), LatestPointer::Leave)
    }

    /// Everything that decides the numbers; `details` is what only this experiment has.
    pub fn manifest(&self, details: serde_json::Value) -> ExperimentManifest {
        ExperimentManifest {
            schema: SCHEMA,
            scoring_version: SCORING_VERSION,
            scanbench_version: env!("CARGO_PKG_VERSION").to_owned(),
            created: rfc3339_utc(self.started),
            argv: command_line(),
            simulated: true,
            simulator_version: SIMULATOR_VERSION,
            seed: self.seed,
            detectors: self.detectors.iter().map(|it| it.name.to_owned()).collect(),
            config: serde_json::to_value(&self.config.resolved).expect("a configuration has text keys only"),
            experiment: details,
            git: git_state(),
            rustc_version: rustc_version(),
        }
    }
}
