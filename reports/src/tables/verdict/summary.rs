//! A verdict for people: its conclusion, and the numbers behind it.

use std::collections::BTreeMap;

use crate::files::fixed_decimals::fixed_decimals;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Listing, Part, Sheet, Tabular};
use crate::tables::verdict::tolerated::about_tolerances;
use crate::tables::verdict::wording::{
    DETECTABLE, about_configuration, about_differences, change_in_words, difference_text, interval_cell,
    least_effect_text, metric_text, tolerance_text, value_text,
};
use crate::verdicts::change::{Change, ChangeKind, in_words, n_of_kinds};
use crate::verdicts::changed_claims::ChangedClaim;
use crate::verdicts::drift::ScanDrift;
use crate::verdicts::finding::Finding;
use crate::verdicts::gated_metrics::{GatedMetric, about};
use crate::verdicts::tolerances::{DriftRule, Origin};
use crate::verdicts::verdict::{Conclusion, Verdict};
use crate::vocabulary::metric::{Metric, SPEED_REFERENCE};
use crate::vocabulary::slice::Slice;

/// Columns of a grid of metrics that name their subjects: task and detector.
const N_TITLE_COLUMNS: usize = 2;
/// Missing numbers that are named where a few lines have to do.
const MOST_MISSING: usize = 2;

impl Tabular for Verdict {
    /// The conclusion, the numbers with something to say, and every object that changed.
    fn sheet(&self) -> Sheet {
        let shown: Vec<&GatedMetric> = self.metrics.iter().filter(|it| is_shown(it)).collect();
        let of_metrics = (!shown.is_empty()).then(|| metric_grid(&shown, self));
        sheet(self, of_metrics.into_iter().map(|grid| Part { title: None, grid }).collect())
    }
}

/// A verdict for a narrow screen: a table for each task and detector.
#[derive(Debug, Clone, Copy)]
pub struct InFull<'a>(pub &'a Verdict);

impl Tabular for InFull<'_> {
    fn sheet(&self) -> Sheet {
        let shown: Vec<&GatedMetric> = self.0.metrics.iter().filter(|it| is_shown(it)).collect();
        let of_detectors = shown.chunk_by(|a, b| (a.about(), &a.detector) == (b.about(), &b.detector));
        let parts = of_detectors.map(|of_detector| {
            let grid = metric_grid(of_detector, self.0);
            let columns: Vec<usize> = (N_TITLE_COLUMNS..grid.columns.len()).collect();
            let title = format!("{}, {}", of_detector[0].about(), of_detector[0].detector);
            Part { title: Some(title), grid: grid.with_columns(&columns) }
        });
        sheet(self.0, parts.collect())
    }
}

/// The first lines, the numbers, the times, and every object that changed.
fn sheet(verdict: &Verdict, of_metrics: Vec<Part>) -> Sheet {
    let of_speeds = (!verdict.speeds.is_empty()).then(|| speed_grid(verdict));
    let of_speeds = of_speeds.map(|grid| Part { title: None, grid });
    let parts = of_metrics.into_iter().chain(of_speeds).collect();
    let listing = Listing { entries: changes_of_kinds(&verdict.drift), in_full: "gate.json lists all" };
    Sheet {
        lead: first_lines(verdict),
        listing: (!verdict.drift.is_empty()).then_some(listing),
        ..Sheet::of_parts(parts, sentences(verdict))
    }
}

/// All changes of each kind, below how many there are: the worst kind first, and in each that of the largest object.
fn changes_of_kinds(drift: &[ScanDrift]) -> Vec<(String, Vec<String>)> {
    let mut of_kinds: BTreeMap<ChangeKind, Vec<(&ScanDrift, &Change)>> = BTreeMap::new();
    for of_scan in drift {
        for it in &of_scan.changes {
            of_kinds.entry(it.kind).or_default().push((of_scan, it));
        }
    }
    let counts = n_of_kinds(drift.iter().flat_map(|it| &it.changes));
    let entry = |(kind, mut changes): (ChangeKind, Vec<(&ScanDrift, &Change)>)| {
        // Stable: an object stays behind another with as many points.
        changes.sort_by_key(|(_, it)| std::cmp::Reverse(it.n_points));
        let item =
            |(of_scan, it): (&ScanDrift, &Change)| format!("{}: {}", of_scan.subject.in_words(), it.text);
        // Of changes that are not shown, only the number is said.
        let n_named = if kind == ChangeKind::NotShown { 0 } else { changes.len() };
        (kind.counted(counts[&kind]), changes.into_iter().take(n_named).map(item).collect())
    };
    of_kinds.into_iter().map(entry).collect()
}

/// The conclusion, and all that could not be judged.
fn first_lines(verdict: &Verdict) -> Vec<String> {
    let mut lines = vec![headline(verdict), counts(verdict)];
    lines.extend(missing(verdict));
    lines.extend(caveats(verdict));
    if verdict.tolerances.origin == Origin::BuiltIn {
        lines.push(about_tolerances(&verdict.tolerances));
    }
    lines
}

