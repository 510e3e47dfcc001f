//! The plot of the times of the stages of a detector.

use plotters::style::text_anchor::{HPos, VPos};

use super::figure::Figure;
use super::marks::{Mark, SeriesMark, bold_style, text_style};
use super::small_panel::{SMALL_TEXT_PX, WIDTH_PX};
use super::themed_panel::ThemedPanel;
use crate::files::fixed_decimals::three_digits;

const HEADING_PX: u32 = 24;
const ROW_PX: u32 = 22;
/// Room for the names of stages, least and greatest, and for the times.
const NAMES_PX: [f64; 2] = [104.0, 230.0];
const CHARACTER_PX: f64 = 8.0;
const TIMES_PX: f64 = 70.0;

/// A panel with a bar for every stage, in the order of the stages; `stages` holds their median times in milliseconds. The
/// longest bar determines the scale.
pub fn stage_plot(detector: &str, detector_idx: usize, stages: &[(String, f64)]) -> ThemedPanel {
    let size_px = [WIDTH_PX, HEADING_PX + ROW_PX * stages.len().max(1) as u32 + 4];
    let of_stages = marks(detector, SeriesMark(detector_idx), stages);
    let stages: Vec<String> =
        stages.iter().map(|(name, ms)| format!("{} {}", words(name), time_text(*ms))).collect();
    let label = format!("median times of the stages of {detector}: {}", stages.join(", "));
    Figure::of_marks(size_px, of_stages).panel(label)
}

/// A time with its unit; one below 0.001 ms has no digits of its own.
fn time_text(ms: f64) -> String {
    if ms < 0.001 { "< 0.001 ms".to_owned() } else { format!("{} ms", three_digits(ms)) }
}

/// The name of a stage as people write it.
fn words(stage: &str) -> String {
    stage.replace('_', " ")
}

fn marks(detector: &str, series: SeriesMark, stages: &[(String, f64)]) -> Vec<Mark> {
    let text = |x_px: f64, y_px: f64, text: String, horizontal: HPos| {
        Mark::text((x_px, y_px), [0, 0], text, text_style(SMALL_TEXT_PX, horizontal, VPos::Center))
    };
    let mut marks = vec![Mark::text((2.0, 11.0), [0, 0], detector, bold_style(SMALL_TEXT_PX))];
    let longest_ms = stages.iter().map(|(_, ms)| *ms).fold(0.0, f64::max);
    let longest_name = stages.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let names_px = (CHARACTER_PX * longest_name as f64 + 8.0).clamp(NAMES_PX[0], NAMES_PX[1]);
    let room_px = f64::from(WIDTH_PX) - names_px - TIMES_PX;
    for ((stage, ms), top_px) in stages.iter().zip((HEADING_PX..).step_by(ROW_PX as usize)) {
        let [top_px, row_px] = [top_px, ROW_PX].map(f64::from);
        let middle_px = top_px + row_px / 2.0;
        marks.push(text(names_px - 8.0, middle_px, words(stage), HPos::Right));
        // A bar that is too short to be seen becomes a hair line.
        let long_px = if longest_ms > 0.0 { (room_px * ms / longest_ms).round().max(1.0) } else { 1.0 };
        let corners = [(names_px, top_px + 4.0), (names_px + long_px, top_px + row_px - 4.0)];
        marks.push(Mark::rectangle(corners, series.color()));
        marks.push(text(names_px + long_px + 6.0, middle_px, time_text(*ms), HPos::Left));
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    #[test]
    fn stages_have_names_and_times() {
        let stages = [("dense_level", 0.31), ("walls", 0.000_58), ("boxes", 0.0)];
        let panel = stage_plot("grid", 0, &stages.map(|(name, ms)| (name.to_owned(), ms)));
        assert_eq!(
            panel.label,
            "median times of the stages of grid: dense level 0.310 ms, walls < 0.001 ms, boxes < 0.001 ms"
        );
        check_holds(&panel.inline(), &["dense level", "0.310 ms", "&lt; 0.001 ms", "f-d0"]);
    }
}
