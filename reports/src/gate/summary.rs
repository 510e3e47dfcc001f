//! A verdict for a terminal, for pull requests and for the summary of a job.

use std::fmt::Write as _;

use crate::fixed_decimals::fixed_decimals;
use crate::gate::drift::ScanDrift;
use crate::gate::verdict::{Conclusion, Finding, GatedMetric, GatedSpeed, Verdict};
use crate::gate::wording::{
    ABOUT_DIFFERENCES, difference_text, interval_text, least_effect_text, metric_text, value_text,
};
use crate::metric::Metric;
use crate::run_report::SLICE_ALL;
use crate::table::grid::{Alignment, Cell, Column, Grid, Line, LineKind};
use crate::table::notes::Notes;
use crate::table::{markdown, terminal};

/// Scans, and objects of each, that the Markdown lists; a job's summary may not be long.
const MOST_LISTED: usize = 20;

/// The verdict for a terminal, with every object that changed.
pub fn to_terminal(verdict: &Verdict) -> String {
    let mut text = format!("{}\n\n", headline(verdict));
    for grid in grids(verdict) {
        terminal::write_grid(&mut text, &grid, &Notes::none());
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
    for sentence in sentences(verdict) {
        text.push_str(&terminal::wrapped(&sentence));
    }
    text
}

/// The verdict as Markdown, with the first of the objects that changed.
pub fn to_markdown(verdict: &Verdict) -> String {
    let mut text = format!("**{}**\n\n", markdown::escaped(&headline(verdict)));
    for grid in grids(verdict) {
        markdown::write_grid(&mut text, &grid, &Notes::none());
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
        markdown::push_line(&mut text, &format!("- and {n_more} more; gate.json has them all"));
    }
    if !verdict.drift.is_empty() {
        text.push('\n');
    }
    for sentence in sentences(verdict) {
        markdown::push_line(&mut text, &format!("- {}", markdown::escaped(&sentence)));
    }
    text
}

fn headline(verdict: &Verdict) -> String {
    let conclusion = match verdict.conclusion() {
        Conclusion::Regression => "regression",
        Conclusion::Incomparable => "not comparable, a number is missing",
        Conclusion::Drift => "nothing is surely worse, but scans are judged otherwise",
        Conclusion::Same => "as accepted",
    };
    let n_gated = verdict.metrics.len() + verdict.speeds.len();
    format!(
        "Gate: {conclusion}. Of {n_gated} numbers {} surely worse, {} perhaps, {} missing. {} scans judged otherwise.",
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

fn grids(verdict: &Verdict) -> Vec<Grid> {
    let shown: Vec<&GatedMetric> = verdict.metrics.iter().filter(|it| is_shown(it)).collect();
    let mut grids = Vec::new();
    if !shown.is_empty() {
        grids.push(metric_grid(&shown));
    }
    if !verdict.speeds.is_empty() {
        grids.push(speed_grid(&verdict.speeds));
    }
    grids
}

/// Numbers are many: but for the F-rates those are shown of which something is to be said.
fn is_shown(gated: &GatedMetric) -> bool {
    let is_changed = gated.difference.as_ref().is_none_or(|it| it.difference() != 0.0);
    let is_headline = gated.metric == Metric::FRate || is_changed;
    gated.finding != Finding::Pass || (gated.slice == SLICE_ALL && is_headline)
}

fn sentences(verdict: &Verdict) -> Vec<String> {
    let n_hidden = verdict.metrics.iter().filter(|it| !is_shown(it)).count();
    let mut sentences = vec![ABOUT_DIFFERENCES.to_owned()];
    sentences.push(
        "regression: the whole interval is worse than tolerated. inconclusive: the difference is, but not all of its \
         interval."
            .to_owned(),
    );
    if n_hidden > 0 {
        sentences.push(format!("{n_hidden} more numbers, unchanged or of slices, pass."));
    }
    if let Some(speed) = verdict.speeds.first() {
        sentences.push(format!(
            "time: geometric mean over scans of a detector's time divided by that of {} on the same scan.",
            speed.reference
        ));
    }
    sentences
}

fn column(title: &'static str, alignment: Alignment) -> Column {
    Column { group: None, title, alignment }
}

fn metric_grid(shown: &[&GatedMetric]) -> Grid {
    let left = ["task", "detector", "slice", "metric"].map(|title| column(title, Alignment::Left));
    let numbers = ["before", "after", "difference", "95 %", "least", "tolerated"];
    let numbers = numbers.map(|title| column(title, Alignment::Decimal));
    let columns = left.into_iter().chain(numbers).chain([column("finding", Alignment::Left)]);
    let lines = shown.iter().map(|gated| {
        let metric = &gated.metric;
        let numbers = match &gated.difference {
            Some(it) => [
                value_text(metric, it.before),
                value_text(metric, it.after),
                difference_text(metric, it.difference()),
                interval_text(it),
                least_effect_text(it),
            ],
            None => ["–"; 5].map(str::to_owned),
        };
        let tolerance = difference_text(metric, gated.tolerance).trim_start_matches('+').to_owned();
        let names = [gated.task.clone(), gated.detector.clone(), gated.slice.clone(), metric_text(metric)];
        let texts = names.into_iter().chain(numbers).chain([tolerance, gated.finding.name().to_owned()]);
        line(texts)
    });
    Grid { columns: columns.collect(), lines: lines.collect() }
}

fn speed_grid(speeds: &[GatedSpeed]) -> Grid {
    let left = ["detector", "time over that of"].map(|title| column(title, Alignment::Left));
    let numbers = ["before", "after", "slower by [%]", "95 %", "tolerated"];
    let numbers = numbers.map(|title| column(title, Alignment::Decimal));
    let columns = left.into_iter().chain(numbers).chain([column("finding", Alignment::Left)]);
    let percent = |share: f64| fixed_decimals(100.0 * share, 1);
    let lines = speeds.iter().map(|speed| {
        let interval = speed.slowdown_interval.map(|it| it.ends.map(percent).join(" to "));
        line([
            speed.detector.clone(),
            speed.reference.clone(),
            fixed_decimals(speed.before, 4),
            fixed_decimals(speed.after, 4),
            percent(speed.after / speed.before - 1.0),
            interval.unwrap_or_else(|| "–".to_owned()),
            percent(speed.tolerance),
            speed.finding.name().to_owned(),
        ])
    });
    Grid { columns: columns.collect(), lines: lines.collect() }
}

fn line(texts: impl IntoIterator<Item = String>) -> Line {
    let cell = |text: String| {
        let is_range = text.contains(" to ");
        Cell { is_interval: is_range, ..Cell::new(text) }
    };
    Line { kind: LineKind::Dataset, cells: texts.into_iter().map(cell).collect() }
}
