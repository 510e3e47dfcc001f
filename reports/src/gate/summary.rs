//! A verdict for a terminal, for pull requests and for the summary of a job.

use std::fmt::Write as _;

use crate::fixed_decimals::fixed_decimals;
use crate::gate::drift::ScanDrift;
use crate::gate::finding::Finding;
use crate::gate::gated_metrics::GatedMetric;
use crate::gate::gated_speeds::{GatedSpeed, SpeedComparison};
use crate::gate::verdict::{Conclusion, Verdict};
use crate::gate::wording::{
    about_differences, difference_text, interval_cell, least_effect_text, metric_text, value_text,
};
use crate::metric::Metric;
use crate::run_report::{OVERALL, SLICE_ALL};
use crate::table::grid::{Alignment, Cell, Column, Grid, Line, LineKind};
use crate::table::notes::Notes;
use crate::table::{markdown, terminal};

/// Scans, and objects of each, that the Markdown lists; a job's summary may not be long.
const MOST_LISTED: usize = 20;

/// The verdict for a terminal, with every object that changed.
pub fn to_terminal(verdict: &Verdict) -> String {
    // Each on a line of its own, however long, for those who search in it.
    let mut text = first_lines(verdict).join("\n") + "\n\n";
    let (grids, notes) = grids_and_notes(verdict);
    for grid in &grids {
        terminal::write_grid(&mut text, grid, &notes);
        text.push('\n');
    }
    for drift in &verdict.drift {
        writeln!(text, "{}", scan_name(drift)).expect("a string takes all that is written");
        for change in &drift.changes {
            writeln!(text, "  {change}").expect("a string takes all that is written");
        }
    }
    if !verdict.drift.is_empty() {
        text.push('\n');
    }
    for sentence in &notes.sentences {
        text.push_str(&terminal::wrapped(sentence));
    }
    text
}

/// The verdict as Markdown, with the first of the objects that changed.
pub fn to_markdown(verdict: &Verdict) -> String {
    let lines = first_lines(verdict);
    let (headline, more) = lines.split_first().expect("there is a headline");
    let mut text = format!("**{}**\n\n", markdown::escaped(headline));
    for line in more {
        markdown::push_line(&mut text, &format!("{}\n", markdown::escaped(line)));
    }
    let (grids, notes) = grids_and_notes(verdict);
    for grid in &grids {
        markdown::write_grid(&mut text, grid, &notes);
        text.push('\n');
    }
    for drift in verdict.drift.iter().take(MOST_LISTED) {
        markdown::push_line(&mut text, &format!("- {}", markdown::escaped(&scan_name(drift))));
        for change in drift.changes.iter().take(MOST_LISTED) {
            markdown::push_line(&mut text, &format!("  - {}", markdown::escaped(change)));
        }
        if drift.changes.len() > MOST_LISTED {
            let n_more = drift.changes.len() - MOST_LISTED;
            markdown::push_line(&mut text, &format!("  - and {n_more} more"));
        }
    }
    if verdict.drift.len() > MOST_LISTED {
        let n_more = verdict.drift.len() - MOST_LISTED;
        markdown::push_line(&mut text, &format!("- and {n_more} more; gate.json lists all"));
    }
    if !verdict.drift.is_empty() {
        text.push('\n');
    }
    for sentence in &notes.sentences {
        markdown::push_line(&mut text, &format!("- {}", markdown::escaped(sentence)));
    }
    text
}

/// What it comes to, and what could not be judged.
fn first_lines(verdict: &Verdict) -> Vec<String> {
    let mut lines = vec![headline(verdict)];
    lines.extend(missing(verdict));
    match &verdict.speed {
        SpeedComparison::NotCompared { reason } => lines.push(format!("Speed was not compared: {reason}.")),
        SpeedComparison::NotAsked | SpeedComparison::Compared(_) => {}
    }
    if verdict.blocks.are_too_few() {
        lines.push(format!(
            "{}: too few to show a regression. The gate can only fail because results changed.",
            few_blocks(verdict)
        ));
    }
    lines
}

/// The numbers that are missing, each with all that names it.
fn missing(verdict: &Verdict) -> Vec<String> {
    let dataset = match verdict.dataset.as_str() {
        OVERALL => "all data sets together",
        id => id,
    };
    let of_metrics = verdict.metrics.iter().filter_map(|it| {
        let place = it.difference.as_ref().err()?.in_words();
        let GatedMetric { task, detector, slice, metric, .. } = it;
        Some(format!("{} of {slice}, {detector}, {task}, {dataset}: {place}.", metric.id()))
    });
    let of_speeds = verdict.speed.speeds().iter().filter_map(|it| {
        let place = it.slowdown.as_ref().err()?.in_words();
        Some(format!("Time relative to {}, {}, {dataset}: {place}.", it.reference, it.detector))
    });
    of_metrics.chain(of_speeds).collect()
}

fn few_blocks(verdict: &Verdict) -> String {
    match verdict.blocks.n_blocks {
        1 => "Only 1 block of scans".to_owned(),
        n => format!("Only {n} blocks of scans"),
    }
}

