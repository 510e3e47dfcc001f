//! A verdict on one screen: the conclusion, what was judged, and the largest changes.

use crate::files::fixed_decimals::fixed_decimals;
use crate::run_folder::command_line::shell_word;
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::verdict::summary::{about_judging, headline};
use crate::tables::verdict::wording::{
    change_in_words, difference_text, interval_text, tolerance_text, value_text,
};
use crate::verdicts::change::{ChangeKind, n_of_kinds};
use crate::verdicts::drift::{ScanDrift, ScanSubject};
use crate::verdicts::finding::Finding;
use crate::verdicts::gated_metrics::{GatedMetric, about};
use crate::verdicts::paired_difference::PairedDifference;
use crate::verdicts::verdict::Verdict;
use crate::vocabulary::metric::SPEED_REFERENCE;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::study::Study;
use crate::worst::mistakes::scan_address;

/// Losses that are named.
const MOST_LOSSES: usize = 5;
/// Gains that are named.
const MOST_GAINS: usize = 3;

/// A verdict in few lines.
#[derive(Debug, Clone, Copy)]
pub struct Brief<'a> {
    /// The verdict.
    pub verdict: &'a Verdict,
    /// The directories of the run and of its baseline.
    pub sides: [&'a str; 2],
    /// Its purpose.
    pub purpose: Purpose<'a>,
}

/// The purpose of a verdict.
#[derive(Debug, Clone, Copy)]
pub enum Purpose<'a> {
    /// To let a run pass or not.
    Gate {
        /// The command that prints everything.
        in_full: &'a str,
    },
    /// To know what is accepted: a run is accepted because its results changed.
    Accept,
}

impl Tabular for Brief<'_> {
    fn sheet(&self) -> Sheet {
        let [run, baseline] = self.sides;
        let verdict = self.verdict;
        let mut lead = match self.purpose {
            Purpose::Gate { .. } => vec![headline(verdict)],
            Purpose::Accept => Vec::new(),
        };
        lead.push(format!(
            "Judged: {run} against {baseline}, {} on {} of {}.",
            verdict.detectors.join(", "),
            counted(verdict.n_scans, verdict.unit),
            verdict.dataset_in_words()
        ));
        lead.extend(about_judging(verdict));
        let sentences = self.changes().into_iter().chain(self.most_changed_scan());
        let in_full = match self.purpose {
            Purpose::Gate { in_full } => Some(format!("In full: {in_full}")),
            Purpose::Accept => None,
        };
        let sentences = sentences.chain(in_full).collect();
        Sheet { lead, ..Sheet::of_parts(Vec::new(), sentences) }
    }
}

impl Brief<'_> {
    /// The largest losses and the largest gains, each below how many there are.
    fn changes(&self) -> Vec<String> {
        let mut changes = changes(self.verdict);
        changes.sort_by(|a, b| a.finding.cmp(&b.finding).then(b.size.total_cmp(&a.size)));
        let (losses, gains): (Vec<Change>, Vec<Change>) = changes.into_iter().partition(|it| it.is_loss);
        [named(("losses", MOST_LOSSES), losses), named(("gains", MOST_GAINS), gains)].concat()
    }

    /// The scan with the most objects lost and the command that shows them; where none was, the scan with the most objects whose
    /// results changed.
    fn most_changed_scan(&self) -> Option<String> {
        let count = |it: &ScanDrift| {
            let counts = n_of_kinds(it.changes.iter());
            let n_lost = counts.get(&ChangeKind::Lost).copied().unwrap_or(0);
            (n_lost, counts.values().sum::<usize>())
        };
        // The first among equals.
        let most = self.verdict.drift.iter().rev().max_by_key(|it| count(it))?;
        let ScanSubject { dataset, sequence, scan, task, detector } = &most.subject;
        let words = most.subject.in_words();
        Some(match count(most) {
            (0, n) => format!("Most results changed on {words}: {}.", counted(n, "object")),
            (n_lost, _) if task == Study::Partial.name() => {
                format!("Most objects lost on {words}: {n_lost}.")
            }
            (n_lost, _) => {
                let at = scan_address(dataset, sequence, *scan);
                let [run, baseline] = self.sides;
                let [run, baseline, at, detector] = [run, baseline, &at, detector].map(shell_word);
                format!(
                    "Most objects lost ({n_lost}): scanbench view {baseline} {run} --at {at} -d {detector} --task {task}"
                )
            }
        })
    }
}

