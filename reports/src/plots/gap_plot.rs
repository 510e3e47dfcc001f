//! The plot of how many pairs are separated, by gap.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::series_marks::SeriesMark;
use super::style::{
    Area, Drawn, LEFT_MARGIN_PX, LEFT_ROOM_PX, LINE_WIDTH_PX, QUIET_COLOR, RIGHT_ROOM_PX, TEXT_PX, axis_text,
    text,
};
use crate::numbers::gap_curve::GapCurve;
use crate::tables::studies::gap_table::curves_by_range;

const WIDTH_PX: u32 = 900;
const PANEL_PX: u32 = 270;
const KEY_LINE_PX: i32 = 22;

/// The plot as an SVG document: a panel for each range with a curve for each detector, and the 95 % interval of every
/// share. `title` says what the pairs are, and that they are simulated.
pub fn gap_plot(curves: &[GapCurve], title: &str) -> String {
    let ranges = curves_by_range(curves);
    let n_series = ranges.iter().map(Vec::len).max().unwrap_or(0);
    let heading_px = 40 + KEY_LINE_PX as u32 * n_series as u32 + 10;
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (WIDTH_PX, heading_px + PANEL_PX * ranges.len() as u32))
        .into_drawing_area();
    draw(&root, &ranges, heading_px, title)
        .expect("the panels have room, and memory takes all that is drawn");
    drop(root);
    svg.push('\n');
    svg
}

fn draw(root: &Area<'_>, ranges: &[Vec<&GapCurve>], heading_px: u32, title: &str) -> Drawn {
    root.fill(&WHITE)?;
    let (heading, panels) = root.split_vertically(heading_px);
    if let Some(of_range) = ranges.first() {
        draw_key(&heading, of_range, title)?;
        for (panel, of_range) in panels.split_evenly((ranges.len(), 1)).iter().zip(ranges) {
            draw_panel(panel, of_range)?;
        }
    }
    root.present()
}

fn draw_key(area: &Area<'_>, curves: &[&GapCurve], title: &str) -> Drawn {
    let left_px = (LEFT_MARGIN_PX + LEFT_ROOM_PX) as i32;
    area.draw_text(title, &text(20, HPos::Left), (left_px, 20))?;
    for (series, curve) in curves.iter().enumerate() {
        let (mark, y_px) = (SeriesMark(series), 50 + KEY_LINE_PX * series as i32);
        let style = mark.color().stroke_width(LINE_WIDTH_PX);
        let end_px = left_px + 54;
        let [dash_px, gap_px] = mark.dashes_px().unwrap_or([54, 1]);
        for from_px in (left_px..end_px).step_by((dash_px + gap_px) as usize) {
            area.draw(&PathElement::new(
                vec![(from_px, y_px), ((from_px + dash_px).min(end_px), y_px)],
                style,
            ))?;
        }
        area.draw(&mark.marker((i32::midpoint(left_px, end_px), y_px)))?;
        area.draw_text(&curve.detector, &text(TEXT_PX, HPos::Left), (end_px + 12, y_px))?;
    }
    Ok(())
}

fn draw_panel(area: &Area<'_>, curves: &[&GapCurve]) -> Drawn {
    let gaps_m = curves.iter().flat_map(|it| &it.points).map(|(gap_m, _)| *gap_m);
    let (least_m, most_m) =
        gaps_m.fold((f64::INFINITY, 0.0_f64), |(least, most), it| (least.min(it), most.max(it)));
    if least_m > most_m {
        return Ok(());
    }
    let [from_m, to_m] = curves[0].range_m;
    let mut chart = ChartBuilder::on(area)
        .margin_left(LEFT_MARGIN_PX)
        .margin_right(RIGHT_ROOM_PX)
        .margin_top(8)
        .set_label_area_size(LabelAreaPosition::Left, LEFT_ROOM_PX)
        .x_label_area_size(46)
        .build_cartesian_2d(least_m - 0.06..most_m + 0.06, -3.0..103.0)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(QUIET_COLOR)
        .x_labels(12)
        .y_labels(6)
        .x_label_formatter(&|value| axis_text(*value))
        .y_label_formatter(&|value| axis_text(*value))
        .x_desc(format!("gap (m), pairs {from_m} to {to_m} m from the sensor"))
        .y_desc("separated (%)")
        .label_style(text(TEXT_PX, HPos::Center))
        .axis_desc_style(text(TEXT_PX, HPos::Center))
        .draw()?;
    for (series, curve) in curves.iter().enumerate() {
        let mark = SeriesMark(series);
        // A little apart, so that intervals do not hide each other.
        let aside_m = 0.008 * (series as f64 - (curves.len() as f64 - 1.0) / 2.0);
        let judged = curve.points.iter().filter_map(|(gap_m, counts)| {
            let [low, high] = counts.separated_within()?;
            Some((gap_m + aside_m, counts.separated()? * 100.0, [low * 100.0, high * 100.0]))
        });
        let judged: Vec<_> = judged.collect();
        let line = judged.iter().map(|&(x_m, share, _)| (x_m, share));
        let style = mark.color().stroke_width(LINE_WIDTH_PX);
        match mark.dashes_px() {
            None => chart.draw_series(LineSeries::new(line, style))?,
            Some([dash_px, gap_px]) => {
                chart.draw_series(DashedLineSeries::new(line, dash_px, gap_px, style))?
            }
        };
        let thin = mark.color().stroke_width(1);
        let bars =
            judged.iter().map(|&(x_m, _, [low, high])| PathElement::new(vec![(x_m, low), (x_m, high)], thin));
        chart.draw_series(bars)?;
        chart.draw_series(judged.iter().map(|&(x_m, share, _)| mark.marker((x_m, share))))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::gap_curve::gap_curves;
    use crate::numbers::gap_curve::tests::bin;

    #[test]
    fn axes_have_units_and_curves_have_names() {
        let bins = [
            bin("simple-grid", "cars", false, 0.2, 3),
            bin("simple-grid", "cars", false, 0.3, 9),
            bin("kd-tree", "cars", true, 0.2, 1),
            bin("simple-grid", "cars", true, 0.2, 1),
        ];
        let svg = gap_plot(&gap_curves(&bins), "Pairs of cars (simulated)");
        for part in [
            "gap (m), pairs 5 to 10 m",
            "10 to 20 m",
            "separated (%)",
            "Pairs of cars (simulated)",
            "simple-grid",
        ] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        assert_eq!(svg, gap_plot(&gap_curves(&bins), "Pairs of cars (simulated)"));
    }

    #[test]
    fn nothing_put_up_can_be_drawn() {
        assert!(gap_plot(&[], "Nothing").contains("</svg>"));
        let mut unseen = bin("grid", "cars", true, 0.3, 0);
        unseen.counts.n_seen = 0;
        assert!(gap_plot(&gap_curves(&[unseen]), "Nothing").contains("</svg>"));
    }
}
