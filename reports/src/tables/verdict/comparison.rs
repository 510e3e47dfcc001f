//! Two runs over the same scans side by side, or two detectors of one run, without a verdict.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::numbers::tally::Tally;
use crate::protocols::drawn_scans::DrawnScans;
use crate::protocols::protocol_number::ALL_CLASSES;
use crate::run_folder::run_archive::RunArchive;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::verdict::wording::{
    DETECTABLE, about_configuration, about_differences, difference_text, interval_cell, least_effect_text,
    metric_text, value_text,
};
use crate::uncertainty::sample::{Question, Sample};
use crate::verdicts::change::{ChangeKind, in_words, n_of_kinds};
use crate::verdicts::classes_of_both::with_classes_of_both;
use crate::verdicts::comparability::{
    NotComparable, check_comparable, configuration_changes, detectors_only_in,
};
use crate::verdicts::drift::{ScanDrift, drift};
use crate::verdicts::gated_metrics::{about, judged};
use crate::verdicts::paired_difference::{PairedDifference, paired_difference};
use crate::verdicts::partial_differences::{
    PartialDifference, differences_of_methods, differences_of_results,
};
use crate::verdicts::protocol_differences::{
    ProtocolPair, ProtocolSide, common_protocols, pairs as pairs_of,
};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::protocol::Protocol;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::study::Study;
use crate::vocabulary::task::Task;

/// A comparison of two runs or two detectors, and its result.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Both sides, in words.
    pub title: String,
    /// Task by task, detector by detector, slice by slice.
    pub differences: Vec<NamedDifference>,
    /// Name of a unit that is judged by itself, for people.
    pub unit: &'static str,
    /// Number of scans on which results of a detector changed, and of changes of each kind; `None` where two detectors are
    /// compared, whose results are expected to differ.
    pub drift: Option<(usize, BTreeMap<ChangeKind, usize>)>,
    /// Names of the detector and the task with the most changed results, if any changed.
    pub most_changed: Option<(String, String)>,
    /// Doubts about data sets and detectors, and those that users overruled, a sentence each.
    pub doubts: Vec<String>,
    /// Changes in the configuration of detectors, a text each.
    pub configuration_changes: Vec<String>,
    /// Detectors that only the later run has.
    pub new_detectors: Vec<String>,
}

/// A difference with its subject.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedDifference {
    /// Name of the task, or of the protocol, and of the data sets where recorded and simulated ones are compared apart.
    pub task: String,
    /// Name of the detector, or of both.
    pub detector: String,
    /// Name of the slice, or of the class under a protocol.
    pub slice: String,
    /// Whether detectors are known by it.
    pub is_headline: bool,
    /// The numbers.
    pub difference: PairedDifference,
}

/// Which slices are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparedSlices {
    /// Everything together.
    All,
    /// Every slice, too.
    Each,
}

/// Compares two runs over the same scans, over all data sets of one origin together: all detectors, or `only` these.
///
/// # Errors
///
/// [`NotComparable`] if the scans or the rules of judging are not the same.
pub fn compare_runs(
    before: &RunArchive,
    after: &RunArchive,
    slices: ComparedSlices,
    only: Option<&[String]>,
) -> Result<Comparison, NotComparable> {
    let sides = [before.clone(), after.clone()].map(|it| of_detectors(it, only));
    check_comparable(&sides[0], &sides[1])?;
    let [before, after] = &with_classes_of_both(sides);
    let tallies = [before.tally(), after.tally()];
    let [tally, tally_after] = &tallies;
    let is_asked = |it: &&String| only.is_none_or(|only| only.contains(it));
    let asked = tally.detectors().iter().filter(is_asked);
    let pairs: Vec<_> = asked.map(|it| (it.clone(), [it.as_str(); 2])).collect();
    let mut differences = differences([(before, tally), (after, tally_after)], &pairs, slices);
    differences.extend(named(differences_of_results(&before.objects, &after.objects)));
    let drift = drift(before, after);
    Ok(Comparison {
        title: format!("Two runs over the same {}s, {}", after.manifest.unit(), about_data(after, tally)),
        differences,
        unit: after.manifest.unit(),
        most_changed: most_changed(&drift),
        drift: Some((drift.len(), n_of_kinds(drift.iter().flat_map(|it| &it.changes)))),
        doubts: after.manifest.doubts_in_words(),
        configuration_changes: configuration_changes(before, after),
        new_detectors: detectors_only_in(after, before),
    })
}

/// Names of the detector and the task with the most changes, the first among equals.
fn most_changed(drift: &[ScanDrift]) -> Option<(String, String)> {
    let mut n_changes: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for ScanDrift { subject, changes } in drift {
        *n_changes.entry((&subject.detector, &subject.task)).or_default() += changes.len();
    }
    let (most, _) = n_changes.into_iter().rev().max_by_key(|(_, n)| *n)?;
    Some((most.0.to_owned(), most.1.to_owned()))
}