fn headline(verdict: &Verdict) -> String {
    let conclusion = match verdict.conclusion() {
        Conclusion::Regression => "FAILED: regression",
        Conclusion::Incomparable => "FAILED: numbers are missing",
        Conclusion::Drift => "FAILED: results changed",
        Conclusion::Same => "PASSED",
    };
    let n_gated = verdict.metrics.len() + verdict.speed.speeds().len();
    format!(
        "{conclusion}. Checked numbers: {n_gated}, regressions: {}, inconclusive: {}, missing: {}. Changed scan results: {}.",
        verdict.n(Finding::Regression),
        verdict.n(Finding::Inconclusive),
        verdict.n(Finding::Incomparable),
        verdict.drift.len()
    )
}

/// Which scan, detector and task a drift is about.
pub(super) fn scan_name(drift: &ScanDrift) -> String {
    let place = &drift.place;
    format!("{} {}/{:06}, {}, {}", place.dataset, place.sequence, place.scan, place.detector, place.task)
}

fn grids_and_notes(verdict: &Verdict) -> (Vec<Grid>, Notes) {
    let shown: Vec<&GatedMetric> = verdict.metrics.iter().filter(|it| is_shown(it)).collect();
    let mut grids = Vec::new();
    if !shown.is_empty() {
        grids.push(metric_grid(&shown, verdict));
    }
    if !verdict.speed.speeds().is_empty() {
        grids.push(speed_grid(verdict));
    }
    let notes = Notes::beneath(&grids, sentences(verdict));
    (grids, notes)
}

/// A finding, with why it is none.
fn finding_text(finding: Finding, verdict: &Verdict) -> String {
    match finding {
        Finding::Inconclusive if verdict.blocks.are_too_few() => {
            format!("{}: {}", finding.name(), few_blocks(verdict).replacen('O', "o", 1))
        }
        _ => finding.name().to_owned(),
    }
}

/// Numbers are many: but for the F-rates those are shown of which something is to be said.
fn is_shown(gated: &GatedMetric) -> bool {
    let is_changed = gated.difference.as_ref().is_ok_and(|it| it.difference() != 0.0);
    let is_headline = gated.metric == Metric::FRate || is_changed;
    gated.finding != Finding::Pass || (gated.slice == SLICE_ALL && is_headline)
}

fn sentences(verdict: &Verdict) -> Vec<String> {
    let n_hidden = verdict.metrics.iter().filter(|it| !is_shown(it)).count();
    let mut sentences = vec![about_differences(verdict.blocks.kind)];
    sentences.push(
        "regression: the whole interval is worse than tolerated. inconclusive: the difference is worse than tolerated, but \
         not its whole interval."
            .to_owned(),
    );
    if n_hidden > 0 {
        sentences.push(format!("{n_hidden} more numbers passed; they are unchanged, or of slices."));
    }
    if let Some(speed) = verdict.speed.speeds().first() {
        sentences.push(format!(
            "time: time of a detector divided by that of {}, a simple grid that serves as the reference, on the same scan; shortest \
             of all repetitions, geometric mean over scans.",
            speed.reference
        ));
    }
    sentences
}

fn column(title: &'static str, alignment: Alignment) -> Column {
    Column { group: None, title, alignment }
}

fn metric_grid(shown: &[&GatedMetric], verdict: &Verdict) -> Grid {
    let left = ["task", "detector", "slice", "metric"].map(|title| column(title, Alignment::Left));
    let numbers = ["before", "after", "difference", "95 %", "least", "tolerated"];
    let numbers = numbers.map(|title| column(title, Alignment::Decimal));
    let columns = left.into_iter().chain(numbers).chain([column("finding", Alignment::Left)]);
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
        let tolerance = difference_text(metric, gated.tolerance).trim_start_matches('+').to_owned();
        let names = [gated.task.clone(), gated.detector.clone(), gated.slice.clone(), metric_text(metric)];
        let last = [tolerance, finding_text(gated.finding, verdict)];
        let cells = names.map(Cell::new).into_iter().chain(numbers).chain(last.map(Cell::new));
        Line { kind: LineKind::Dataset, cells: cells.collect() }
    });
    Grid { columns: columns.collect(), lines: lines.collect() }
}

fn speed_grid(verdict: &Verdict) -> Grid {
    let left = ["detector", "time relative to"].map(|title| column(title, Alignment::Left));
    let numbers = ["before", "after", "slower by [%]", "95 %", "tolerated"];
    let numbers = numbers.map(|title| column(title, Alignment::Decimal));
    let columns = left.into_iter().chain(numbers).chain([column("finding", Alignment::Left)]);
    let percent = |share: f64| fixed_decimals(100.0 * share, 1);
    let lines = verdict.speed.speeds().iter().map(|speed| {
        let GatedSpeed { detector, reference, slowdown, tolerance, finding } = speed;
        let numbers = match slowdown {
            Ok(it) => [
                Cell::new(fixed_decimals(it.before, 3)),
                Cell::new(fixed_decimals(it.after, 3)),
                Cell::new(percent(it.share())),
                it.interval.map_or_else(
                    || Cell::new("–"),
                    |it| Cell::interval(it.ends.map(percent).join(" to "), it.blocks),
                ),
            ],
            Err(_) => ["–"; 4].map(Cell::new),
        };
        let names = [detector, reference].map(|it| Cell::new(it.clone()));
        let last = [percent(*tolerance), finding_text(*finding, verdict)].map(Cell::new);
        Line { kind: LineKind::Dataset, cells: names.into_iter().chain(numbers).chain(last).collect() }
    });
    Grid { columns: columns.collect(), lines: lines.collect() }
}
