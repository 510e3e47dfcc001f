//! Lines of numbers that may be compared, and the runs where they changed.

use std::collections::BTreeMap;

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

use super::change_points::{ChangePoint, change_points};
use super::history_file::{History, Number, NumberName, RunOfHistory};
use crate::run_folder::detector_changes::detector_changes;
use crate::run_folder::manifest::{DatasetEntry, Manifest};
use crate::verdicts::comparability::differences_of_rules_and_data;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;

/// Only so many of the last runs of a line are looked at: the effort grows with the square of their number.
pub const MOST_RUNS: usize = 200;

/// Runs that may be compared: judged by the same rules, of the same data.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparable {
    /// Indices of the runs.
    pub runs: Vec<usize>,
    /// Why its runs may not be compared with those of the group before; empty for the first.
    pub reasons: Vec<String>,
}

/// The values of one number in runs that may be compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Trend {
    /// What the number is about.
    pub name: NumberName,
    /// Index of the group of comparable runs.
    pub group: usize,
    /// The processor, for times.
    pub processor: Option<String>,
    /// The index of each run with the number that it has.
    pub values: Vec<(usize, Number)>,
    /// Changes; their indices are those of `values`.
    pub changes: Vec<ChangePoint>,
}

/// A history with its trends.
#[derive(Debug, Clone)]
pub struct Trends<'a> {
    /// The runs with their names, by time.
    pub runs: Vec<(&'a str, &'a RunOfHistory)>,
    /// Groups of runs that may be compared.
    pub groups: Vec<Comparable>,
    /// The trends, by group and name.
    pub trends: Vec<Trend>,
    history: &'a History,
}

/// What the values of a line have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct LineName<'a> {
    group: usize,
    name: &'a NumberName,
    processor: Option<&'a str>,
}

/// The metrics that are looked at unless others are asked for.
pub const USUAL_METRICS: [&str; 3] = ["f_rate", "recall", "time_over_reference"];

impl<'a> Trends<'a> {
    /// Those of `metrics` in `history`. Recall is left out where there is an F-rate, unless it alone is asked for.
    pub fn of(history: &'a History, metrics: &[Metric]) -> Self {
        let runs = history.runs();
        let groups = comparable_runs(history, &runs);
        let mut lines: BTreeMap<LineName<'_>, Vec<(usize, Number)>> = BTreeMap::new();
        for (group, of_group) in groups.iter().enumerate() {
            for &run_idx in &of_group.runs {
                let run = runs[run_idx].1;
                for (name, number) in run.numbers.iter().filter(|(name, _)| metrics.contains(&name.metric)) {
                    let processor = name.metric.is_time().then_some(run.machine.cpu_model.as_str());
                    lines.entry(LineName { group, name, processor }).or_default().push((run_idx, *number));
                }
            }
        }
        let has_f_rate = |name: &NumberName| {
            let of_rate = NumberName { metric: Metric::FRate, ..name.clone() };
            metrics.contains(&Metric::FRate) && runs.iter().any(|(_, run)| run.numbers.contains_key(&of_rate))
        };
        lines.retain(|line, _| line.name.metric != Metric::Recall || !has_f_rate(line.name));
        let trends = lines.into_par_iter().map(|(line, values)| {
            let values: Vec<(usize, Number)> = values[values.len().saturating_sub(MOST_RUNS)..].to_vec();
            let numbers: Vec<f64> = values.iter().map(|(_, it)| it.value).collect();
            let LineName { group, name, processor } = line;
            let (name, processor) = (name.clone(), processor.map(str::to_owned));
            Trend { name, group, processor, changes: change_points(&numbers), values }
        });
        let trends = trends.collect();
        Self { runs, groups, trends, history }
    }

    /// What changed from the run before in the same group to the run of this index: settings, models, program.
    pub fn what_changed(&self, run_idx: usize) -> Vec<String> {
        let group = self.groups.iter().find(|it| it.runs.contains(&run_idx));
        let before = group.and_then(|it| it.runs.iter().rev().find(|it| **it < run_idx));
        let Some(&before) = before else { return Vec::new() };
        let [(_, before), (_, now)] = [self.runs[before], self.runs[run_idx]];
        let [old, new] = [before, now].map(|it| self.history.settings(it));
        let mut changes: Vec<String> = Vec::new();
        for entry in &new.detectors {
            match old.detectors.iter().find(|it| it.name == entry.name) {
                Some(before) => changes.extend(detector_changes(before, entry)),
                None => changes.push(format!("{} is new", entry.name)),
            }
        }
        let is_gone = |name: &str| new.detectors.iter().all(|it| it.name != name);
        let gone = old.detectors.iter().map(|it| it.name.as_str()).filter(|it| is_gone(it));
        changes.extend(gone.map(|it| format!("{it} is gone")));
        if (&before.commit, before.dirty) != (&now.commit, now.dirty) {
            changes.push(format!("commit {} → {}", before.short_commit(), now.short_commit()));
        }
        if let (Some(before), Some(now)) = (&before.program, &now.program)
            && before != now
        {
            changes.push(format!("scanbench {before} → {now}"));
        }
        changes
    }

