//! The plot of what a classifier gains and loses as its threshold falls.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::style::{
    Area, Drawn, LEFT_COLOR, LEFT_MARGIN_PX, LEFT_ROOM_PX, LINE_WIDTH_PX, QUIET_COLOR, RIGHT_ROOM_PX,
    TEXT_PX, axis_text, text,
};
use crate::numbers::operating_curve::OperatingRow;

const WIDTH_PX: u32 = 900;
const HEIGHT_PX: u32 = 480;
const HEADING_PX: u32 = 40;

/// The plot as an SVG document: the receiver operating characteristic on the left, precision over recall on the right.
/// `title` says what was judged.
pub fn operating_plot(rows: &[OperatingRow], title: &str) -> String {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (WIDTH_PX, HEIGHT_PX)).into_drawing_area();
    draw(&root, rows, title).expect("the panels have room, and memory takes all that is drawn");
    drop(root);
    svg.push('\n');
    svg
}

fn draw(root: &Area<'_>, rows: &[OperatingRow], title: &str) -> Drawn {
    root.fill(&WHITE)?;
    let (heading, panels) = root.split_vertically(HEADING_PX);
    heading.draw_text(title, &text(20, HPos::Left), ((LEFT_MARGIN_PX + LEFT_ROOM_PX) as i32, 20))?;
    let (left, right) = panels.split_horizontally(WIDTH_PX / 2);
    // A classifier that tells nothing a vehicle has the recall 0 and makes no mistake.
    let roc = std::iter::once((0.0, 0.0)).chain(rows.iter().filter_map(OperatingRow::roc_place));
    draw_panel(&left, roc.collect(), ["false-positive rate", "recall"])?;
    let precision_recall = rows.iter().filter_map(OperatingRow::precision_recall_place);
    draw_panel(&right, precision_recall.collect(), ["recall", "precision"])?;
    root.present()
}

fn draw_panel(area: &Area<'_>, places: Vec<(f64, f64)>, [x_name, y_name]: [&str; 2]) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .margin_left(LEFT_MARGIN_PX)
        .margin_right(RIGHT_ROOM_PX)
        .margin_top(8)
        .set_label_area_size(LabelAreaPosition::Left, LEFT_ROOM_PX)
        .x_label_area_size(46)
        .build_cartesian_2d(-0.01..1.01, -0.01..1.01)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(QUIET_COLOR)
        .x_labels(6)
        .y_labels(6)
        .x_label_formatter(&|value| axis_text(*value))
        .y_label_formatter(&|value| axis_text(*value))
        .x_desc(x_name)
        .y_desc(y_name)
        .label_style(text(TEXT_PX, HPos::Center))
        .axis_desc_style(text(TEXT_PX, HPos::Center))
        .draw()?;
    chart.draw_series(LineSeries::new(places, LEFT_COLOR.stroke_width(LINE_WIDTH_PX)))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_panels_have_axes_and_the_title_says_what_was_judged() {
        let rows = [([1, 0], 0.5), ([1, 2], -0.5)]
            .map(|(told, threshold)| OperatingRow::new(threshold, told, [1, 2]));
        let svg = operating_plot(&rows, "Held out (simulated)");
        for part in ["false-positive rate", "recall", "precision", "Held out (simulated)"] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        assert_ne!(svg, operating_plot(&[], "Held out (simulated)"));
    }
}
