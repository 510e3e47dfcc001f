//! Times of detection: of scans, and of stages.

use maud::html;

use super::document::Section;
use super::markup::{Figure, FigureMarkup, sentences, table};
use crate::facts::run_facts::RunFacts;
use crate::plots::latency_plot::latency_plot;
use crate::plots::series::key_of;
use crate::plots::stage_plot::stage_plot;
use crate::plots::themed_panel::ThemedPanel;
use crate::tables::sheet::Tabular as _;
use crate::tables::times_table::TimesTable;
use crate::verdicts::task_ranking::origin_of_run;
use crate::verdicts::times_doubt::times_doubts;

pub(super) fn times(facts: &RunFacts, files: &mut Vec<Figure>) -> Section {
    let sheet = TimesTable::new(&facts.report, &facts.manifest).sheet();
    let origin = origin_of_run(&facts.manifest).name();
    let stages = facts.pools.iter().flat_map(|it| {
        let [_, on] = facts.of_pool(&it.pool);
        let timed = it.stages_ms.iter().filter(|(_, stages)| !stages.is_empty());
        timed.map(move |(name, stages)| stage_plot(&format!("{name}{on}"), facts.detector_idx(name), stages))
    });
    let stages: Vec<ThemedPanel> = stages.collect();
    let of_scans = facts.pools.iter().filter_map(|it| {
        let [_, on] = facts.of_pool(&it.pool);
        latency_plot(&format!("scans that finish within a time{on}"), &it.times_ms)
    });
    let of_scans: Vec<ThemedPanel> = of_scans.collect();
    let has_times = |name: &str| {
        let mut of_detectors = facts.pools.iter().flat_map(|it| &it.times_ms);
        of_detectors.any(|(detector, times)| detector == name && !times.is_empty())
    };
    let content = html! {
        p.about { "Detection only, on " (facts.manifest.machine.cpu_model) ". On another machine, only ratios can be compared." }
        @for doubt in times_doubts(&facts.manifest, &facts.report) { p.doubt role="note" { (doubt) } }
        div.beside {
            @if !of_scans.is_empty() {
                (FigureMarkup {
                    file_stem: "times",
                    title: &format!("Times of scans ({origin})"),
                    panels: &of_scans,
                    key: &key_of(&facts.detectors(), has_times),
                    caption: html! {
                        "Share of the scans (" (origin) ") that finish within a time. Farther left is faster; steeper means less spread. "
                        "A sensor with ten turns per second allows 100 ms."
                    },
                    class: "single",
                }.render(files))
            }
        }
        details {
            summary { "Percentiles and scans per second" }
            @for part in &sheet.parts { (table(&part.grid, &sheet.notes, "Times of scans")) }
            (sentences(&sheet.notes))
        }
        @if !stages.is_empty() {
            details {
            summary { "Stage by stage" }
            (FigureMarkup {
                file_stem: "stages",
                title: &format!("Median times of stages ({origin})"),
                panels: &stages,
                key: &[],
                caption: html! {
                    "Median time of each stage (" (origin) "), in the order of the stages. The scale of the bars differs between detectors."
                },
                class: "stages",
            }.render(files))
            }
        }
    };
    Section::new("Times", "Times", content)
}
