//! `scanbench sweep`.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use evaluation::journal::{Journal, JournalError, JournalKind, OtherJournal};
use evaluation::sweep::journal_entry::JournalEntry;
use evaluation::sweep::quality_pass::{SweepError, SweepPass, SweptDataset};
use evaluation::sweep::scan_at_point::ScanAtPoint;
use evaluation::sweep::summary::SweepResults;
use evaluation::sweep::sweep_plan::SweepPlan;
use evaluation::sweep::swept_protocols::SweptProtocols;
use evaluation::sweep::swept_values::SweptValues;
use evaluation::sweep::timed_scan::TimedScan;
use evaluation::sweep::timing_pass::DETECTIONS_PER_SCAN;
use jiff::Timestamp;
use reports::numbers::sweep_score::SweepScores;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::LatestPointer;
use reports::run_folder::run_target::MANIFEST_JSON;
use scans::dataset::source::DamagePolicy;

use crate::cli::{ConfigArgs, SweepArgs};
use crate::commands::config::{choose_criterion, chosen_detectors, warn_of_unknown_sensor};
use crate::commands::failure::{Failure, NothingEvaluated};
use crate::commands::first_look::look_first_at_all;
use crate::commands::interruption::{interruption_flag, set_last_words};
use crate::commands::open_datasets::{OpenedDataset, ids_of, open_datasets_past_damage};
use crate::commands::progress::progress_over_results;
use crate::commands::provenance::compact_utc;
use crate::commands::recorder::record_sweep;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::run_manifest::{RunSettings, detector_entries, run_manifest};
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::sweep_files::write_sweep;
use crate::commands::sweep_identity::sweep_identity;
use crate::commands::sweep_protocol_files::write_swept_protocols;

/// What is swept, over what, and where it goes.
struct Sweep<'a> {
    arguments: &'a SweepArgs,
    plan: SweepPlan,
    // `None` without protocols of others.
    protocols: Option<SweptProtocols>,
    datasets: Vec<OpenedDataset>,
    started: Timestamp,
}

/// Runs detectors at every combination of parameter values on the same scans, writes tables and plots, and prints the best.
///
/// What is done is kept beside the directory until that is written, so that the sweep may be ended at any time and goes on
/// when it is asked for again.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged, what is there is of another sweep, or the output cannot be written.
pub fn sweep(arguments: &SweepArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let plan = sweep_plan(arguments)?;
    // Now, and not after the work: it may be that nothing can be written there.
    let named = claim_named(&arguments.output)?;
    let sweep = Sweep::new(arguments, plan, started)?;
    let unnamed = format!("{}-sweep-{}", compact_utc(started), ids_of(&sweep.datasets));
    let claimed = claim_unnamed(named, &unnamed, LatestPointer::Leave)?;
    let (journal, done) = sweep.open_journal(claimed.target())?;
    let how_to_go_on = how_to_go_on(claimed.target());
    set_last_words(how_to_go_on.clone());
    let (counted, timed) = match sweep.run(&journal, done, interrupted) {
        Ok(results) => results,
        Err(error) => {
            if matches!(error, SweepError::Interrupted { .. } | SweepError::InterruptedWhileTimed) {
                print_diagnostic(how_to_go_on);
            }
            return Err(error.into());
        }
    };
    sweep.datasets.iter().for_each(OpenedDataset::warn_of_points_left_out);
    let swept = sweep.swept_datasets();
    let results = SweepResults { plan: &sweep.plan, datasets: &swept, scans: &counted, times: &timed };
    let scores = results.summary();
    refuse_nothing(&scores)?;
    let directory = RunDirectory::begin(claimed)?;
    directory.write_file(MANIFEST_JSON, sweep.manifest().as_bytes())?;
    let mut printed = write_sweep(&directory, &scores)?;
    if let Some(protocols) = &sweep.protocols {
        printed.push_str(&write_swept_protocols(&directory, protocols, (&results, &scores))?);
    }
    if !arguments.no_rrd {
        record_sweep(&directory, &results, &scores)?;
    }
    let finished = directory.finish()?;
    set_last_words(String::new());
    journal.remove()?;
    let printed = print_result(printed);
    // Also where nobody takes the tables: the files are there.
    print_diagnostic(format_args!("Sweep: {}", finished.display()));
    printed
}

impl<'a> Sweep<'a> {
    fn new(arguments: &'a SweepArgs, mut plan: SweepPlan, started: Timestamp) -> Result<Self, Failure> {
        let policy = arguments.damage.policy();
        let mut datasets = open_datasets_past_damage(&arguments.data, policy, &plan.base.classes)?;
        if policy == DamagePolicy::Skip {
            // Threads take scans in any order, so that it has to be known before which there are.
            datasets.iter_mut().try_for_each(OpenedDataset::leave_out_damaged)?;
        }
        let datasets = look_first_at_all(datasets, &mut plan.base);
        for point in &mut plan.points {
            point.config.own_curves.clone_from(&plan.base.own_curves);
        }
        let protocols = SweptProtocols::of(&arguments.protocol.protocols, plan.points.len());
        for opened in &datasets {
            warn_of_unknown_sensor(&plan.base, &opened.dataset.description().sensor);
            if let Some(protocols) = &protocols {
                protocols.chosen.check(&*opened.dataset)?;
            }
        }
        Ok(Self { arguments, plan, protocols, datasets, started })
    }

