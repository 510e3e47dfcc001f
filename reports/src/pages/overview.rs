//! The top of the page: the run, which detector leads, by how much and how surely.

use maud::{Markup, html};

use super::document::Section;
use super::markup::{Figure, FigureMarkup};
use crate::facts::run_facts::{FailedDetector, PoolFacts, RunFacts};
use crate::plots::ranking_plot::{RankingRow, ranking_plot};
use crate::rows::scan_name::ScanName;
use crate::tables::paper_figures::{PAPER_DETECTOR, PAPER_TABLES, Recordings};
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

/// The section of verdicts: which detector leads, by how much and how surely.
pub(super) fn verdict(facts: &RunFacts, files: &mut Vec<Figure>) -> Section {
    let origin = origin_of_run(&facts.manifest);
    let plots: Vec<_> = facts.rankings.iter().map(|it| plot(facts, it)).collect();
    let has_paper = facts.rankings.iter().any(|it| paper_rows(facts, it).is_some());
    let together = if facts.pools.len() > 1 {
        "recorded and simulated data sets apart"
    } else {
        "all data sets together"
    };
    let content = html! {
        div.verdict {
            @for ranking in &facts.rankings { p { (unbroken(&ranking.sentence())) } }
            @for sentence in facts.speeds.iter().filter_map(Speeds::sentence) { p { (unbroken(&sentence)) } }
        }
        @for doubt in facts.manifest.doubts_in_words() { p.failed role="note" { (doubt) } }
        @for it in &facts.failures { p.failed role="note" { (about_failure(it)) } }
        @if !plots.is_empty() {
        (FigureMarkup {
            file_stem: "ranking",
            title: &format!("{} ({}){}", heading(facts), origin.name(), facts.caveat("; bars: intervals")),
            panels: &plots,
            key: &[],
            caption: html! {
                "Rates over " (together) " with 95 % intervals (bars" (facts.caveat(",")) "). "
                @if has_paper {
                    "Hollow diamonds: published results, on other scans, for orientation. "
                }
                @if origin != Origin::Recorded { "Scans: " (origin.name()) "." }
            },
            class: "wide",
        }.render(files))
        }
    };
    Section::without_heading("Verdict", content)
}

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

fn plot(facts: &RunFacts, ranking: &TaskRanking) -> crate::plots::themed_panel::ThemedPanel {
    let paper = paper_rows(facts, ranking);
    let percent = |it: f64| 100.0 * it;
    let row = |name: &&str| {
        let ranked = ranking.detectors.iter().find(|it| it.detector == *name);
        RankingRow {
            name: (*name).to_owned(),
            detector_idx: facts.detector_idx(name),
            percent: ranked.and_then(|it| it.value).map(percent),
            interval_percent: ranked.and_then(|it| it.interval).map(|it| it.ends.map(percent)),
            paper_percent: paper.as_ref().and_then(|paper| paper(name)),
        }
    };
    let rows: Vec<RankingRow> = facts.detectors().iter().map(row).collect();
    let rate = match ranking.metric {
        Metric::FRate => "F-rate (%)",
        _ => "recall (%)",
    };
    let of_pool = facts.pools.iter().find(|it| it.pool == ranking.pool);
    let rate = match of_pool.and_then(PoolFacts::caveat_of_intervals) {
        Some(caveat) => format!("{rate}, intervals {caveat}"),
        None => rate.to_owned(),
    };
    let [_, on] = facts.of_pool(&ranking.pool);
    ranking_plot(&format!("Task {}{on}", ranking.task), &rate, &rows)
}

/// F-rates in percent that the paper of a task states for a detector, on KITTI if the run is of KITTI alone, else on all
/// recordings; `None` if there is no such paper, its method did not run, or it states another rate.
fn paper_rows<'a>(facts: &RunFacts, ranking: &'a TaskRanking) -> Option<impl Fn(&str) -> Option<f64> + 'a> {
    let table = PAPER_TABLES.iter().find(|it| it.task == ranking.task)?;
    let datasets = facts.manifest.datasets.iter().filter(|it| ranking.pool.datasets.contains(&it.id));
    let is_kitti = { datasets }.all(|it| it.format.contains("kitti"));
    let recordings = if is_kitti { Recordings::Kitti } else { Recordings::Both };
    let row = table.rows.iter().find(|it| it.recordings == recordings)?;
    let states = move |detector: &str| Some(table.score_beside(row, detector)?.f_rate_percent);
    let is_stated =
        ranking.metric == Metric::FRate && ranking.detectors.iter().any(|it| it.detector == PAPER_DETECTOR);
    is_stated.then_some(states)
}