/// The rows of these detectors of `run`; all where none are named.
fn of_detectors(mut run: RunArchive, only: Option<&[String]>) -> RunArchive {
    if let Some(only) = only {
        run.scans.retain(|it| only.contains(&it.detector));
        run.matches.retain(|it| only.contains(&it.detector));
        run.manifest.detectors.retain(|it| only.contains(&it.name));
        run.objects.retain(|it| only.iter().any(|name| name == it.method()));
    }
    run
}

/// Compares detector `second` of `run` with detector `first`, over all data sets of one origin together; or two methods.
///
/// # Errors
///
/// [`NotComparable`] if methods did not see the same parts of objects.
pub fn compare_detectors(
    run: &RunArchive,
    first: &str,
    second: &str,
    slices: ComparedSlices,
) -> Result<Comparison, NotComparable> {
    let tally = run.tally();
    let pair = (format!("{second} − {first}"), [first, second]);
    let mut differences = differences([(run, &tally); 2], &[pair], slices);
    let of_methods = differences_of_methods(&run.objects, first, second);
    differences.extend(named(of_methods.map_err(|reason| NotComparable { reasons: vec![reason] })?));
    let (unit, about_data) = (run.manifest.unit(), about_data(run, &tally));
    Ok(Comparison {
        title: format!("A: {first}, B: {second}, on the same {unit}s of one run, {about_data}"),
        differences,
        unit,
        drift: None,
        most_changed: None,
        doubts: run.manifest.doubts_in_words(),
        configuration_changes: Vec::new(),
        new_detectors: Vec::new(),
    })
}

/// The differences of partly seen objects, with their names.
fn named(differences: Vec<PartialDifference>) -> impl Iterator<Item = NamedDifference> {
    differences.into_iter().map(|it| {
        let PartialDifference { on, detector, slice, difference, .. } = it;
        NamedDifference {
            task: about(Study::Partial.name(), Some(&on)),
            detector,
            slice,
            is_headline: true,
            difference,
        }
    })
}

/// The differences between two sides, of each pair of detectors with its name.
fn differences(
    sides: [(&RunArchive, &Tally); 2],
    pairs: &[(String, [&str; 2])],
    slices: ComparedSlices,
) -> Vec<NamedDifference> {
    let (tally, draws) = (sides[0].1, sides[0].1.draw());
    let mut differences = Vec::new();
    for (dataset, on) in &judged(tally) {
        for &task in tally.tasks() {
            for (name, detectors) in pairs {
                let compared = tally.slices(task, detectors[0]).into_iter();
                for slice in compared.filter(|it| slices == ComparedSlices::Each || *it == Slice::All) {
                    let sample = |side: usize| {
                        let question = Question { dataset, task, detector: detectors[side], slice };
                        sides[side].1.sample(&question, &draws)
                    };
                    let [Some(before), Some(after)] = [0, 1].map(sample) else { continue };
                    let of_metrics = compared_metrics(task, slices, &before, &after);
                    let has_f_rate = [&before, &after].iter().all(|it| it.value(&Metric::FRate).is_some());
                    let headline = if has_f_rate { Metric::FRate } else { Metric::Recall };
                    let of_metrics =
                        of_metrics.into_iter().filter_map(|it| paired_difference(&before, &after, &it));
                    let task = about(task.name(), on.as_deref());
                    differences.extend(of_metrics.map(|difference| {
                        let (task, detector, slice) = (task.clone(), name.clone(), slice.name());
                        let is_headline = difference.metric == headline;
                        NamedDifference { task, detector, slice, is_headline, difference }
                    }));
                }
            }
        }
        let scans = DrawnScans::of(tally, dataset);
        let rows = sides.map(|it| &it.0.protocols);
        for protocol in common_protocols(rows[0], rows[1]) {
            let task = about(protocol.name(), on.as_deref());
            for (name, detectors) in pairs {
                let side = |it: usize| ProtocolSide::of(rows[it], protocol, detectors[it], &scans);
                if let [Some(before), Some(after)] = [0, 1].map(side) {
                    let pairs = pairs_of(&before, &after, &scans);
                    differences.extend(of_protocol(protocol, [&task, name], pairs, slices));
                }
            }
        }
    }
    differences
}

/// The ratios of a task; of a class the rates alone unless slices are asked for, too, and false detections where no
/// annotation counts.
fn compared_metrics(task: Task, slices: ComparedSlices, before: &Sample, after: &Sample) -> Vec<Metric> {
    let rates = [Metric::Precision, Metric::Recall, Metric::FRate];
    let mut metrics: Vec<Metric> = Metric::of_sums().filter(Metric::is_ratio).collect();
    if task.class().is_some() {
        metrics.retain(|it| slices == ComparedSlices::Each || rates.contains(it));
        let has_annotations = |it: &Sample| it.value(&Metric::No).is_some_and(|it| it > 0.0);
        if ![before, after].into_iter().any(has_annotations) {
            metrics.push(Metric::Fo);
        }
    }
    metrics
}

