//! The plot of rates as they stream over the speed of the computer.

use super::curve_panels::{CurvePanel, Note, curve_figure};
use super::series::{DetectorMarks, Position, Series};
use crate::streaming::streamed::Streamed;
use crate::tables::studies::streaming_table::factor_in_words;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::task::Task;

/// A panel for each task, with a curve for every detector; `None` if nothing was judged on other machines. `streamed` is about
/// one extent.
pub fn streaming_plot(streamed: &[&Streamed], of: &str) -> Option<String> {
    let marks = DetectorMarks::of(streamed.iter().map(|it| it.detector.as_str()));
    let mut tasks: Vec<Task> = streamed.iter().map(|it| it.task).collect();
    tasks.sort_unstable();
    tasks.dedup();
    let panels = tasks.into_iter().filter_map(|task| {
        let of_task: Vec<&&Streamed> = streamed.iter().filter(|it| it.task == task).collect();
        let words = of_task.first()?.by_machine().map(|(speed, _)| factor_in_words(speed));
        let words: Vec<String> = words.collect();
        let series = of_task.iter().map(|it| Series {
            name: it.detector.clone(),
            mark: marks.mark(&it.detector, 0),
            positions: it
                .by_machine()
                .enumerate()
                .map(|(idx, (_, rate))| Some(Position { x: idx as f64, y: 100.0 * rate?, within: None }))
                .collect(),
        });
        let is_known = of_task.iter().any(|it| it.streamed.fo().is_some());
        let this = words.iter().position(|it| it == "1").unwrap_or_default() as f64;
        Some(CurvePanel {
            title: task.name().to_owned(),
            series: series.collect(),
            x_words: Some(words),
            // The words at the line stand above all curves.
            y_range: Some([0.0, 110.0]),
            notes: vec![Note::Upright(this, "times as they are".to_owned())],
            ..CurvePanel::over(
                "speed of the computer, as a multiple of the one that the times are of",
                format!("{}, streaming (%)", if is_known { "F-rate" } else { "recall" }),
            )
        })
    });
    let panels: Vec<CurvePanel> =
        panels.filter(|it| !it.series.iter().all(|it| it.positions.is_empty())).collect();
    let simulated = if streamed.iter().any(|it| it.origin != Origin::Recorded) { " (simulated)" } else { "" };
    let title = format!("What is right while the world moves on: {of}{simulated}");
    (!panels.is_empty()).then(|| curve_figure(&panels, &title).svg(&title))
}
