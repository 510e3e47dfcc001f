//! Recall by class, occlusion and number of points.

use maud::html;

use super::document::Section;
use super::markup::table;
use crate::facts::run_facts::{PoolFacts, RunFacts};
use crate::files::fixed_decimals::percent_or_dash;
use crate::numbers::run_report::{MetricRow, Subject};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::Sheet;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// Which objects are found: a table for the data sets of each origin; `None` if nothing is annotated that counts.
pub(super) fn recall_parts(facts: &RunFacts) -> Option<Section> {
    let grids: Vec<(&PoolFacts, Grid)> =
        facts.pools.iter().filter_map(|it| Some((it, grid(facts, it.pool.extent.name())?))).collect();
    let content = html! {
        p.about {
            "Recall of objects in %, whichever class a detection has. n: annotations that count, of which there are "
            (n_counted_and_ignored(facts)) ". (A false detection has no true class.)"
        }
        @for (pool, grid) in &grids {
            @let [_, on] = facts.of_pool(&pool.pool);
            @if !on.is_empty() { h3 { (on.trim_start_matches(", ")) } }
            @let title = format!("Recall by class, occlusion and points{on}");
            @let sheet = Sheet::of(title.clone(), grid.clone(), Vec::new());
            (table(grid, &sheet.notes, &title))
        }
    };
    (!grids.is_empty()).then(|| Section::new("Recall", "Which objects are found", content))
}

/// The recall of each detector in the parts of the objects of `extent`, most annotations first among the classes.
fn grid(facts: &RunFacts, extent: &str) -> Option<Grid> {
    let task = Task::Objects;
    let detectors = facts.detectors();
    let row = |slice: Slice, detector: &str, metric: Metric| -> Option<f64> {
        let subject = Subject { slice, ..Subject::of_all(extent, task, detector) };
        facts.report.row(&subject, &metric).and_then(MetricRow::value)
    };
    let first = detectors.first()?;
    let n_annotations = |slice: Slice| row(slice, first, Metric::No).unwrap_or(0.0);
    let of_task = facts.report.rows().iter().chain(facts.report.overall());
    let mut slices: Vec<Slice> = Vec::new();
    for it in of_task.filter(|it| it.subject.task == task && it.subject.dataset == extent) {
        let slice = it.subject.slice;
        if kind(slice).is_some() && !slices.contains(&slice) && n_annotations(slice) > 0.0 {
            slices.push(slice);
        }
    }
    let is_class = |it: &Slice| matches!(it, Slice::Class(_));
    slices.sort_by(|a, b| {
        let fewer = n_annotations(*b).total_cmp(&n_annotations(*a));
        kind(*a).cmp(&kind(*b)).then(if is_class(a) {
            fewer
        } else {
            severity(*a).cmp(&severity(*b)).then(a.cmp(b))
        })
    });
    let mut columns = vec![Column::left("part"), Column::number("n")];
    columns.extend(detectors.iter().map(|it| Column::number((*it).to_owned())));
    let lines = slices.iter().map(|&slice| {
        let cells =
            [Cell::new(in_words(slice)), Cell::new(format!("{:.0}", n_annotations(slice)))].into_iter();
        let recalls = detectors.iter().map(|it| Cell::new(percent_or_dash(row(slice, it, Metric::Recall))));
        Line { kind: LineKind::Detail, cells: cells.chain(recalls).collect() }
    });
    let lines: Vec<Line> = lines.collect();
    (!lines.is_empty()).then_some(Grid { columns, lines })
}

/// How many annotations count, and why others do not.
fn n_counted_and_ignored(facts: &RunFacts) -> String {
    let detector = facts.manifest.detectors.first();
    let sum = |metric: Metric| -> f64 {
        let of_pool = |it: &PoolFacts| {
            let subject = Subject::of_all(it.pool.extent.name(), Task::Objects, &detector?.name);
            facts.report.row(&subject, &metric)?.value()
        };
        facts.pools.iter().filter_map(of_pool).sum()
    };
    let ignored = &facts.manifest.ignored;
    format!(
        "{:.0}; {:.0} are ignored, such as those with fewer than {} points or beyond {} m",
        sum(Metric::No),
        sum(Metric::IgnoredAnnotations),
        ignored.min_points,
        ignored.max_range_m
    )
}

/// The order of kinds of slices; `None` for those that are shown elsewhere.
fn kind(slice: Slice) -> Option<u8> {
    match slice {
        Slice::Class(_) => Some(0),
        Slice::Occlusion(_) => Some(1),
        Slice::Points(_) => Some(2),
        Slice::Truncated => Some(3),
        _ => None,
    }
}

/// How much is hidden, as a rank.
fn severity(slice: Slice) -> u8 {
    if let Slice::Occlusion(occlusion) = slice { occlusion as u8 } else { 0 }
}

fn in_words(slice: Slice) -> String {
    match slice {
        Slice::Class(class) => class.name().to_owned(),
        Slice::Points(_) => slice.name().replace("points/", "points: "),
        Slice::Occlusion(it) => format!("occluded: {}", it.name()),
        _ => "cut off by the view".to_owned(),
    }
}