/// The numbers that were judged, the tolerances, and all that could not be judged: a few lines, however much that is.
pub(crate) fn about_judging(verdict: &Verdict) -> Vec<String> {
    let mut missing = missing(verdict);
    if missing.len() > MOST_MISSING {
        let n_more = missing.len() - MOST_MISSING;
        missing.truncate(MOST_MISSING);
        missing.push(format!("And {n_more} more numbers are missing."));
    }
    let tolerances = about_tolerances(&verdict.tolerances);
    [counts(verdict)].into_iter().chain(missing).chain(caveats(verdict)).chain([tolerances]).collect()
}

/// Claims that changed, and what could not be judged although no number is missing.
fn caveats(verdict: &Verdict) -> Vec<String> {
    let mut lines: Vec<String> = verdict.claims.iter().map(ChangedClaim::in_words).collect();
    lines.extend(verdict.since.iter().flat_map(|it| it.lines.iter().cloned()));
    lines.extend(verdict.doubts.iter().cloned());
    lines.extend(about_configuration(&verdict.configuration_changes));
    lines.extend(verdict.speed_not_compared.as_ref().map(|it| format!("Speed was not compared: {it}.")));
    if !verdict.new_detectors.is_empty() {
        let names = verdict.new_detectors.join(", ");
        lines.push(format!("Not judged, because only the later run has it: {names}."));
    }
    if verdict.blocks.decide_nothing() {
        lines.push(about_few_blocks(verdict));
    }
    if verdict.n_at_risk() > 0 {
        lines.push(format!(
            "{} numbers changed; of these up to {} are called worse by chance, on average.",
            verdict.n_at_risk(),
            fixed_decimals(verdict.most_false_alarms(), 1)
        ));
    }
    lines
}

/// The numbers that are missing, each with all that names it.
fn missing(verdict: &Verdict) -> Vec<String> {
    let dataset = verdict.dataset_in_words();
    let missing = verdict.numbers().filter_map(|it| {
        let why = it.difference.as_ref().err()?.in_words();
        let GatedMetric { on, task, detector, slice, metric, .. } = it;
        let dataset = on.as_deref().unwrap_or(dataset);
        Some(if metric.is_time() {
            format!("Time relative to {SPEED_REFERENCE}, {detector}, {dataset}: {why}.")
        } else {
            format!("{} of {slice}, {detector}, {task}, {dataset}: {why}.", metric.id())
        })
    });
    missing.collect()
}

/// The conclusion, as short as can be.
pub(crate) fn headline(verdict: &Verdict) -> String {
    let conclusion = verdict.conclusion();
    let words = conclusion.in_words();
    let words = match conclusion {
        Conclusion::AllowedDrift => format!("{words} on {} (allowed)", changed_scans(verdict)),
        _ => words.to_owned(),
    };
    format!("{words}{}", not_judged(verdict).unwrap_or_default())
}

/// What a verdict that nothing is surely worse leaves open; `None` if that is nothing.
fn not_judged(verdict: &Verdict) -> Option<String> {
    let conclusion = verdict.conclusion();
    let n_inconclusive = verdict.n(Finding::Inconclusive);
    let doubt = doubt(verdict).filter(|_| verdict.blocks.decide_nothing());
    match (conclusion, doubt) {
        (Conclusion::AllowedDrift | Conclusion::Drift, Some(doubt)) => {
            Some(format!("; no number is judged: {doubt}"))
        }
        (Conclusion::Same, Some(doubt)) if n_inconclusive > 0 => {
            Some(format!("; {n_inconclusive} slower than tolerated, not judged: {doubt}"))
        }
        (Conclusion::Same | Conclusion::AllowedDrift, None) if n_inconclusive > 0 => {
            Some(format!("; {n_inconclusive} inconclusive"))
        }
        _ => None,
    }
}

fn changed_scans(verdict: &Verdict) -> String {
    match verdict.n_changed_scans() {
        1 => format!("1 {}", verdict.unit),
        n => format!("{n} {}s", verdict.unit),
    }
}

/// Number of judged numbers, and their findings.
pub(crate) fn counts(verdict: &Verdict) -> String {
    let n_gated = verdict.numbers().count();
    let about_results = if verdict.drift.is_empty() {
        "No result changed.".to_owned()
    } else {
        format!("Results changed on {}: {}.", changed_scans(verdict), in_words(&verdict.n_changes()))
    };
    format!(
        "{n_gated} number{}: {} worse, {} inconclusive, {} missing. {about_results}",
        if n_gated == 1 { "" } else { "s" },
        verdict.n(Finding::Regression),
        verdict.n(Finding::Inconclusive),
        verdict.n(Finding::Incomparable)
    )
}

fn about_few_blocks(verdict: &Verdict) -> String {
    let why = if verdict.blocks.may_be_neighbours() {
        "These scans may be neighbours, because their times are not known: nothing can be shown to be worse."
            .to_owned()
    } else {
        format!("Only {}: too few to show that anything is worse.", verdict.blocks.counted())
    };
    match verdict.tolerances.drift {
        DriftRule::Fail => format!("{why} Only changed results can fail."),
        DriftRule::Warn => why,
    }
}

