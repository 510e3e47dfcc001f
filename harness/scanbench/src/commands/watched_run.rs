//! Detectors side by side on one data set after the other, watched by sinks.

use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use evaluation::run::entrant::Entrant;
use evaluation::run::running_detector::RunningDetector;
use evaluation::run::side_by_side::{OnDetectorFailure, SideBySide};
use evaluation::run::sink::{RunSink, Sinks, run_watched};
use scans::dataset::source::DamagePolicy;

use crate::commands::config::warn_of_unknown_sensor;
use crate::commands::failure::{Failure, NothingEvaluated};
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::opened_results::OpenedResults;
use crate::commands::progress::RunProgress;
use crate::commands::standard_streams::print_diagnostic;

/// Who runs on what, and how.
pub struct WatchedRun<'a> {
    /// Who takes part; all are judged in the same way.
    pub entrants: &'a [Entrant],
    /// What those found that do not run here.
    pub results: &'a OpenedResults,
    /// The data sets.
    pub datasets: &'a [OpenedDataset],
    /// What becomes of damaged scans.
    pub damage: DamagePolicy,
    /// Detections of the first scan of a data set that are thrown away.
    pub n_warmup: u16,
    /// How often each detector looks at each scan.
    pub n_repeats: NonZeroUsize,
    /// Scans that are read at once.
    pub n_jobs: usize,
    /// What becomes of the run where a detector fails.
    pub on_failure: OnDetectorFailure,
    /// Ends the run once it is set.
    pub interrupted: &'a AtomicBool,
    /// How far it is.
    pub progress: &'a RunProgress,
    /// What becomes of data sets in which there is nothing to find.
    pub without_labels: WithoutLabels,
}

/// What becomes of data sets in which there is nothing to find.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WithoutLabels {
    /// The run ends.
    Refuse,
    /// Without any labels, detectors are compared with one another; otherwise the run ends.
    Compare,
    /// Whoever puts the shards together asks. What a shard has done is kept if it is interrupted.
    AskLater,
}

impl WatchedRun<'_> {
    /// Runs, and tells all `sinks` of every scan.
    pub fn run(&self, mut sinks: Sinks<'_, Failure>) -> Result<(), Failure> {
        let mut n_before = 0;
        for opened in self.datasets {
            let result = self.run_dataset(opened, n_before, &mut sinks);
            n_before += opened.scan_indices.len();
            if let Err(failure) = result {
                let is_shard = self.without_labels == WithoutLabels::AskLater;
                if matches!(failure, Failure::Detector(_))
                    || (is_shard && matches!(failure, Failure::Interrupted(_)))
                {
                    // What others and earlier scans made is not lost.
                    sinks.into_iter().try_for_each(RunSink::finish)?;
                }
                return Err(failure);
            }
        }
        sinks.into_iter().try_for_each(RunSink::finish)
    }

    fn run_dataset(
        &self,
        opened: &OpenedDataset,
        n_before: usize,
        sinks: &mut Sinks<'_, Failure>,
    ) -> Result<(), Failure> {
        if opened.part.is_empty() {
            return Ok(());
        }
        let description = opened.dataset.description();
        let Some(first) = self.entrants.first() else { return Ok(()) };
        warn_of_unknown_sensor(&first.config, description);
        let mut detectors: Vec<_> = self
            .entrants
            .iter()
            .map(|it| match self.results.take(it.name, &description.id) {
                Some(results) => it.begin_with_results(description, results),
                None => it.begin(description),
            })
            .collect();
        let side_by_side = SideBySide {
            dataset: &*opened.dataset,
            scan_indices: &opened.scan_indices,
            part: opened.part.clone(),
            n_before,
            matching: first.config.matching,
            n_warmup: self.n_warmup.into(),
            n_repeats: self.n_repeats,
            n_jobs: self.n_jobs,
            on_failure: self.on_failure,
            interrupted: self.interrupted,
        };
        let on_damage = |id: &_, error| self.progress.suspend(|| opened.on_damage(self.damage, id, error));
        let judged = run_watched(&side_by_side, &mut detectors, on_damage, sinks)?;
        for warning in detectors.into_iter().flat_map(RunningDetector::finish) {
            print_diagnostic(format_args!("warning: {warning}"));
        }
        opened.warn_of_points_left_out();
        let goes_on = self.without_labels == WithoutLabels::Compare;
        let is_asked_later = self.without_labels == WithoutLabels::AskLater;
        if is_asked_later || judged.n_annotations > 0 {
            return Ok(());
        }
        let has_labels = judged.n_labels > 0 || !goes_on;
        let doubts: Vec<String> = opened.first_look.doubts.iter().map(ToString::to_string).collect();
        tell_of_nothing(&description.id, has_labels, judged.n_scans, &doubts)
    }
}

/// Says that nothing is to be found in the scans of a data set: a warning without any labels, and an error with some, of which none
/// counts.
pub fn tell_of_nothing(id: &str, has_labels: bool, n_scans: u64, doubts: &[String]) -> Result<(), Failure> {
    if !has_labels {
        print_diagnostic(format_args!(
            "warning: {id:?} has no labels: nothing is scored, and detectors are compared with one another"
        ));
        return Ok(());
    }
    let why = if doubts.is_empty() { String::new() } else { format!("; {}", doubts.join("; ")) };
    let reason = format!("none of the {n_scans} scans of {id:?} has an annotation that counts{why}");
    Err(NothingEvaluated { reason }.into())
}