    fn open_journal(&self, target: &Path) -> Result<(Journal, Vec<JournalEntry>), JournalError> {
        let mut path = target.as_os_str().to_owned();
        path.push(".unfinished");
        let path = PathBuf::from(path);
        let other =
            if self.arguments.output.overwrite { OtherJournal::Discard } else { OtherJournal::Refuse };
        let identity = sweep_identity(self.arguments, &self.plan, &self.datasets);
        let mut done = Vec::new();
        let journal = Journal::open(&path, (JournalKind::Sweep, &identity), other, |it| done.push(it))?;
        if !done.is_empty() {
            print_diagnostic(format_args!("Continuing with {} results from {}", done.len(), path.display()));
        }
        Ok((journal, done))
    }

    fn swept_datasets(&self) -> Vec<SweptDataset<'_>> {
        self.datasets
            .iter()
            .map(|it| SweptDataset { dataset: &*it.dataset, scan_indices: &it.scan_indices })
            .collect()
    }

    fn run(
        &self,
        journal: &Journal,
        done: Vec<JournalEntry>,
        interrupted: &AtomicBool,
    ) -> Result<(Vec<ScanAtPoint>, Vec<TimedScan>), SweepError> {
        let (mut counted, mut timed) = (Vec::new(), Vec::new());
        for entry in done {
            match entry {
                JournalEntry::Quality(it) => counted.push(it),
                JournalEntry::Times(it) => timed.push(it),
            }
        }
        let datasets = self.swept_datasets();
        let n_scans: usize = datasets.iter().map(|it| it.scan_indices.len()).sum();
        let bar = progress_over_results(n_scans * self.plan.points.len(), counted.len(), "counting");
        let on_done = || bar.inc(1);
        let pass = SweepPass {
            plan: &self.plan,
            datasets: &datasets,
            protocols: self.protocols.as_ref(),
            journal,
            interrupted,
            on_done: &on_done,
        };
        let counted = pass.count(counted, self.n_jobs())?;
        bar.finish_and_clear();
        let n_timed = self.arguments.timed_scans as usize;
        let per_scan = self.plan.points.len() * self.plan.detectors.len();
        let n_timings = pass.timed_scans(n_timed).len() * per_scan;
        let bar = progress_over_results(n_timings, timed.len() * per_scan, "timing");
        let on_done = || bar.inc(1);
        let timed = SweepPass { on_done: &on_done, ..pass }.time(timed, n_timed)?;
        bar.finish_and_clear();
        Ok((counted, timed))
    }

    fn n_jobs(&self) -> usize {
        let n_cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        self.arguments.jobs.map_or_else(n_cores, usize::from)
    }

    fn manifest(&self) -> String {
        let mut manifest = run_manifest(RunSettings {
            selection: self.arguments.data.scans.as_deref(),
            n_warmup: 1,
            n_repeats: NonZeroUsize::MIN,
            config: &self.plan.base,
            detectors: detector_entries(&self.plan.detectors, &self.plan.base),
            datasets: &self.datasets,
            protocols: &self.arguments.protocol.protocols,
            started: self.started,
        });
        // Which scans have been read depends on where the sweep was taken up.
        manifest.datasets.iter_mut().for_each(|it| it.n_points_left_out = 0);
        let values = |it: &SweptValues| serde_json::json!({ "name": it.name, "values": it.values });
        let sweep = serde_json::json!({
            "swept": self.plan.swept.iter().map(values).collect::<Vec<_>>(),
            "tied": self.plan.tied,
            "n_points": self.plan.points.len(),
            "n_timed_scans_per_data_set": self.arguments.timed_scans,
            "n_timed_detections_per_scan_and_point": DETECTIONS_PER_SCAN,
        });
        let mut json = serde_json::to_string_pretty(&SweepManifest { run: &manifest, sweep })
            .expect("a manifest has text keys only");
        json.push('\n');
        json
    }
}

fn sweep_plan(arguments: &SweepArgs) -> Result<SweepPlan, Failure> {
    let file = ConfigArgs { config: arguments.config.clone(), parameters: Vec::new() };
    let (detectors, mut config) = chosen_detectors(&file, &arguments.detectors)?;
    choose_criterion(&mut config, &arguments.matching);
    let lists: Vec<SweptValues> = arguments.lists.iter().map(|it| it.0.clone()).collect();
    Ok(SweepPlan::new(&config, detectors, &arguments.parameters, &lists)?)
}

fn how_to_go_on(target: &Path) -> String {
    format!("Results are kept: to continue, give the same command with -o {}", target.display())
}

/// That of a run, and what is swept.
#[derive(serde::Serialize)]
struct SweepManifest<'a> {
    #[serde(flatten)]
    run: &'a Manifest,
    sweep: serde_json::Value,
}

fn refuse_nothing(scores: &SweepScores) -> Result<(), NothingEvaluated> {
    if scores.scores.iter().any(|it| it.counts.no() > 0) {
        return Ok(());
    }
    Err(NothingEvaluated { reason: "no scan has an annotation that counts".to_owned() })
}
