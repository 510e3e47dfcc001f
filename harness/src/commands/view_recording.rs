//! The recording of the scans with the worst mistakes.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use clap::Parser as _;
use reports::manifest::{DatasetEntry, Manifest};
use reports::worst::ListedMistake;

use crate::cli::{Cli, Command, RunArgs, StreamArgs, ViewArgs};
use crate::commands::config::judging_config;
use crate::commands::failure::Usage;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, open_datasets_past_damage};
use crate::commands::progress::progress_over_scans;
use crate::commands::recording::Recording;
use crate::commands::run_manifest::{dataset_entry, seeds};
use crate::commands::standard_streams::print_diagnostic;
use crate::run::config::RunConfig;
use crate::run::detector_list::{ListedDetector, detectors_named};
use crate::run::scores::DatasetScores;
use crate::run::side_by_side::SideBySide;

/// Runs the scans of `mistakes` again as `manifest` says, and records them, the first mistake's first.
///
/// # Errors
///
/// If data or parameters are not what they were, a scan cannot be read, or the recording cannot be written.
pub fn record(
    arguments: &ViewArgs,
    manifest: &Manifest,
    mistakes: &[ListedMistake<'_>],
) -> anyhow::Result<()> {
    if arguments.stream.no_rrd {
        return Ok(());
    }
    // Before anything is written, so that Ctrl-C leaves nothing behind.
    let interrupted = interruption_flag()?;
    let again = RunAgain::of(manifest)?;
    let scans = again.scans_of(mistakes)?;
    let file = arguments.run.join("worst.rrd");
    let stream = StreamArgs {
        // Named, so that the file appears whole or not at all.
        save_rrd: Some(Some(arguments.stream.save_rrd.clone().flatten().unwrap_or(file.clone()))),
        no_rrd: false,
        connect: arguments.stream.connect.clone(),
        spawn: arguments.stream.spawn,
    };
    let written = stream.save_rrd.clone().flatten().unwrap_or_default();
    let names: Vec<&str> = again.detectors.iter().map(|it| it.name).collect();
    let name = format!("worst of {}", arguments.run.file_name().unwrap_or_default().to_string_lossy());
    let Some(mut recording) = Recording::begin(&stream, file, &name, arguments.task.task(), &names)? else {
        return Ok(());
    };
    again.log(&scans, interrupted, &mut recording)?;
    if let Some(warning) = recording.finish()? {
        print_diagnostic(format_args!("warning: {warning}"));
    }
    print_diagnostic(format_args!("Recording: {}", written.display()));
    Ok(())
}

/// What is needed to run scans once more.
struct RunAgain {
    arguments: Box<RunArgs>,
    config: RunConfig,
    detectors: Vec<ListedDetector>,
    datasets: Vec<OpenedDataset>,
}

impl RunAgain {
    fn of(manifest: &Manifest) -> anyhow::Result<Self> {
        let parsed = Cli::try_parse_from(&manifest.argv).map(|it| it.command);
        let Ok(Command::Run(arguments)) = parsed else {
            let line = manifest.argv.join(" ");
            return Err(Usage(format!("this program cannot repeat the run of `{line}`")).into());
        };
        let detectors = detectors_named(&arguments.detectors)?;
        let config = judging_config(&arguments.config, &arguments.matching, &detectors)?;
        anyhow::ensure!(
            serde_json::to_value(&config.resolved)? == manifest.config,
            Usage("the parameters are not those of the run: a file or this program has changed".to_owned())
        );
        let datasets = open_datasets_past_damage(&arguments.data, arguments.damage.policy())?;
        for opened in &datasets {
            let id = &opened.dataset.description().id;
            let found = dataset_entry(opened, &arguments.data);
            // Simulated scans have no checksum: they are what version, street and seed make.
            let is_same = |entry: &&DatasetEntry| {
                (&entry.id, &entry.checksum, &entry.simulation)
                    == (&found.id, &found.checksum, &found.simulation)
            };
            anyhow::ensure!(
                manifest.datasets.iter().any(|entry| is_same(&entry))
                    && seeds(&datasets).get(id) == manifest.seeds.get(id),
                Usage(format!(
                    "the scans of {id:?} are not those of the run: data or simulator have changed"
                ))
            );
        }
        Ok(Self { arguments: Box::new(arguments), config, detectors, datasets })
    }

    /// Data set and scan of every mistake, each once, in their order.
    fn scans_of(&self, mistakes: &[ListedMistake<'_>]) -> anyhow::Result<Vec<[usize; 2]>> {
        let mut scans = Vec::new();
        for mistake in mistakes {
            let row = mistake.row;
            let is_its = |it: &OpenedDataset| it.dataset.description().id == row.dataset;
            let place = self.datasets.iter().position(is_its).and_then(|dataset_idx| {
                let ids = self.datasets[dataset_idx].dataset.scan_ids();
                let scan_idx =
                    ids.iter().position(|id| id.sequence == row.sequence && id.index == row.scan)?;
                Some([dataset_idx, scan_idx])
            });
            let place = place.ok_or_else(|| {
                Usage(format!(
                    "scan {} {} of {:?} is not there any more",
                    row.sequence, row.scan, row.dataset
                ))
            })?;
            if !scans.contains(&place) {
                scans.push(place);
            }
        }
        Ok(scans)
    }

    fn log(
        &self,
        scans: &[[usize; 2]],
        interrupted: &AtomicBool,
        recording: &mut Recording,
    ) -> anyhow::Result<()> {
        let names: Vec<&'static str> = self.detectors.iter().map(|it| it.name).collect();
        // Detectors and rates so far of every data set that has had a scan.
        let mut begun = BTreeMap::new();
        let progress = progress_over_scans(scans.len(), "worst scans");
        for &[dataset_idx, scan_idx] in scans {
            let opened = &self.datasets[dataset_idx];
            let description = opened.dataset.description();
            let config = self.config.for_sensor(&description.sensor).unwrap_or_else(|| self.config.clone());
            let n_warmup = if begun.contains_key(&dataset_idx) { 0 } else { self.arguments.timing.warmup };
            let (detectors, scores) = begun.entry(dataset_idx).or_insert_with(|| {
                let built = self.detectors.iter().map(|it| it.build(&config, description.sensor_height_m));
                (built.collect::<Vec<_>>(), DatasetScores::new(description.clone(), &names))
            });
            let side_by_side = SideBySide {
                dataset: &*opened.dataset,
                scan_indices: &[scan_idx],
                matching: config.matching,
                n_warmup: n_warmup.into(),
                n_jobs: 1,
                interrupted,
            };
            side_by_side.run(detectors, |results| -> anyhow::Result<()> {
                scores.add(results.results);
                if let Some(warning) = recording.log(&results, scores)? {
                    progress.suspend(|| print_diagnostic(format_args!("warning: {warning}")));
                }
                Ok(())
            })?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(())
    }
}
