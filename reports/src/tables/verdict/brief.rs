//! A verdict on a screen: what it comes to, what was judged, and the largest changes.

use crate::files::fixed_decimals::fixed_decimals;
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::verdict::summary::{about_judging, headline, scan_name};
use crate::tables::verdict::wording::{difference_text, value_text};
use crate::verdicts::finding::Finding;
use crate::verdicts::gated_metrics::GatedMetric;
use crate::verdicts::gated_speeds::GatedSpeed;
use crate::verdicts::verdict::Verdict;
use crate::vocabulary::slice::Slice;

/// Changes that are named.
const MOST_CHANGES: usize = 5;

/// The least that is to be said of a verdict.
#[derive(Debug, Clone, Copy)]
pub struct Brief<'a> {
    /// The verdict.
    pub verdict: &'a Verdict,
    /// The directories of the run and of its baseline.
    pub sides: [&'a str; 2],
    /// The command that prints everything.
    pub in_full: &'a str,
}

impl Tabular for Brief<'_> {
    fn sheet(&self) -> Sheet {
        let [run, baseline] = self.sides;
        let verdict = self.verdict;
        let mut lead = vec![headline(verdict)];
        lead.push(format!(
            "Judged: {run} by {baseline}, {} on {} of {}.",
            verdict.detectors.join(", "),
            counted(verdict.n_scans, "scan"),
            verdict.dataset_in_words()
        ));
        lead.extend(about_judging(verdict));
        let sentences = self.changes().into_iter().chain(self.most_changed_scan());
        let sentences = sentences.chain([format!("All of it: {}", self.in_full)]).collect();
        Sheet { lead, ..Sheet::of_parts(Vec::new(), sentences) }
    }
}

impl Brief<'_> {
    /// The largest changes of numbers, below how many there are.
    fn changes(&self) -> Vec<String> {
        let mut changes = changes(self.verdict);
        changes.sort_by(|a, b| a.finding.cmp(&b.finding).then(b.size.total_cmp(&a.size)));
        let head = match changes.len() {
            0 => return Vec::new(),
            n if n <= MOST_CHANGES => "Numbers that changed:".to_owned(),
            n => format!("The {MOST_CHANGES} largest of {n} changes:"),
        };
        let named = changes.into_iter().take(MOST_CHANGES).map(|it| format!("- {}", it.text));
        [head].into_iter().chain(named).collect()
    }

    /// The scan with the most objects whose results changed.
    fn most_changed_scan(&self) -> Option<String> {
        // The first of those that have as many.
        let most = self.verdict.drift.iter().rev().max_by_key(|it| it.changes.len())?;
        let n_objects = counted(most.changes.len(), "object");
        Some(format!("Most results changed on {}: {n_objects}.", scan_name(most)))
    }
}

/// A number that is another one than before, or not there.
struct Change {
    finding: Finding,
    /// In tolerances.
    size: f64,
    text: String,
}

/// All that changed. Times are others in every run: only those of which something is to be said.
fn changes(verdict: &Verdict) -> Vec<Change> {
    let of_metrics = verdict.metrics.iter().filter_map(of_metric);
    let of_speeds = verdict.speed.speeds().iter().filter(|it| it.finding != Finding::Pass);
    of_metrics.chain(of_speeds.filter_map(of_speed)).collect()
}

/// `None` where nothing changed, or a number is missing, which is told elsewhere.
fn of_metric(gated: &GatedMetric) -> Option<Change> {
    let GatedMetric { detector, slice, metric, difference, tolerance, finding, .. } = gated;
    let it = difference.as_ref().ok().filter(|it| it.difference() != 0.0)?;
    let of_slice = if *slice == Slice::All.name() { String::new() } else { format!(" of {slice}") };
    let text = format!(
        "{}{of_slice}, {detector}, {}: {} → {}{}, {}: {}",
        metric.id(),
        gated.about(),
        value_text(metric, it.before),
        value_text(metric, it.after),
        if metric.unit() == "ratio" { " %" } else { "" },
        difference_text(metric, it.difference()),
        in_words(*finding, it.worsening())
    );
    Some(Change { finding: *finding, size: in_tolerances(it.difference(), *tolerance), text })
}

fn of_speed(speed: &GatedSpeed) -> Option<Change> {
    let GatedSpeed { reference, slowdown, tolerance, finding, .. } = speed;
    let it = slowdown.as_ref().ok()?;
    let text = format!(
        "time, {}: {} → {} times {reference}, {} % slower: {}",
        speed.about(),
        fixed_decimals(it.before, 2),
        fixed_decimals(it.after, 2),
        fixed_decimals(100.0 * it.share(), 0),
        finding.in_words()
    );
    Some(Change { finding: *finding, size: in_tolerances(it.share(), *tolerance), text })
}

/// How a change is called: what is not worse than tolerated may be better.
fn in_words(finding: Finding, worsening: f64) -> &'static str {
    match finding {
        Finding::Pass if worsening < 0.0 => "better",
        Finding::Pass => "tolerated",
        Finding::Regression | Finding::Incomparable | Finding::Inconclusive => finding.in_words(),
    }
}

/// So that rates and metres can be compared. Where nothing is tolerated, everything is much.
fn in_tolerances(difference: f64, tolerance: f64) -> f64 {
    difference.abs() / tolerance.max(f64::MIN_POSITIVE)
}

fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}