/// Why nothing is sure, in a word or two; `None` if something may be.
pub(crate) fn doubt(verdict: &Verdict) -> Option<String> {
    if verdict.blocks.may_be_neighbours() {
        return Some("scans may be neighbours".to_owned());
    }
    let counted = verdict.blocks.counted();
    verdict.blocks.are_too_few().then(|| counted.trim_end_matches(" of scans").to_owned())
}

/// A finding; where it is inconclusive, with the reason.
fn finding_text(finding: Finding, verdict: &Verdict) -> String {
    match doubt(verdict) {
        Some(doubt) if finding == Finding::Inconclusive => format!("{}: {doubt}", finding.in_words()),
        _ => finding.in_words().to_owned(),
    }
}

/// Whether a number is shown. There are many: but for the F-rates only those with something to say are.
fn is_shown(gated: &GatedMetric) -> bool {
    let is_changed = gated.difference.as_ref().is_ok_and(|it| it.difference() != 0.0);
    let is_headline = gated.metric == Metric::FRate || is_changed;
    let is_gain = gated.difference.as_ref().is_ok_and(|it| -it.worsening() > gated.tolerance);
    gated.finding != Finding::Pass || is_gain || (gated.slice == Slice::All.name() && is_headline)
}

fn sentences(verdict: &Verdict) -> Vec<String> {
    let n_hidden = verdict.metrics.iter().filter(|it| !is_shown(it)).count();
    let mut sentences = vec![about_differences("after − before", verdict.blocks.kind)];
    sentences.push(
        "worse: the whole interval is worse than tolerated. inconclusive: the difference is worse than tolerated, but \
         not its whole interval."
            .to_owned(),
    );
    if n_hidden > 0 {
        sentences.push(format!("{n_hidden} more numbers passed; they are unchanged, or of slices that changed less than tolerated."));
    }
    if !verdict.speeds.is_empty() {
        sentences.push(format!(
            "time: time of a detector divided by that of {SPEED_REFERENCE}, a simple grid that serves as the reference, on the same \
             scan; shortest of all repetitions, geometric mean over scans."
        ));
    }
    sentences
}

fn metric_grid(shown: &[&GatedMetric], verdict: &Verdict) -> Grid {
    let left = ["task", "detector", "slice", "metric"].map(Column::left);
    let numbers = ["before", "after", "difference", "95 %", DETECTABLE, "tolerated"];
    let numbers = numbers.map(Column::number);
    let columns = left.into_iter().chain(numbers).chain([Column::left("finding")]);
    let lines = shown.iter().map(|gated| {
        let metric = &gated.metric;
        let numbers = match &gated.difference {
            Ok(it) => [
                Cell::new(value_text(metric, it.before)),
                Cell::new(value_text(metric, it.after)),
                Cell::new(difference_text(metric, it.difference())),
                interval_cell(it),
                Cell::new(least_effect_text(it)),
            ],
            Err(_) => ["–"; 5].map(Cell::new),
        };
        let tolerance = tolerance_text(metric, gated.tolerance);
        let names = [gated.about(), gated.detector.clone(), gated.slice.clone(), metric_text(metric)];
        let finding = match &gated.difference {
            Ok(it) if gated.finding == Finding::Pass && it.worsening() < 0.0 => {
                change_in_words(gated.finding, it).to_owned()
            }
            _ => finding_text(gated.finding, verdict),
        };
        let last = [tolerance, finding];
        let cells = names.map(Cell::new).into_iter().chain(numbers).chain(last.map(Cell::new));
        Line { kind: LineKind::Dataset, cells: cells.collect() }
    });
    Grid { columns: columns.collect(), lines: lines.collect() }
}

fn speed_grid(verdict: &Verdict) -> Grid {
    let left = ["detector", "time relative to"].map(Column::left);
    let numbers = ["before", "after", "slower by [%]", "95 %", "tolerated"];
    let numbers = numbers.map(Column::number);
    let columns = left.into_iter().chain(numbers).chain([Column::left("finding")]);
    let percent = |share: f64| fixed_decimals(100.0 * share, 1);
    let lines = verdict.speeds.iter().map(|speed| {
        let numbers = match &speed.difference {
            Ok(it) => [
                Cell::new(fixed_decimals(it.before, 3)),
                Cell::new(fixed_decimals(it.after, 3)),
                Cell::new(percent(it.difference())),
                it.interval.map_or_else(
                    || Cell::new("–"),
                    |it| Cell::interval(it.ends.map(percent).join(" to "), it.blocks),
                ),
            ],
            Err(_) => ["–"; 4].map(Cell::new),
        };
        let names = [about(&speed.detector, speed.on.as_deref()), SPEED_REFERENCE.to_owned()].map(Cell::new);
        let last = [percent(speed.tolerance), finding_text(speed.finding, verdict)].map(Cell::new);
        Line { kind: LineKind::Dataset, cells: names.into_iter().chain(numbers).chain(last).collect() }
    });
    Grid { columns: columns.collect(), lines: lines.collect() }
}