/// The first `most` of `changes`, below how many there are.
fn named((what, most): (&str, usize), changes: Vec<Change>) -> Vec<String> {
    let head = match changes.len() {
        0 => return Vec::new(),
        n if n <= most => format!("All {what}:"),
        n => format!("The {most} largest of {n} {what}, in tolerances:"),
    };
    let named = changes.into_iter().take(most).map(|it| format!("- {}", it.text));
    [head].into_iter().chain(named).collect()
}

/// A number that changed.
struct Change {
    finding: Finding,
    is_loss: bool,
    /// In tolerances.
    size: f64,
    text: String,
}

/// All numbers that changed. Times change in every run: only those beyond their tolerance are listed. Missing numbers are
/// reported elsewhere.
fn changes(verdict: &Verdict) -> Vec<Change> {
    let of_number = |gated: &GatedMetric| {
        let it = gated.difference.as_ref().ok()?;
        let (difference, is_time) = (it.difference(), gated.metric.is_time());
        let is_change = if is_time { difference.abs() > gated.tolerance } else { difference != 0.0 };
        let text = if is_time { text_of_time(gated, it) } else { text_of_metric(gated, it) };
        let size = in_tolerances(difference, gated.tolerance);
        is_change.then_some(Change { finding: gated.finding, is_loss: it.worsening() >= 0.0, size, text })
    };
    verdict.numbers().filter_map(of_number).collect()
}

fn text_of_metric(gated: &GatedMetric, it: &PairedDifference) -> String {
    let GatedMetric { detector, slice, metric, tolerance, finding, .. } = gated;
    let of_slice = if *slice == Slice::All.name() { String::new() } else { format!(" of {slice}") };
    format!(
        "{}{of_slice}, {detector}, {}: {} → {}{}, {} ({}tolerated {}): {}",
        metric.id(),
        gated.about(),
        value_text(metric, it.before),
        value_text(metric, it.after),
        if metric.unit() == "ratio" { " %" } else { "" },
        difference_text(metric, it.difference()),
        it.interval.map_or_else(String::new, |_| format!("95 % {}, ", interval_text(it))),
        tolerance_text(metric, *tolerance),
        change_in_words(*finding, it)
    )
}

fn text_of_time(gated: &GatedMetric, it: &PairedDifference) -> String {
    let share = it.difference();
    let is_slower = share > 0.0;
    let percent = |share: f64| fixed_decimals(100.0 * share, 0).replace('-', "−");
    let within = |[low, high]: [f64; 2]| {
        let ends = if is_slower { [low, high] } else { [-high, -low] };
        format!("95 % {} %, ", ends.map(percent).join(" to "))
    };
    format!(
        "time, {}: {} → {} times {SPEED_REFERENCE}, {} % {} ({}tolerated {} %): {}",
        about(&gated.detector, gated.on.as_deref()),
        fixed_decimals(it.before, 2),
        fixed_decimals(it.after, 2),
        percent(share.abs()),
        if is_slower { "slower" } else { "faster" },
        it.interval.map_or_else(String::new, |it| within(it.ends)),
        percent(gated.tolerance),
        change_in_words(gated.finding, it)
    )
}

/// A difference in tolerances, to compare rates with metres. Where nothing is tolerated, every difference is large.
fn in_tolerances(difference: f64, tolerance: f64) -> f64 {
    difference.abs() / tolerance.max(f64::MIN_POSITIVE)
}

fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}
