//! The plot of how far fitted boxes are from annotated ones.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::series_marks::SeriesMark;
use super::style::{
    Area, Drawn, LEFT_MARGIN_PX, LEFT_ROOM_PX, LINE_WIDTH_PX, QUIET_COLOR, RIGHT_ROOM_PX, TEXT_PX, axis_text,
    text,
};
use crate::numbers::box_errors::{BoxError, BoxErrorLine};

const SIZE_PX: (u32, u32) = (1000, 1126);
const HEADING_PX: u32 = 166;
const KEY_LINE_PX: i32 = 22;
/// What the slices of the panels side by side are by.
const DRAWN: [&str; 2] = ["occlusion", "range"];
/// Slices are an apart; fits of one slice stand this far from each other.
const ASIDE: f64 = 0.13;

/// The plot of `lines`, all of the same data, as an SVG document: a row of panels for each of [`BoxError::OF_SLICES`], by occlusion
/// and by range, with the 95 % interval of every number. `title` says what the data are.
pub fn box_plot(lines: &[BoxErrorLine], title: &str) -> String {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, SIZE_PX).into_drawing_area();
    draw(&root, lines, title).expect("the panels have room, and memory takes all that is drawn");
    drop(root);
    svg.push('\n');
    svg
}

fn draw(root: &Area<'_>, lines: &[BoxErrorLine], title: &str) -> Drawn {
    root.fill(&WHITE)?;
    let (heading, panels) = root.split_vertically(HEADING_PX);
    let left_px = (LEFT_MARGIN_PX + LEFT_ROOM_PX) as i32;
    heading.draw_text(title, &text(20, HPos::Left), (left_px, 20))?;
    for (series, (fit, _)) in lines.first().map_or(&[][..], |it| &it.fits).iter().enumerate() {
        let (mark, y_px) = (SeriesMark(series), 48 + KEY_LINE_PX * series as i32);
        heading.draw(&mark.marker((left_px + 8, y_px)))?;
        heading.draw_text(fit, &text(TEXT_PX, HPos::Left), (left_px + 24, y_px))?;
    }
    let rows = panels.split_evenly((BoxError::OF_SLICES.len(), 1));
    for (row, error) in rows.iter().zip(BoxError::OF_SLICES) {
        let is_drawn = |it: &&BoxErrorLine| it.error == error && DRAWN.contains(&it.by.as_str());
        let of_error = lines.iter().filter(is_drawn);
        let greatest = of_error
            .clone()
            .flat_map(|it| {
                it.fits.iter().filter_map(|(_, it)| {
                    let it = (*it)?;
                    Some(it.within.map_or(it.value, |it| it.ends[1]))
                })
            })
            .fold(0.0_f64, f64::max);
        let (left, right) = row.split_horizontally(SIZE_PX.0 / 2);
        for (panel, by) in [left, right].into_iter().zip(DRAWN) {
            let of_panel: Vec<&BoxErrorLine> = of_error.clone().filter(|it| it.by == by).collect();
            draw_panel(&panel, &of_panel, (error, by), 1.05 * greatest.max(1e-3))?;
        }
    }
    root.present()
}

fn draw_panel(area: &Area<'_>, lines: &[&BoxErrorLine], (error, by): (BoxError, &str), top: f64) -> Drawn {
    if lines.is_empty() {
        return Ok(());
    }
    let mut chart = ChartBuilder::on(area)
        .margin_left(LEFT_MARGIN_PX)
        .margin_right(RIGHT_ROOM_PX)
        .margin_top(8)
        .set_label_area_size(LabelAreaPosition::Left, LEFT_ROOM_PX)
        .x_label_area_size(46)
        .build_cartesian_2d(-0.5..lines.len() as f64 - 0.5, 0.0..top)?;
    // A label at the middle of each slice, and none between.
    let slice_name = |place: &f64| {
        let is_slice = (place - place.round()).abs() < 1e-6 && *place > -0.1;
        let line = if is_slice { lines.get(place.round() as usize) } else { None };
        line.map_or_else(String::new, |it| {
            let blocks: Vec<_> = it.fits.iter().filter_map(|(_, it)| Some((*it)?.within?.blocks)).collect();
            // As in tables: nothing rests on the interval.
            let sign = if blocks.iter().any(|it| it.may_be_neighbours()) {
                " ¶"
            } else if blocks.iter().any(|it| it.are_too_few()) {
                " §"
            } else {
                ""
            };
            format!("{} (n {}{sign})", it.slice, it.n_pairs)
        })
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(QUIET_COLOR)
        .x_labels(2 * lines.len() + 1)
        .y_labels(5)
        .x_label_formatter(&slice_name)
        .y_label_formatter(&|value| axis_text(*value))
        .x_desc(if by == "range" { "range" } else { "hidden by others" })
        .y_desc(axis_title(error))
        .label_style(text(TEXT_PX - 2, HPos::Center))
        .axis_desc_style(text(TEXT_PX, HPos::Center))
        .draw()?;
    let n_fits = lines[0].fits.len();
    for series in 0..n_fits {
        let mark = SeriesMark(series);
        let aside = ASIDE * (series as f64 - (n_fits as f64 - 1.0) / 2.0);
        let medians = (0_u32..).zip(lines).filter_map(|(place, line)| {
            let it = line.fits.get(series)?.1?;
            Some((f64::from(place) + aside, it))
        });
        let medians: Vec<_> = medians.collect();
        let style = mark.color().stroke_width(LINE_WIDTH_PX);
        let bars = medians.iter().filter_map(|&(x, it)| {
            let [low, high] = it.within?.ends;
            Some(PathElement::new(vec![(x, low), (x, high)], style))
        });
        chart.draw_series(bars)?;
        chart.draw_series(medians.iter().map(|&(x, it)| mark.marker((x, it.value))))?;
    }
    Ok(())
}

fn axis_title(error: BoxError) -> String {
    let what = if error.is_share() { "" } else { " error" };
    format!("{}{what} ({})", error.name(), error.unit())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::box_errors::tests::lines;

    #[test]
    fn axes_have_units_and_slices_their_numbers() {
        let lines = [
            lines("street", "occlusion", "none", 80),
            lines("street", "occlusion", "partly", 0),
            lines("street", "range", "0–15 m", 8),
        ]
        .concat();
        let svg = box_plot(&lines, "Streets (simulated)");
        for part in [
            "Streets (simulated)",
            "centre error (m)",
            "yaw error (deg)",
            "none (n 80)",
            "0–15 m (n 8 §)",
            "PCA box",
        ] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        assert_eq!(svg, box_plot(&lines, "Streets (simulated)"));
        assert!(box_plot(&[], "Nothing").contains("</svg>"));
    }
}