    /// The runs at which some trend changed, each with the trends and their changes: first those over several data sets, of
    /// these the largest change.
    pub fn changed_runs(&self) -> Vec<(usize, Vec<(&Trend, &ChangePoint)>)> {
        let mut by_run: BTreeMap<usize, Vec<(&Trend, &ChangePoint)>> = BTreeMap::new();
        for trend in &self.trends {
            for change in &trend.changes {
                by_run.entry(trend.values[change.first_after].0).or_default().push((trend, change));
            }
        }
        let size = |change: &ChangePoint| ((change.means[1] - change.means[0]) / change.means[0]).abs();
        for (run_idx, changes) in &mut by_run {
            let datasets = &self.history.settings(self.runs[*run_idx].1).datasets;
            let is_single = |trend: &Trend| datasets.iter().any(|it| it.id == trend.name.subject.dataset);
            changes.sort_by(|(trend, change), (other_trend, other)| {
                is_single(trend).cmp(&is_single(other_trend)).then(size(other).total_cmp(&size(change)))
            });
        }
        by_run.into_iter().collect()
    }

    /// The largest difference of a rate between neighbouring runs: its trend, the index of the later run, and the difference.
    /// `None` if no rate differs.
    pub fn largest_step(&self) -> Option<(&Trend, usize, f64)> {
        let rates = self.trends.iter().filter(|it| it.name.metric.unit() == "ratio");
        let steps = rates.flat_map(|trend| {
            let pairs = trend.values.windows(2);
            pairs.map(move |pair| (trend, pair[1].0, pair[1].1.value - pair[0].1.value))
        });
        // The first among equals.
        let larger = |best: (_, _, f64), it: (_, _, f64)| if it.2.abs() > best.2.abs() { it } else { best };
        steps.reduce(larger).filter(|it| it.2 != 0.0)
    }

    /// Number of trends that are long enough to have a change.
    pub fn n_looked_at(&self) -> usize {
        self.trends.iter().filter(|it| it.values.len() >= 4).count()
    }
}

impl Trend {
    /// Its number in words, such as `F-rate of vehicles, pca, streets`.
    pub fn in_words(&self) -> String {
        let subject = &self.name.subject;
        let slice =
            if subject.slice == Slice::All { String::new() } else { format!(" in {}", subject.slice) };
        let about =
            if self.name.metric.is_time() { String::new() } else { format!(" of {}{slice}", subject.task) };
        let processor = self.processor.as_ref().map(|it| format!(", {it}")).unwrap_or_default();
        format!("{}{about}, {}, {}{processor}", self.name.metric.id(), subject.detector, subject.dataset)
    }
}

/// The groups of comparable runs: each run joins the latest group whose runs it may all be compared with. Not only the last:
/// that may lack a detector that the earlier ones have, judged by other rules.
fn comparable_runs(history: &History, runs: &[(&str, &RunOfHistory)]) -> Vec<Comparable> {
    let mut groups: Vec<Comparable> = Vec::new();
    let settings = |run_idx: usize| history.settings(runs[run_idx].1);
    for run_idx in 0..runs.len() {
        let now = settings(run_idx);
        let differing = |group: &Comparable| {
            let mut known: Vec<&Manifest> = group.runs.iter().rev().map(|it| settings(*it)).collect();
            known.dedup_by(|one, other| std::ptr::eq(*one, *other));
            known.into_iter().map(|it| differences(it, now)).find(|it| !it.is_empty())
        };
        if let Some(group) = groups.iter_mut().rev().find(|it| differing(it).is_none()) {
            group.runs.push(run_idx);
        } else {
            let reasons = groups.last().and_then(differing).unwrap_or_default();
            groups.push(Comparable { runs: vec![run_idx], reasons });
        }
    }
    groups
}

/// Why numbers of two runs may not be compared.
pub(super) fn differences(before: &Manifest, now: &Manifest) -> Vec<String> {
    if std::ptr::eq(before, now) {
        return Vec::new();
    }
    let mut reasons = differences_of_rules_and_data(before, now);
    let mut compare = |what: &str, is_same: bool| {
        if reasons.is_empty() && !is_same {
            reasons.push(format!("{what} changed"));
        }
    };
    compare("the seeds of simulated data", before.seeds == now.seeds);
    for (old, new) in before.datasets.iter().zip(&now.datasets) {
        compare(&format!("the simulation of {}", new.id), old.simulation == new.simulation);
        let scans = |it: &DatasetEntry| (it.n_scans, it.selection.clone());
        compare(&format!("the chosen scans of {}", new.id), scans(old) == scans(new));
    }
    reasons
}
