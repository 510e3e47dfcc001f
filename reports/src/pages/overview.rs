//! The top of the page: the run, which detector leads, by how much, how surely and how fast.

use maud::{Markup, html};

use super::document::Section;
use super::markup::{Figure, FigureMarkup};
use crate::facts::run_facts::{FailedDetector, PoolFacts, RunFacts};
use crate::files::fixed_decimals::{fixed_decimals, three_digits};
use crate::numbers::pools::Pool;
use crate::plots::ranking_plot::{RankingRow, ranking_plot};
use crate::plots::rate_time_plot::rate_time_plot;
use crate::plots::series::key;
use crate::plots::themed_panel::ThemedPanel;
use crate::rows::scan_name::ScanName;
use crate::tables::paper_figures::{PAPER_DETECTOR, PAPER_TABLES, PaperScore, Recordings};
use crate::verdicts::run_sentence::run_sentence;
use crate::verdicts::task_ranking::{Speeds, TaskRanking, origin_of_run};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::origin::Origin;

/// Detectors and data sets of the run, in a line.
pub(super) fn heading(facts: &RunFacts) -> String {
    let datasets: Vec<&str> = facts.manifest.datasets.iter().map(|it| it.id.as_str()).collect();
    format!("{} on {}", listed(&facts.detectors()), listed(&datasets))
}

/// "a, b and c".
fn listed(names: &[&str]) -> String {
    match names.split_last() {
        None => "nothing".to_owned(),
        Some((only, [])) => (*only).to_owned(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}

/// Header of the page: detectors and data sets, number of scans, time, processor and version.
pub(super) fn header(facts: &RunFacts) -> Markup {
    let n_scans: u64 = facts.manifest.datasets.iter().map(|it| it.n_scans).sum();
    let origin = origin_of_run(&facts.manifest);
    html! {
        p.kicker { "scanbench" @if origin != Origin::Recorded { " " span.tag { (origin.name()) } } }
        h1 {
            @for word in heading(facts).split(' ') { span.word { (word) } " " }
        }
        p.facts {
            (n_scans) " scans · " (facts.manifest.created.replace('T', " ").replace('Z', " UTC")) " · "
            (facts.manifest.machine.cpu_model) " · scanbench " (facts.manifest.scanbench_version)
        }
    }
}

/// The section of verdicts: which detector leads, by how much, how surely and how fast.
pub(super) fn verdict(facts: &RunFacts, files: &mut Vec<Figure>) -> Section {
    let content = html! {
        (in_words(facts))
        @for doubt in facts.manifest.doubts_in_words() { p.failed role="note" { (doubt) } }
        @for it in &facts.failures { p.failed role="note" { (about_failure(it)) } }
        @if !facts.rankings.is_empty() {
            (figure(facts, files))
            @for pool in &facts.pools { (ranked_detectors(facts, &pool.pool)) }
            (what_they_are(facts))
        }
    };
    Section::without_heading("Verdict", content)
}

/// One sentence for the data sets of each origin, and all numbers in words below; all of these where one sentence says nothing.
fn in_words(facts: &RunFacts) -> Markup {
    let in_full = html! {
        @for ranking in &facts.rankings { p { (unbroken(&ranking.sentence())) } }
        @for sentence in facts.speeds.iter().filter_map(Speeds::sentence) { p { (unbroken(&sentence)) } }
    };
    let of_pools: Option<Vec<String>> = facts.pools.iter().map(|it| sentence(facts, &it.pool)).collect();
    html! {
        @if let Some(sentences) = of_pools.filter(|it| !it.is_empty()) {
            div.verdict { @for it in sentences { p { (unbroken(&it)) } } }
            details { summary { "The numbers in words" } (in_full) }
        } @else {
            div.verdict { (in_full) }
        }
    }
}

fn sentence(facts: &RunFacts, pool: &Pool) -> Option<String> {
    let rankings: Vec<&TaskRanking> = rankings_of(facts, pool).collect();
    let sentence = run_sentence(&rankings, speeds_of(facts, pool))?;
    Some(if facts.pools.len() > 1 { format!("On {}: {sentence}", pool.in_words()) } else { sentence })
}

fn rankings_of<'a>(facts: &'a RunFacts, pool: &'a Pool) -> impl Iterator<Item = &'a TaskRanking> {
    facts.rankings.iter().filter(|it| it.pool == *pool)
}

fn speeds_of<'a>(facts: &'a RunFacts, pool: &Pool) -> Option<&'a Speeds> {
    let is_of_pool = |it: &&Speeds| it.on.as_ref().is_none_or(|on| *on == pool.in_words());
    facts.speeds.iter().find(is_of_pool)
}

