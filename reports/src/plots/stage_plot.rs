//! How long the stages of a detector take.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::series_marks::SeriesMark;
use super::small_panel::{SMALL_TEXT_PX, WIDTH_PX, small_text};
use super::style::{Area, Drawn};
use super::themed_svg::ThemedPanel;
use crate::files::fixed_decimals::three_digits;

const HEADING_PX: u32 = 24;
const ROW_PX: u32 = 22;
/// Room for the names of stages, and for the times.
const NAMES_PX: i32 = 104;
const TIMES_PX: i32 = 70;

/// A panel with a bar for every stage, whose median times are in milliseconds, in the order of the stages. Bars are to the
/// scale of the longest of the panel.
pub fn stage_plot(detector: &str, detector_idx: usize, stages: &[(String, f64)]) -> ThemedPanel {
    let size_px = (WIDTH_PX, HEADING_PX + ROW_PX * stages.len().max(1) as u32 + 4);
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, size_px).into_drawing_area();
    draw(&root, detector, detector_idx, stages)
        .expect("the panel has room, and memory takes all that is drawn");
    drop(root);
    let stages: Vec<String> =
        stages.iter().map(|(name, ms)| format!("{} {}", words(name), time_text(*ms))).collect();
    let label = format!("median times of the stages of {detector}: {}", stages.join(", "));
    ThemedPanel::of_library(&svg, size_px.into(), label)
}

/// A time with its unit; what is not worth digits has none.
fn time_text(ms: f64) -> String {
    if ms < 0.001 { "< 0.001 ms".to_owned() } else { format!("{} ms", three_digits(ms)) }
}

/// The name of a stage as people write it.
fn words(stage: &str) -> String {
    stage.replace('_', " ")
}

fn draw(root: &Area<'_>, detector: &str, detector_idx: usize, stages: &[(String, f64)]) -> Drawn {
    let bold: TextStyle<'static> = ("sans-serif", SMALL_TEXT_PX, FontStyle::Bold).into_font().color(&BLACK);
    root.draw_text(detector, &bold.pos(Pos::new(HPos::Left, VPos::Center)), (2, 11))?;
    let longest_ms = stages.iter().map(|(_, ms)| *ms).fold(0.0, f64::max);
    let room_px = f64::from(WIDTH_PX as i32 - NAMES_PX - TIMES_PX);
    let color = SeriesMark(detector_idx).color();
    for ((stage, ms), y_px) in stages.iter().zip((HEADING_PX as i32..).step_by(ROW_PX as usize)) {
        let middle_px = y_px + ROW_PX as i32 / 2;
        root.draw_text(&words(stage), &small_text(HPos::Right, VPos::Center), (NAMES_PX - 8, middle_px))?;
        // What is too short to be seen is a hair line.
        let long_px = if longest_ms > 0.0 { (room_px * ms / longest_ms).round().max(1.0) as i32 } else { 1 };
        let corners = [(NAMES_PX, y_px + 4), (NAMES_PX + long_px, y_px + ROW_PX as i32 - 4)];
        root.draw(&Rectangle::new(corners, color.filled()))?;
        let time = time_text(*ms);
        let place = (NAMES_PX + long_px + 6, middle_px);
        root.draw_text(&time, &small_text(HPos::Left, VPos::Center), place)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_have_names_and_times() {
        let stages = [("dense_level", 0.31), ("walls", 0.000_58), ("boxes", 0.0)];
        let panel = stage_plot("grid", 0, &stages.map(|(name, ms)| (name.to_owned(), ms)));
        assert_eq!(
            panel.label,
            "median times of the stages of grid: dense level 0.310 ms, walls < 0.001 ms, boxes < 0.001 ms"
        );
        for part in ["dense level", "0.310 ms", "&lt; 0.001 ms", "f-d0"] {
            assert!(panel.inline().contains(part), "no {part} in {panel:?}");
        }
    }
}
