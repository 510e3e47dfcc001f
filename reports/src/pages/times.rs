//! How long detection takes: of scans, and of stages.

use maud::{Markup, html};

use super::markup::{Figure, FigureMarkup, sentences, table};
use super::run_facts::RunFacts;
use crate::plots::latency_plot::latency_plot;
use crate::plots::small_panel::key;
use crate::plots::stage_plot::stage_plot;
use crate::plots::themed_svg::ThemedPanel;
use crate::tables::sheet::Tabular as _;
use crate::tables::times_table::TimesTable;
use crate::verdicts::standing::origin_of_run;

pub(super) fn times(facts: &RunFacts, files: &mut Vec<Figure>) -> Markup {
    let times = TimesTable::new(&facts.report, &facts.manifest);
    let sheet = times.sheet();
    let origin = origin_of_run(&facts.manifest).name();
    let stages: Vec<ThemedPanel> = facts
        .stages_ms
        .iter()
        .filter(|(_, stages)| !stages.is_empty())
        .map(|(detector, stages)| stage_plot(detector, facts.detector_idx(detector), stages))
        .collect();
    html! {
        section #times aria-labelledby="times-title" {
            h2 #times-title { "Times" }
            p.about { "Detection only, on " (facts.manifest.machine.cpu_model) ". On another machine, only ratios can be compared." }
            div.beside {
                @if let Some(panel) = latency_plot(&facts.times_ms) {
                    (FigureMarkup {
                        file_stem: "times",
                        title: &format!("Times of scans ({origin})"),
                        panels: &[panel],
                        key: &key(&facts.detectors()),
                        caption: html! {
                            "Share of the scans (" (origin) ") that finish within a time. Farther left is faster, steeper is more constant. "
                            "A sensor with ten turns per second allows 100 ms."
                        },
                        class: "single",
                    }.render(files))
                }
                div {
                    @for part in &sheet.parts {
                        (table(&part.grid, &sheet.notes, "Times of scans"))
                    }
                    (sentences(&sheet.notes))
                }
            }
            @if !stages.is_empty() {
                h3 { "Stage by stage" }
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
    }
}
