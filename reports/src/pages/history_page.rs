//! The page of a history: what changed when, figures over the runs, and the runs.

use maud::{Markup, html};

use super::document::{Section, document};
use super::markup::wide_picture;
use crate::files::fixed_decimals::fixed_decimals;
use crate::history::change_points::{ChangePoint, SIGNIFICANCE};
use crate::history::trends::{Comparable, MOST_RUNS, Trend, Trends};
use crate::plots::history_plot::history_figures;

/// With fewer runs a change in the middle is called sure only if it is a single, large one.
const FEW_RUNS: usize = 14;
/// Numbers that are listed for a run, at most; the page has all.
const MOST_LISTED: usize = 8;

/// The page of a history.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryPage {
    /// The page, whole in itself.
    pub html: String,
    /// Its figures as files, by name.
    pub figures: Vec<(String, Vec<u8>)>,
}

impl HistoryPage {
    /// The page of `trends`.
    pub fn of(trends: &Trends<'_>) -> Self {
        let figures = history_figures(trends);
        let pictures = html! {
            @for (name, title, svg) in &figures { (wide_picture(name, svg, &html! { (title) "; a dotted line is a change." })) }
        };
        let header = html! {
            p.kicker { "scanbench" }
            h1 { "History of " (trends.runs.len()) " runs" }
            p.facts { (looked_at(trends)) }
        };
        let sections = [
            Section::new("Changes", "What changed, and when", changes(trends)),
            Section::new("Figures", "Numbers over runs", pictures),
            Section::new("Runs", "The runs", runs(trends)),
        ];
        let files = figures.into_iter().map(|(name, _, svg)| (format!("{name}.svg"), svg.into_bytes()));
        Self { html: document("a history", &header, &sections), figures: files.collect() }
    }
}

fn changes(trends: &Trends<'_>) -> Markup {
    let changed = trends.changed_runs();
    html! {
        @if changed.is_empty() { p { (nothing_changed(trends)) } }
        @for (run_idx, numbers) in &changed {
            h3 { (run_in_words(trends, *run_idx)) }
            ul { @for it in trends.what_changed(*run_idx) { li { (it) } } }
            ul { @for (trend, change) in numbers { li { (change_in_words(trend, change)) } } }
        }
        @for reason in other_lines(trends) { p { (reason) } }
    }
}

fn runs(trends: &Trends<'_>) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="The runs" {
            table {
                thead { tr { th { "run" } th { "time (UTC)" } th { "commit" } th { "processor" } th { "what changed" } } }
                tbody {
                    @for (run_idx, (name, run)) in trends.runs.iter().enumerate() {
                        tr {
                            th scope="row" {
                                @match &run.link {
                                    Some(link) => { a href=(link) title=(name) { (run_idx + 1) } }
                                    None => { (run_idx + 1) }
                                }
                            }
                            td { (run.created) }
                            td { (run.short_commit()) }
                            td { (run.machine.cpu_model) }
                            td { (trends.what_changed(run_idx).join("; ")) }
                        }
                    }
                }
            }
        }
    }
}

/// What a terminal shows of `trends`.
pub fn in_short(trends: &Trends<'_>) -> String {
    let mut lines = vec![looked_at(trends)];
    let changed = trends.changed_runs();
    if changed.is_empty() {
        lines.push(nothing_changed(trends));
    }
    for (run_idx, numbers) in changed {
        lines.push(String::new());
        lines.push(run_in_words(trends, run_idx));
        lines.extend(trends.what_changed(run_idx).into_iter().map(|it| format!("  {it}")));
        let shown = numbers.iter().take(MOST_LISTED);
        lines.extend(shown.map(|(trend, change)| format!("  {}", change_in_words(trend, change))));
        if numbers.len() > MOST_LISTED {
            lines.push(format!("  and {} more", numbers.len() - MOST_LISTED));
        }
    }
    lines.extend(other_lines(trends));
    lines.join("\n") + "\n"
}

fn looked_at(trends: &Trends<'_>) -> String {
    let n = trends.n_looked_at();
    let by_chance = fixed_decimals(SIGNIFICANCE * n as f64, 1);
    let ends = match (trends.runs.first(), trends.runs.last()) {
        (Some((_, first)), Some((_, last))) => format!(", {} to {}", first.created, last.created),
        _ => String::new(),
    };
    let most = if trends.runs.len() > MOST_RUNS {
        format!(", in their last {MOST_RUNS} runs")
    } else {
        String::new()
    };
    format!(
        "{} runs{ends}. {n} numbers are looked at{most}, each at a level of {} %: about {by_chance} would be called changed by chance.",
        trends.runs.len(),
        fixed_decimals(100.0 * SIGNIFICANCE, 0)
    )
}

/// The sentence about trends without a change; where runs are few, with the largest step of a score, which may be one.
fn nothing_changed(trends: &Trends<'_>) -> String {
    let n_runs = trends.trends.iter().map(|it| it.values.len()).max().unwrap_or_default();
    if n_runs == 0 || n_runs >= FEW_RUNS {
        return "No number changed.".to_owned();
    }
    let step = trends.largest_step().map(|(trend, run_idx, step)| {
        let step = signed(&fixed_decimals(100.0 * step, 1));
        format!(" The largest step of a rate is {step} at run {}: {}.", run_idx + 1, trend.in_words())
    });
    format!(
        "No number surely changed, which {n_runs} runs of a line can hardly show; {FEW_RUNS} can.{}",
        step.unwrap_or_default()
    )
}

fn run_in_words(trends: &Trends<'_>, run_idx: usize) -> String {
    let (_, run) = &trends.runs[run_idx];
    let link = run.link.as_ref().map_or_else(String::new, |it| format!(", {it}"));
    format!("Run {}, {}, commit {}{link}", run_idx + 1, run.created, run.short_commit())
}

fn change_in_words(trend: &Trend, change: &ChangePoint) -> String {
    let unit = trend.name.metric.unit();
    let (scale, unit) = if unit == "ratio" { (100.0, "%") } else { (1.0, unit) };
    let shown = |value: f64| fixed_decimals(scale * value, if scale > 1.0 { 1 } else { 2 });
    let [before, after] = change.means.map(shown);
    let [low, high] = change.difference.map(shown);
    let run = |idx: usize| trend.values[idx.min(trend.values.len() - 1)].0 + 1;
    let [from, to] = change.within.map(run);
    let position = if from == to { String::new() } else { format!(", at run {from} to {to}") };
    format!(
        "{}: {before} → {after} {unit}, by {} to {}, p {}{position}",
        trend.in_words(),
        signed(&low),
        signed(&high),
        fixed_decimals(change.p_value, 3)
    )
}

fn signed(number: &str) -> String {
    if number.starts_with(['-', '−']) { number.to_owned() } else { format!("+{number}") }
}

/// Where another line of comparable runs begins, and why.
fn other_lines(trends: &Trends<'_>) -> Vec<String> {
    let others = trends.groups.iter().skip(1);
    let line = |group: &Comparable| {
        format!("Run {} begins another line: {}.", group.runs[0] + 1, group.reasons.join("; "))
    };
    others.map(line).collect()
}