/// Mean time of a detector in milliseconds.
fn mean_ms(facts: &RunFacts, pool: &Pool, detector: &str) -> Option<f64> {
    let means_ms = &speeds_of(facts, pool)?.means_ms;
    means_ms.iter().find(|it| it.0 == detector).map(|it| it.1)
}

/// The rates of all detectors with their intervals, over their times if each has one.
fn figure(facts: &RunFacts, files: &mut Vec<Figure>) -> Markup {
    let origin = origin_of_run(&facts.manifest);
    let plots: Vec<(ThemedPanel, bool)> = facts.rankings.iter().map(|it| plot(facts, it)).collect();
    let has_times = plots.iter().any(|it| it.1);
    let panels: Vec<ThemedPanel> = plots.into_iter().map(|it| it.0).collect();
    let has_paper = facts.rankings.iter().any(|it| paper_rows(facts, it).is_some());
    let together = if facts.pools.len() > 1 {
        "recorded and simulated data sets apart"
    } else {
        "all data sets together"
    };
    let markup = FigureMarkup {
        file_stem: "ranking",
        title: &format!("{} ({}){}", heading(facts), origin.name(), facts.caveat("; bars: intervals")),
        panels: &panels,
        key: &if has_times { key(&facts.detectors()) } else { Vec::new() },
        caption: html! {
            "Rates over " (together) " with 95 % intervals (bars" (facts.caveat(",")) "). "
            @if has_times {
                "Further up is better, further left is faster (mean). Line: the Pareto front; no detector is both better \
                 and faster than those on it. 100 ms: a turn of a sensor with ten turns a second. "
            }
            @if has_paper { "Hollow diamonds: what papers state, on other scans" @if has_times { " and computers" } ". " }
            @if origin != Origin::Recorded { "Scans: " (origin.name()) "." }
        },
        class: "wide",
    };
    markup.render(files)
}

/// A line for each detector, the best first.
fn ranked_detectors(facts: &RunFacts, pool: &Pool) -> Markup {
    let rankings: Vec<&TaskRanking> = rankings_of(facts, pool).collect();
    let Some(first) = rankings.first() else { return html! {} };
    let [_, on] = facts.of_pool(pool);
    let label = format!("Detectors by rate{on}");
    let rate = |it: &TaskRanking| if it.metric == Metric::FRate { "F-rate" } else { "recall" };
    let percent = |it: f64| fixed_decimals(100.0 * it, 1);
    html! {
        div.scroll tabindex="0" role="region" aria-label=(label) {
            table.ranked {
                caption.hidden { (label) }
                thead {
                    tr {
                        th scope="col" { "detector" }
                        @for it in &rankings { th.number scope="col" { (it.task) " " span.interval { (rate(it)) " (%)" } } }
                        th.number scope="col" { "ms " span.interval { "a scan" } }
                    }
                }
                tbody {
                    @for detector in first.detectors.iter().map(|it| it.detector.as_str()) {
                        tr {
                            th scope="row" { (detector) }
                            @for ranking in &rankings {
                                @let ranked = ranking.detectors.iter().find(|it| it.detector == detector);
                                td.number {
                                    (ranked.and_then(|it| it.value).map_or_else(|| "–".to_owned(), percent))
                                    @if let Some(interval) = ranked.and_then(|it| it.interval) {
                                        " " span.interval { (interval.ends.map(percent).join(" to ")) }
                                    }
                                }
                            }
                            td.number { (mean_ms(facts, pool, detector).map_or_else(|| "–".to_owned(), three_digits)) }
                        }
                    }
                }
            }
        }
    }
}

/// The built-in detectors of the run, in a line each.
fn what_they_are(facts: &RunFacts) -> Markup {
    let known: Vec<(&str, &str)> =
        BUILT_IN.iter().filter(|it| facts.detectors().contains(&it.0)).copied().collect();
    html! {
        @if !known.is_empty() {
            details {
                summary { "What these detectors are" }
                dl { @for (name, what) in known { div { dt { (name) } dd { (what) } } } }
            }
        }
    }
}