fn about_data(run: &RunArchive, tally: &Tally) -> String {
    if let Some(partial) = &run.manifest.partial {
        return partial.title().trim_end_matches('.').to_owned();
    }
    let together = if judged(tally).len() > 1 {
        "recorded and simulated data sets apart"
    } else {
        "all data sets together"
    };
    together.to_owned()
}

/// The differences under a protocol; those of single classes only where slices are compared, or there are no others.
fn of_protocol(
    protocol: Protocol,
    [task, detector]: [&str; 2],
    pairs: Vec<ProtocolPair>,
    slices: ComparedSlices,
) -> Vec<NamedDifference> {
    let has_summary = pairs.iter().any(|it| it.class == ALL_CLASSES);
    let is_shown =
        |it: &ProtocolPair| slices == ComparedSlices::Each || !has_summary || it.class == ALL_CLASSES;
    let named = |it: ProtocolPair| {
        let (task, detector) = (task.to_owned(), detector.to_owned());
        let is_headline = protocol.principal_metrics().contains(&it.metric.id().as_str());
        Some(NamedDifference { task, detector, slice: it.class, is_headline, difference: it.difference? })
    };
    pairs.into_iter().filter(is_shown).filter_map(named).collect()
}

impl Tabular for Comparison {
    fn sheet(&self) -> Sheet {
        let title = format!("{}.", self.title);
        let sheet = if self.differences.is_empty() {
            Sheet::of_parts(Vec::new(), [vec![title], self.sentences()].concat())
        } else {
            Sheet::of(title, self.grid_of(&self.differences.iter().collect::<Vec<_>>()), self.sentences())
        };
        sheet.labelled("comparison")
    }
}

impl Comparison {
    /// The names of its sides: two runs come one after the other, two detectors do not.
    fn sides(&self) -> [&'static str; 2] {
        if self.drift.is_some() { ["before", "after"] } else { ["A", "B"] }
    }

    fn sentences(&self) -> Vec<String> {
        let about_scans = self.drift.as_ref().map(|(n, changes)| match n {
            0 => format!("No result of a {} changed.", self.unit),
            n => format!(
                "Results changed {n} times (counted per {}, detector and task): {}.",
                self.unit,
                in_words(changes)
            ),
        });
        let kind = self.differences.iter().find_map(|it| it.difference.interval).map(|it| it.blocks.kind);
        let about_numbers = match kind {
            Some(kind) => {
                let [first, second] = self.sides();
                about_differences(&format!("{second} − {first}"), kind)
            }
            None if self.differences.is_empty() => {
                "There are no numbers to compare: the scans have no labels.".to_owned()
            }
            None => "There is no interval: the scans, or those of one of the data sets, are a single block; run --blocks FILE \
                     says which of them belong together."
                .to_owned(),
        };
        let about_new = (!self.new_detectors.is_empty()).then(|| {
            format!("Not compared, because only the later run has it: {}.", self.new_detectors.join(", "))
        });
        let about_configuration = about_configuration(&self.configuration_changes);
        let of_sides = about_scans.into_iter().chain(about_configuration).chain(about_new);
        [about_numbers].into_iter().chain(self.doubts.iter().cloned()).chain(of_sides).collect()
    }

    /// The table of some of its differences.
    pub(super) fn grid_of(&self, shown: &[&NamedDifference]) -> Grid {
        let left = ["task", "detector", "slice", "metric"].map(Column::left);
        let [first, second] = self.sides();
        let numbers = [first, second, "difference", "95 %", DETECTABLE].map(Column::number);
        let lines = shown.iter().map(|named| {
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

row! {
    /// A difference, with its interval where there are enough blocks for one.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct DifferenceRow {
        task: String,
        detector: String,
        slice: String,
        metric: String,
        before: Fixed<6>,
        after: Fixed<6>,
        difference: Fixed<6>,
        low: Option<Fixed<6>>,
        high: Option<Fixed<6>>,
        few_blocks: Option<bool>,
        least_effect: Option<Fixed<6>>,
    }
}

impl DifferenceRow {
    /// The rows of a comparison, in the order of its table.
    pub fn all(comparison: &Comparison) -> Vec<Self> {
        comparison.differences.iter().map(Self::of).collect()
    }

    fn of(NamedDifference { task, detector, slice, difference, .. }: &NamedDifference) -> Self {
        Self {
            task: task.clone(),
            detector: detector.clone(),
            slice: slice.clone(),
            metric: difference.metric.id(),
            before: Fixed(difference.before),
            after: Fixed(difference.after),
            difference: Fixed(difference.difference()),
            low: difference.interval.map(|it| Fixed(it.ends[0])),
            high: difference.interval.map(|it| Fixed(it.ends[1])),
            few_blocks: difference.interval.map(|it| it.blocks.decide_nothing()),
            least_effect: difference.least_effect.map(Fixed),
        }
    }
}
