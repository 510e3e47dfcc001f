//! Two runs over the same scans side by side, or two detectors of one run, without a verdict.

use crate::numbers::sums::RATIOS;
use crate::protocols::drawn_scans::DrawnScans;
use crate::protocols::protocol_number::ALL_CLASSES;
use crate::run_folder::run_archive::RunArchive;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::verdict::wording::{
    about_configuration, about_differences, difference_text, interval_cell, least_effect_text, metric_text,
    value_text,
};
use crate::uncertainty::sample::Question;
use crate::verdicts::comparability::{
    NotComparable, check_comparable, configuration_changes, detectors_only_in, detectors_with_other_results,
};
use crate::verdicts::drift::drift;
use crate::verdicts::gated_metrics::{about, judged};
use crate::verdicts::paired_difference::{PairedDifference, paired_difference};
use crate::verdicts::protocol_differences::{ProtocolPair, ProtocolSide, common_protocols, pairs};
use crate::vocabulary::slice::Slice;

/// What was compared with what, and what came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// In words.
    pub title: String,
    /// Task by task, detector by detector, slice by slice.
    pub differences: Vec<NamedDifference>,
    /// Number of scans on which results of a detector changed; `None` where two detectors are compared, of which that is
    /// expected.
    pub n_changed_scans: Option<usize>,
    /// What changed in the configuration of detectors, a text each.
    pub configuration_changes: Vec<String>,
    /// Detectors that only the later run has.
    pub new_detectors: Vec<String>,
    /// Detectors whose results were read from other files than before.
    pub other_results: Vec<String>,
}

/// A difference with what it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedDifference {
    /// Name of the task, or of the protocol, and of the data sets where recorded and simulated ones are compared apart.
    pub task: String,
    /// Name of the detector, or of both.
    pub detector: String,
    /// Name of the slice, or of the class under a protocol.
    pub slice: String,
    /// The numbers.
    pub difference: PairedDifference,
}

/// Which slices are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparedSlices {
    /// Everything as one.
    All,
    /// Every slice as well.
    Each,
}

/// Compares two runs over the same scans, over all data sets of one origin together.
///
/// # Errors
///
/// [`NotComparable`] if the scans or the rules of judging are not the same.
pub fn compare_runs(
    before: &RunArchive,
    after: &RunArchive,
    slices: ComparedSlices,
) -> Result<Comparison, NotComparable> {
    check_comparable(before, after)?;
    let tallies = [before.tally(), after.tally()];
    let draws = tallies[0].draw();
    let mut differences = Vec::new();
    let judged = judged(&tallies[0]);
    for (dataset, on) in &judged {
        for &task in tallies[0].tasks() {
            for detector in tallies[0].detectors() {
                let compared = tallies[0].slices(task, detector);
                for slice in compared.into_iter().filter(|it| is_compared(*it, slices)) {
                    let question = Question { dataset, task, detector, slice };
                    let [Some(before), Some(after)] =
                        [0, 1].map(|side| tallies[side].sample(&question, &draws))
                    else {
                        continue;
                    };
                    let of_metrics = RATIOS.iter().filter_map(|it| paired_difference(&before, &after, it));
                    let task = about(task.name(), on.as_deref());
                    differences.extend(of_metrics.map(|it| named(&task, detector, slice, it)));
                }
            }
        }
        let scans = DrawnScans::of(&tallies[0], dataset);
        for protocol in common_protocols(&before.protocols, &after.protocols) {
            let task = about(protocol.name(), on.as_deref());
            for detector in tallies[0].detectors() {
                let side = |it: &RunArchive| ProtocolSide::of(&it.protocols, protocol, detector, &scans);
                if let [Some(before), Some(after)] = [before, after].map(side) {
                    differences.extend(of_protocol(&task, detector, pairs(&before, &after, &scans), slices));
                }
            }
        }
    }
    let title = format!("Two runs over the same scans, {}", together(&judged));
    let n_changed_scans = Some(drift(before, after).len());
    let new_detectors = detectors_only_in(after, before);
    let other_results = detectors_with_other_results(before, after);
    let configuration_changes = configuration_changes(before, after);
    Ok(Comparison {
        title,
        differences,
        n_changed_scans,
        configuration_changes,
        new_detectors,
        other_results,
    })
}