/// What the built-in detectors are.
const BUILT_IN: [(&str, &str); 8] = [
    (
        "hierarchical",
        "the project's own: the best cut of groups of dense grid cells; trained trees choose and classify them",
    ),
    (
        "paper",
        "the hierarchical grid of Börcs, Nagy and Benedek (2014): merged and separated cells, an SVM for vehicles",
    ),
    ("simple-grid", "hierarchical with one level of cells"),
    ("kd-tree", "a rival in the papers: connected components over a kd-tree; trained trees classify them"),
    ("kd-tree-same-walls", "kd-tree without the walls that paper removes"),
    ("kd-tree-trained", "components over a kd-tree, with a tolerance for each sensor and trees of its own"),
    ("kd-tree-tree", "the best cut of components over a kd-tree with ten tolerances; trees of its own"),
    ("pca", "a rival in the papers: clusters of plain cells, boxes by principal axes, an SVM for vehicles"),
];

fn about_failure(failed: &FailedDetector) -> String {
    let FailedDetector { detector, first: (scan, reason), n_failed, n_scans } = failed;
    let ScanName { dataset, sequence, scan } = scan;
    format!(
        "{detector} failed at {n_failed} of {n_scans} scans. They count as nothing found. The first was \
         {dataset} {sequence}/{scan:06}: {reason}."
    )
}

/// Units stay with their numbers.
fn unbroken(sentence: &str) -> String {
    [" %", " ms", " ×", " points"]
        .iter()
        .fold(sentence.to_owned(), |text, unit| text.replace(unit, &format!("\u{a0}{}", unit.trim_start())))
}

/// The rates of a task over times, if each detector has a time; else one below the other.
fn plot(facts: &RunFacts, ranking: &TaskRanking) -> (ThemedPanel, bool) {
    let paper = paper_rows(facts, ranking);
    let percent = |it: f64| 100.0 * it;
    let row = |name: &&str| {
        let ranked = ranking.detectors.iter().find(|it| it.detector == *name);
        let row = RankingRow {
            name: (*name).to_owned(),
            detector_idx: facts.detector_idx(name),
            percent: ranked.and_then(|it| it.value).map(percent),
            interval_percent: ranked.and_then(|it| it.interval).map(|it| it.ends.map(percent)),
            published: paper.as_ref().and_then(|paper| paper(name)),
        };
        (row, mean_ms(facts, &ranking.pool, name))
    };
    let rows: Vec<(RankingRow, Option<f64>)> = facts.detectors().iter().map(row).collect();
    let rate = match ranking.metric {
        Metric::FRate => "F-rate (%)",
        _ => "recall (%)",
    };
    let of_pool = facts.pools.iter().find(|it| it.pool == ranking.pool);
    let caveat = of_pool.and_then(PoolFacts::caveat_of_intervals);
    let [_, on] = facts.of_pool(&ranking.pool);
    let title = format!("Task {}{on}", ranking.task);
    if let Some(panel) = rate_time_plot(&title, rate, caveat.as_deref(), &rows) {
        return (panel, true);
    }
    let rate = caveat.map_or_else(|| rate.to_owned(), |it| format!("{rate}, intervals {it}"));
    let rows: Vec<RankingRow> = rows.into_iter().map(|it| it.0).collect();
    (ranking_plot(&title, &rate, &rows), false)
}

/// What the paper of a task states for a detector, on KITTI if the run is of KITTI alone, else on all
/// recordings; `None` if there is no such paper, its method did not run, or it states another rate.
fn paper_rows<'a>(
    facts: &RunFacts,
    ranking: &'a TaskRanking,
) -> Option<impl Fn(&str) -> Option<PaperScore> + 'a> {
    let table = PAPER_TABLES.iter().find(|it| it.task == ranking.task)?;
    let datasets = facts.manifest.datasets.iter().filter(|it| ranking.pool.datasets.contains(&it.id));
    let is_kitti = { datasets }.all(|it| it.format.contains("kitti"));
    let recordings = if is_kitti { Recordings::Kitti } else { Recordings::Both };
    let row = table.rows.iter().find(|it| it.recordings == recordings)?;
    let states = move |detector: &str| table.score_beside(row, detector);
    let is_stated =
        ranking.metric == Metric::FRate && ranking.detectors.iter().any(|it| it.detector == PAPER_DETECTOR);
    is_stated.then_some(states)
}
