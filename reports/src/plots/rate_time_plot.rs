//! The rates of detectors over the time that they take for a scan.

use plotters::style::text_anchor::{HPos, VPos};

use super::figure::{Axis, Chart, Figure, Frame, Grid, Labels, Panel, Scale};
use super::marks::{BLACK, LINE_WIDTH_PX, Mark, QUIET, SeriesMark, bold_style, text_style};
use super::pareto_plot::pareto_front;
use super::ranking_plot::{RankingRow, axis};
use super::small_panel::SMALL_TEXT_PX;
use super::themed_panel::ThemedPanel;
use crate::tables::paper_figures::PaperScore;

/// Width and height of a panel of which two are side by side on a page.
const SIZE_PX: [u32; 2] = [430, 270];
const FRAME: Frame = Frame {
    margins_px: [24, 14, 0, 2],
    room_px: [44, 50],
    text_px: [SMALL_TEXT_PX, SMALL_TEXT_PX],
    axis_color: QUIET,
    grid: Grid::Level,
};
/// The time between two scans of a sensor that turns ten times a second, in milliseconds.
const TURN_MS: f64 = 100.0;
/// Room beside the shortest and the longest time, as a factor.
const ROOM: f64 = 1.5;

/// A panel with the rate of every detector over its time in milliseconds; `title` names the task, `rate` the rate, and
/// `caveat` says what the intervals lack. A line joins those that no other is both faster and better than. What papers state
/// stands where they state it. `None` if a detector has no time.
pub fn rate_time_plot(
    title: &str,
    rate: &str,
    caveat: Option<&str>,
    rows: &[(RankingRow, Option<f64>)],
) -> Option<ThemedPanel> {
    let timed = rows.iter().map(|(row, ms)| Some((row, (*ms)?))).collect::<Option<Vec<_>>>()?;
    let positions: Vec<(f64, f64)> = timed.iter().filter_map(|(row, ms)| Some((*ms, row.percent?))).collect();
    if positions.is_empty() {
        return None;
    }
    let published = |(row, _): &(&RankingRow, f64)| Some(1e3 / row.published?.fps);
    let times_ms = || timed.iter().map(|it| it.1).chain(timed.iter().filter_map(published));
    let shortest_ms = times_ms().fold(TURN_MS, f64::min) / ROOM;
    let longest_ms = times_ms().fold(TURN_MS, f64::max) * ROOM;
    let percent = axis(timed.iter().map(|it| it.0));
    let mut marks = vec![
        Mark::line(percent.map(|it| (TURN_MS, it)), BLACK, 1).dashed(Some([2, 4])),
        Mark::text(
            (TURN_MS, percent[0]),
            [-4, -8],
            "100 ms",
            text_style(SMALL_TEXT_PX - 2, HPos::Right, VPos::Bottom),
        ),
        Mark::line(pareto_front(&positions).into_iter().map(|it| positions[it]), QUIET, LINE_WIDTH_PX),
    ];
    for (row, ms) in &timed {
        let mark = SeriesMark(row.detector_idx);
        let interval = row.interval_percent.map(|ends| ends.map(|it| (*ms, it)));
        marks.extend(interval.map(|it| Mark::line(it, mark.color(), LINE_WIDTH_PX)));
        if let Some(PaperScore { f_rate_percent, fps }) = row.published {
            let position = (1e3 / fps, f_rate_percent);
            marks.push(Mark::diamond(position, mark.color()));
            let (side, aside_px) = if position.0 > TURN_MS { (HPos::Right, -9) } else { (HPos::Left, 9) };
            let style = text_style(SMALL_TEXT_PX - 2, side, VPos::Center);
            marks.push(Mark::text(position, [aside_px, 0], &row.name, style));
        }
        marks.extend(row.percent.map(|it| mark.marker((*ms, it))));
    }
    let times = Scale::Logarithmic([shortest_ms, longest_ms]);
    let x = Axis { title: "time a scan (ms)".to_owned(), scale: times, n_ticks: 8, labels: Labels::Numbers };
    let chart = Chart { frame: FRAME, ..Chart::new(x, Axis::linear(rate, percent, 6), marks) };
    let heading = Mark::text((52.0, 10.0), [0, 0], title, bold_style(SMALL_TEXT_PX));
    let texts = timed.iter().map(|(row, ms)| format!("{} {} in {ms:.1} ms", row.name, row.value_text()));
    let [width_px, height_px] = SIZE_PX;
    let mut around = vec![heading];
    around.extend(caveat.map(|it| {
        let style = text_style(SMALL_TEXT_PX, HPos::Right, VPos::Center);
        Mark::text((f64::from(width_px) - 14.0, 10.0), [0, 0], format!("intervals {it}"), style)
    }));
    let rows = vec![(height_px, vec![Panel { marks: around, chart: Some(chart) }])];
    let about = format!("{title}: {rate} over time a scan: {}", texts.collect::<Vec<_>>().join(", "));
    Some(Figure { width_px, heading_px: 0, heading: Vec::new(), rows }.panel(about))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    fn row(name: &str, percent: Option<f64>) -> RankingRow {
        let interval_percent = percent.map(|it| [it - 3.0, it + 3.0]);
        RankingRow { name: name.to_owned(), detector_idx: 0, percent, interval_percent, published: None }
    }

    #[test]
    fn rates_stand_over_times_beside_the_time_of_a_turn() {
        let published = Some(PaperScore { f_rate_percent: 83.0, fps: 2.0 });
        let rows = [
            (RankingRow { published, ..row("grid", Some(61.04)) }, Some(12.0)),
            (row("tree", None), Some(30.0)),
            (row("pca", Some(50.0)), Some(240.0)),
        ];
        let panel = rate_time_plot("Task objects", "F-rate (%)", None, &rows).unwrap();
        assert_eq!(
            panel.label,
            "Task objects: F-rate (%) over time a scan: grid 61.0 % in 12.0 ms, tree undefined in 30.0 ms, \
             pca 50.0 % in 240.0 ms"
        );
        check_holds(
            &panel.inline(),
            &[">100 ms</text>", "time a scan (ms)", "F-rate (%)", ">10</text>", ">grid</text>"],
        );
    }

    #[test]
    fn without_the_time_of_each_there_is_no_panel() {
        assert_eq!(rate_time_plot("", "", None, &[(row("grid", Some(61.0)), None)]), None);
        assert_eq!(rate_time_plot("", "", None, &[(row("grid", None), Some(3.0))]), None);
    }
}
