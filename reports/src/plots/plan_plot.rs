//! What stands where, seen from above, as several detectors see it.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::series_marks::SeriesMark;
use super::style::{Area, Drawn, LINE_WIDTH_PX, QUIET_COLOR, TEXT_PX, axis_text, text};

/// One panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What stands above it.
    pub title: String,
    /// Places that belong together, in metres: a marker of its own for each group.
    pub groups: Vec<Vec<[f64; 2]>>,
    /// Closed outlines in metres; the first corner is not repeated.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Sides of cells whose grid is drawn, in metres, the widest last; cell corners lie at whole numbers of sides from
    /// `grid_origin_m`.
    pub cell_sizes_m: Vec<f64>,
    /// A corner of the grids.
    pub grid_origin_m: [f64; 2],
}

const PANEL_PX: u32 = 480;
const HEADING_PX: u32 = 44;
/// Room around what is drawn, in metres.
const ROOM_M: f64 = 0.6;

/// The panels side by side, to the same scale, as an SVG document. `title` says what is shown, and whether it is simulated.
pub fn plan_plot(plans: &[Plan], title: &str) -> String {
    let mut svg = String::new();
    let size_px = (PANEL_PX * plans.len().max(1) as u32, HEADING_PX + PANEL_PX);
    let root = SVGBackend::with_string(&mut svg, size_px).into_drawing_area();
    draw(&root, plans, title).expect("the panels have room, and memory takes all that is drawn");
    drop(root);
    svg.push('\n');
    svg
}

fn draw(root: &Area<'_>, plans: &[Plan], title: &str) -> Drawn {
    root.fill(&WHITE)?;
    let (heading, panels) = root.split_vertically(HEADING_PX);
    heading.draw_text(title, &text(20, HPos::Left), (16, 24))?;
    if let Some(window) = window_m(plans) {
        for (panel, plan) in panels.split_evenly((1, plans.len())).iter().zip(plans) {
            draw_plan(panel, plan, window)?;
        }
    }
    root.present()
}

/// The square around all places: from, to in x and y; `None` if there are none.
fn window_m(plans: &[Plan]) -> Option<[[f64; 2]; 2]> {
    let places = plans.iter().flat_map(|it| it.groups.iter().chain(&it.outlines)).flatten();
    let ends = places.fold([[f64::INFINITY, f64::NEG_INFINITY]; 2], |ends, place| {
        [0, 1].map(|axis| [ends[axis][0].min(place[axis]), ends[axis][1].max(place[axis])])
    });
    let half_m = ends.iter().map(|[from, to]| (to - from) / 2.0).fold(0.0, f64::max) + ROOM_M;
    let window = ends.map(|[from, to]| [f64::midpoint(from, to) - half_m, f64::midpoint(from, to) + half_m]);
    window.iter().flatten().all(|it| it.is_finite()).then_some(window)
}

fn draw_plan(area: &Area<'_>, plan: &Plan, [x, y]: [[f64; 2]; 2]) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .caption(&plan.title, text(TEXT_PX + 2, HPos::Left))
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(x[0]..x[1], y[0]..y[1])?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(8)
        .y_labels(8)
        .x_label_formatter(&|value| axis_text(*value))
        .y_label_formatter(&|value| axis_text(*value))
        .x_desc("forward of the sensor (m)")
        .y_desc("left of the sensor (m)")
        .label_style(text(TEXT_PX, HPos::Center))
        .axis_desc_style(text(TEXT_PX, HPos::Center))
        .draw()?;
    for (level, &size_m) in plan.cell_sizes_m.iter().enumerate() {
        let is_widest = level + 1 == plan.cell_sizes_m.len();
        let style =
            if is_widest { RGBColor(130, 130, 130).stroke_width(1) } else { QUIET_COLOR.stroke_width(1) };
        let steps = |axis: usize, [from, to]: [f64; 2]| {
            let origin_m = plan.grid_origin_m[axis];
            let (first, last) =
                (((from - origin_m) / size_m).ceil() as i64, ((to - origin_m) / size_m).floor() as i64);
            (first..=last).map(move |step| origin_m + step as f64 * size_m)
        };
        let upright = steps(0, x).map(|at| PathElement::new(vec![(at, y[0]), (at, y[1])], style));
        let level = steps(1, y).map(|at| PathElement::new(vec![(x[0], at), (x[1], at)], style));
        chart.draw_series(upright.chain(level))?;
    }
    for (group, places) in plan.groups.iter().enumerate() {
        chart.draw_series(places.iter().map(|&[x, y]| SeriesMark(group).marker((x, y))))?;
    }
    let closed = |outline: &Vec<[f64; 2]>| {
        let corners = outline.iter().chain(outline.first()).map(|&[x, y]| (x, y)).collect::<Vec<_>>();
        PathElement::new(corners, BLACK.stroke_width(LINE_WIDTH_PX))
    };
    chart.draw_series(plan.outlines.iter().map(closed))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_have_titles_units_and_the_same_window() {
        let plan = |title: &str, groups| Plan {
            title: title.to_owned(),
            groups,
            outlines: vec![vec![[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]],
            cell_sizes_m: vec![0.2, 0.6],
            grid_origin_m: [0.0; 2],
        };
        let plans = [plan("one", vec![vec![[1.0, 1.0]], vec![[3.0, 2.0]]]), plan("other", vec![])];
        let window = window_m(&plans).unwrap();
        assert!(
            window.iter().flatten().zip([0.4, 3.6, -0.1, 3.1]).all(|(a, b)| (a - b).abs() < 1e-9),
            "{window:?}"
        );
        let svg = plan_plot(&plans, "Pair (simulated)");
        for part in
            ["one", "other", "Pair (simulated)", "forward of the sensor (m)", "left of the sensor (m)"]
        {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        assert!(plan_plot(&[], "Nothing").contains("</svg>"));
    }
}
