//! Rates over the range from the sensor.

use maud::html;

use super::document::Section;
use super::markup::{Figure, FigureMarkup};
use crate::facts::run_facts::{RunFacts, TaskRanges};
use crate::plots::range_plot::range_plot;
use crate::plots::series::key_of;

pub(super) fn ranges(facts: &RunFacts, files: &mut Vec<Figure>) -> Section {
    let undefined = "Precision and F-rate are undefined: not every class of object is annotated, so false objects cannot be \
                     counted. ";
    let of_pools = || facts.pools.iter().flat_map(|pool| pool.ranges.iter().map(move |it| (pool, it)));
    let content = html! {
        @for (idx, (pool, of_task)) in of_pools().enumerate() {
            @let ([file_end, on], origin) = (facts.of_pool(&pool.pool), pool.pool.origin.name());
            @let together = if pool.pool.is_of_several() { ", all data sets together" } else { "" };
            @let has_curve = |name: &str| {
                let mut series = of_task.rates.iter().flat_map(|it| &it.1);
                series.any(|it| it.name == name && it.positions.iter().any(Option::is_some))
            };
            @let panels: Vec<_> =
                of_task.rates.iter().map(|(rate, rates)| range_plot(rate, &of_task.bins, rates)).collect();
            h3 { "Task " (of_task.task) (on) }
            (FigureMarkup {
                file_stem: &format!("range_{}{file_end}", of_task.task),
                title: &format!("Rates over range, task {} ({origin}){}", of_task.task, pool.caveat("; bars: intervals")),
                panels: &panels,
                key: &key_of(&facts.detectors(), has_curve),
                caption: html! {
                    "By distance from the sensor" (together) " (" (origin)
                    "), with 95 % intervals" (pool.caveat("")) ". "
                    @if idx == 0 { "An annotation counts at its own range, a false detection at its own. " }
                    "Annotations that count: " (annotations(of_task)) ". "
                    @if !of_task.rates.iter().any(|(name, _)| *name == "precision") { (undefined) }
                },
                class: "",
            }.render(files))
        }
    };
    Section::new("Range", "Near and far", content)
}

/// Number of annotations in each bin, in words.
fn annotations(of_task: &TaskRanges) -> String {
    let bins = of_task.bins.iter().zip(&of_task.n_annotations);
    let bins = bins.map(|(bin, n)| format!("{n} within {} m", bin.replace('-', "–")));
    bins.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::sample_run::{SampleRun, USUAL};

    #[test]
    fn a_curve_has_no_point_where_nothing_is_annotated() {
        let facts = RunFacts::read(SampleRun { false_m: 90.0, ..USUAL }.write().path()).unwrap();
        let of_task = &facts.pools[0].ranges[0];
        assert_eq!(
            (of_task.bins.last().map(String::as_str), &*of_task.n_annotations),
            (Some("80+"), &[36, 24, 48, 12, 0][..])
        );
        for (rate, series) in &of_task.rates {
            for of_detector in series {
                let drawn: Vec<bool> = of_detector.positions.iter().map(Option::is_some).collect();
                // From 50 to 80 m nothing is detected, so there is no precision, either.
                assert_eq!(
                    drawn,
                    [true, true, true, *rate != "precision", false],
                    "{rate} of {}",
                    of_detector.name
                );
            }
        }
        assert_eq!(of_task.rates.len(), 3);
    }
}
