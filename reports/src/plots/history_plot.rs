//! Numbers over the runs of a history.

use std::collections::BTreeMap;

use super::curve_panels::{CurvePanel, Note, curve_figure};
use super::series::{DetectorMarks, Position, Series};
use crate::history::history_file::Number;
use crate::history::trends::{Trend, Trends};

/// A figure for each metric and task, with a panel for each data set: its name, its title and its SVG.
pub fn history_figures(trends: &Trends<'_>) -> Vec<(String, String, String)> {
    let detectors = DetectorMarks::of(trends.trends.iter().map(|it| it.name.subject.detector.as_str()));
    let mut figures: BTreeMap<(String, String), BTreeMap<&str, Vec<&Trend>>> = BTreeMap::new();
    for trend in &trends.trends {
        let subject = &trend.name.subject;
        let task =
            if trend.name.metric.is_time() { "times".to_owned() } else { subject.task.name().to_owned() };
        let of_figure = figures.entry((trend.name.metric.id(), task)).or_default();
        of_figure.entry(&subject.dataset).or_default().push(trend);
    }
    let figure = |((metric, task), panels): ((String, String), BTreeMap<&str, Vec<&Trend>>)| {
        let panels: Vec<CurvePanel> = panels
            .into_iter()
            .map(|(dataset, of_dataset)| panel(dataset, &metric, &of_dataset, &detectors))
            .collect();
        let title = format!("{metric} of {task} over runs");
        let svg = curve_figure(&panels, &title).svg(&title);
        (format!("history_{metric}_{task}"), title, svg)
    };
    figures.into_iter().map(figure).collect()
}

fn panel(dataset: &str, metric: &str, trends: &[&Trend], detectors: &DetectorMarks<'_>) -> CurvePanel {
    let unit = trends.first().map_or("ratio", |it| it.name.metric.unit());
    let (scale, unit) = if unit == "ratio" { (100.0, "%") } else { (1.0, unit) };
    let number = |run_idx: usize| (run_idx + 1) as f64;
    let series = trends.iter().map(|trend| {
        let detector = &trend.name.subject.detector;
        let position = |(run_idx, it): &(usize, Number)| {
            let within = it.within.map(|ends| ends.map(|end| scale * end));
            Some(Position { x: number(*run_idx), y: scale * it.value, within })
        };
        let positions = trend.values.iter().map(position).collect();
        Series { name: detector.clone(), mark: detectors.mark(detector, 0), positions }
    });
    let mut changed: Vec<usize> = trends
        .iter()
        .flat_map(|it| it.changes.iter().map(|change| it.values[change.first_after].0))
        .collect();
    changed.sort_unstable();
    changed.dedup();
    let note = |run_idx: usize| Note::Upright(number(run_idx), format!("run {}", run_idx + 1));
    CurvePanel {
        title: dataset.to_owned(),
        series: series.collect(),
        notes: changed.into_iter().map(note).collect(),
        ..CurvePanel::over("run", format!("{metric} ({unit})"))
    }
}