/// Compares detector `second` of `run` with detector `first`, over all data sets of one origin together.
pub fn compare_detectors(run: &RunArchive, first: &str, second: &str, slices: ComparedSlices) -> Comparison {
    let tally = run.tally();
    let draws = tally.draw();
    let mut differences = Vec::new();
    let judged = judged(&tally);
    let name = format!("{second} − {first}");
    for (dataset, on) in &judged {
        for &task in tally.tasks() {
            for slice in tally.slices(task, first).into_iter().filter(|it| is_compared(*it, slices)) {
                let sample = |detector| tally.sample(&Question { dataset, task, detector, slice }, &draws);
                let [Some(before), Some(after)] = [first, second].map(sample) else { continue };
                let of_metrics = RATIOS.iter().filter_map(|it| paired_difference(&before, &after, it));
                let task = about(task.name(), on.as_deref());
                differences.extend(of_metrics.map(|it| named(&task, &name, slice, it)));
            }
        }
        let scans = DrawnScans::of(&tally, dataset);
        for protocol in run.protocols.protocols() {
            let task = about(protocol.name(), on.as_deref());
            let side = |detector| ProtocolSide::of(&run.protocols, protocol, detector, &scans);
            if let [Some(before), Some(after)] = [first, second].map(side) {
                differences.extend(of_protocol(&task, &name, pairs(&before, &after, &scans), slices));
            }
        }
    }
    let together = together(&judged);
    let title = format!("{first} (before) and {second} (after) on the same scans of one run, {together}");
    Comparison {
        title,
        differences,
        n_changed_scans: None,
        configuration_changes: Vec::new(),
        new_detectors: Vec::new(),
        other_results: Vec::new(),
    }
}

fn together(judged: &[(String, Option<String>)]) -> &'static str {
    if judged.len() > 1 { "recorded and simulated data sets apart" } else { "all data sets together" }
}

fn is_compared(slice: Slice, slices: ComparedSlices) -> bool {
    slices == ComparedSlices::Each || slice == Slice::All
}

/// Numbers of single classes are told where slices are.
fn of_protocol(
    protocol: &str,
    detector: &str,
    pairs: Vec<ProtocolPair>,
    slices: ComparedSlices,
) -> Vec<NamedDifference> {
    let has_summary = pairs.iter().any(|it| it.class == ALL_CLASSES);
    let is_told =
        |it: &ProtocolPair| slices == ComparedSlices::Each || !has_summary || it.class == ALL_CLASSES;
    let named = |it: ProtocolPair| {
        let (task, detector) = (protocol.to_owned(), detector.to_owned());
        Some(NamedDifference { task, detector, slice: it.class, difference: it.difference? })
    };
    pairs.into_iter().filter(is_told).filter_map(named).collect()
}

fn named(task: &str, detector: &str, slice: Slice, difference: PairedDifference) -> NamedDifference {
    let (task, slice) = (task.to_owned(), slice.name());
    NamedDifference { task, detector: detector.to_owned(), slice, difference }
}

impl Tabular for Comparison {
    fn sheet(&self) -> Sheet {
        Sheet::of(format!("{}.", self.title), self.grid(), self.sentences()).labelled("comparison")
    }
}

impl Comparison {
    fn sentences(&self) -> Vec<String> {
        let about_scans = self.n_changed_scans.map(|n| match n {
            0 => "No result of a scan changed.".to_owned(),
            n => format!("Results changed {n} times (counted per scan, detector and task)."),
        });
        let kind = self.differences.iter().find_map(|it| it.difference.interval).map(|it| it.blocks.kind);
        let about_numbers = match kind {
            Some(kind) => about_differences(kind),
            None => "There is only one block of scans, so there is no interval.".to_owned(),
        };
        let about_new = (!self.new_detectors.is_empty()).then(|| {
            format!("Not compared, because only the later run has it: {}.", self.new_detectors.join(", "))
        });
        let about_results = (!self.other_results.is_empty()).then(|| {
            format!(
                "The results of these changed before they were judged: {}.",
                self.other_results.join(", ")
            )
        });
        let about_configuration = about_configuration(&self.configuration_changes);
        let of_sides =
            about_scans.into_iter().chain(about_configuration).chain(about_new).chain(about_results);
        [about_numbers].into_iter().chain(of_sides).collect()
    }

    fn grid(&self) -> Grid {
        let left = ["task", "detector", "slice", "metric"].map(Column::left);
        let numbers = ["before", "after", "difference", "95 %", "least"].map(Column::number);
        let lines = self.differences.iter().map(|named| {
            let it = &named.difference;
            let metric = &it.metric;
            let cells = vec![
                Cell::new(named.task.as_str()),
                Cell::new(named.detector.clone()),
                Cell::new(named.slice.as_str()),
                Cell::new(metric_text(metric)),
                Cell::new(value_text(metric, it.before)),
                Cell::new(value_text(metric, it.after)),
                Cell::new(difference_text(metric, it.difference())),
                interval_cell(it),
                Cell::new(least_effect_text(it)),
            ];
            Line { kind: LineKind::Dataset, cells }
        });
        Grid { columns: left.into_iter().chain(numbers).collect(), lines: lines.collect() }
    }
}
