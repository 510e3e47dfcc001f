//! Detectors side by side on one data set after the other, watched by sinks.

use std::num::NonZeroUsize;

use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::counter::Counter;
use evaluation::run::running_detector::RunningDetector;
use evaluation::run::side_by_side::{OnDetectorFailure, SideBySide};
use evaluation::run::sink::{RunSink, Sinks, run_watched};
use scans::dataset::source::DamagePolicy;

use crate::plumbing::config::warn_of_unknown_sensor;
use crate::plumbing::failure::{Failure, NothingEvaluated};
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::opened_results::OpenedResults;
use crate::plumbing::progress::RunProgress;
use crate::plumbing::standard_streams::print_diagnostic;

/// Detectors, the data sets that they run on, and how.
pub struct WatchedRun<'a> {
    /// The detectors; all are judged in the same way.
    pub compared_detectors: &'a [ComparedDetector],
    /// Results of detectors that do not run here.
    pub results: Option<&'a OpenedResults>,
    pub datasets: &'a [OpenedDataset],
    pub damage: DamagePolicy,
    /// Detections of the first scan of a data set that are thrown away.
    pub n_warmup: u16,
    /// How often each detector looks at each scan.
    pub n_repeats: NonZeroUsize,
    /// Who counts instructions and memory, if they are counted.
    pub counter: Option<&'a Counter>,
    /// Scans that are read at once.
    pub n_jobs: usize,
    pub on_failure: OnDetectorFailure,
    pub progress: &'a RunProgress,
}

impl<'a> WatchedRun<'a> {
    /// The run of a study: `compared_detectors` run here, look once at each scan, and none may fail.
    pub fn of_study(
        compared_detectors: &'a [ComparedDetector],
        datasets: &'a [OpenedDataset],
        n_warmup: u16,
        n_jobs: usize,
        progress: &'a RunProgress,
    ) -> Self {
        Self {
            compared_detectors,
            results: None,
            datasets,
            damage: DamagePolicy::Refuse,
            n_warmup,
            n_repeats: NonZeroUsize::MIN,
            counter: None,
            n_jobs,
            on_failure: OnDetectorFailure::Stop,
            progress,
        }
    }

    /// Runs, and reports every scan to all `sinks`.
    pub fn run(&self, mut sinks: Sinks<'_, Failure>) -> Result<(), Failure> {
        let mut n_before = 0;
        for opened in self.datasets {
            let result = self.run_dataset(opened, n_before, &mut sinks);
            n_before += opened.scan_indices.len();
            match result {
                Ok(()) => {}
                // Results of other detectors and of earlier scans are not lost.
                Err(failure @ Failure::Detector(_)) => {
                    sinks.into_iter().try_for_each(RunSink::finish)?;
                    return Err(failure);
                }
                Err(failure @ Failure::Interrupted(_)) => {
                    sinks.into_iter().try_for_each(RunSink::break_off)?;
                    return Err(failure);
                }
                Err(failure) => return Err(failure),
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
        let Some(first) = self.compared_detectors.first() else { return Ok(()) };
        warn_of_unknown_sensor(&first.config, description);
        let mut detectors: Vec<_> = self
            .compared_detectors
            .iter()
            .map(|it| match self.results.and_then(|results| results.take(it.name, &description.id)) {
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
            class_criteria: &first.config.class_criteria,
            n_warmup: self.n_warmup.into(),
            n_repeats: self.n_repeats,
            counter: self.counter,
            n_jobs: self.n_jobs,
            on_failure: self.on_failure,
            interrupted: interruption_flag(),
        };
        let on_damage = |id: &_, error| self.progress.suspend(|| opened.on_damage(self.damage, id, error));
        run_watched(&side_by_side, &mut detectors, on_damage, sinks)?;
        for warning in detectors.into_iter().flat_map(RunningDetector::finish) {
            print_diagnostic(format_args!("warning: {warning}"));
        }
        opened.warn_of_points_left_out();
        Ok(())
    }
}

/// Labels of a data set in which nothing is to be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Labels {
    /// No scan is labelled.
    None,
    /// Scans are labelled, and nothing stands there.
    OfNothing { n_labeled_scans: u64 },
    /// Objects are labelled, of which none counts.
    OfObjects,
}

/// Reports that nothing is to be found in the scans of a data set: a warning if there are no labels, or if they say that
/// nothing stands there, and an error if there are objects but none counts.
pub fn report_nothing_to_find(
    id: &str,
    labels: Labels,
    n_scans: u64,
    suspicions: &[String],
) -> Result<(), Failure> {
    match labels {
        Labels::None => print_diagnostic(format_args!(
            "warning: {id:?} has no labels: nothing is scored, and detectors are compared with one another"
        )),
        Labels::OfNothing { n_labeled_scans } => print_diagnostic(format_args!(
            "warning: nothing is annotated in the {n_labeled_scans} labelled scans of {id:?}: every detection there is false, \
             and recall is undefined"
        )),
        Labels::OfObjects => {
            let why =
                if suspicions.is_empty() { String::new() } else { format!("; {}", suspicions.join("; ")) };
            let reason = format!("none of the {n_scans} scans of {id:?} has an annotation that counts{why}");
            return Err(NothingEvaluated { reason }.into());
        }
    }
    Ok(())
}
