//! Plans: positions and outlines seen from above, side by side for several detectors.

use plotters::style::RGBColor;

use super::figure::{Axis, Chart, Figure, Frame, Grid, Panel, TEXT_PX, USUAL_FRAME};
use super::marks::{BLACK, LINE_WIDTH_PX, Mark, QUIET, SeriesMark};

/// One panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Title above the panel.
    pub title: String,
    /// Groups of positions in metres; each group has its own marker.
    pub groups: Vec<Vec<[f64; 2]>>,
    /// Closed outlines in metres; the first corner is not repeated.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Sides of the cells of the drawn grids, in metres, the widest last; cell corners are whole numbers of sides from
    /// `grid_origin_m`.
    pub cell_sizes_m: Vec<f64>,
    /// A corner of the grids.
    pub grid_origin_m: [f64; 2],
}

const PANEL_PX: u32 = 480;
const HEADING_PX: u32 = 44;
/// Room around the positions, in metres.
const ROOM_M: f64 = 0.6;

/// The panels side by side, to the same scale, as an SVG document. `title` says what is shown, and whether it is simulated.
pub fn plan_plot(plans: &[Plan], title: &str) -> String {
    let window = window_m(plans);
    let panels = plans.iter().map(|it| window.map_or_else(Panel::default, |window| panel(it, window)));
    let figure = Figure {
        width_px: PANEL_PX * plans.len().max(1) as u32,
        heading_px: HEADING_PX,
        heading: vec![Mark::title(title, (16.0, 24.0))],
        rows: vec![(PANEL_PX, panels.collect())],
    };
    figure.svg(title)
}

/// The square around all positions: its ends in x and in y; `None` if there are none.
fn window_m(plans: &[Plan]) -> Option<[[f64; 2]; 2]> {
    let positions = plans.iter().flat_map(|it| it.groups.iter().chain(&it.outlines)).flatten();
    let ends = positions.fold([[f64::INFINITY, f64::NEG_INFINITY]; 2], |ends, position| {
        [0, 1].map(|axis| [ends[axis][0].min(position[axis]), ends[axis][1].max(position[axis])])
    });
    let half_m = ends.iter().map(|[from, to]| (to - from) / 2.0).fold(0.0, f64::max) + ROOM_M;
    let window = ends.map(|[from, to]| [f64::midpoint(from, to) - half_m, f64::midpoint(from, to) + half_m]);
    window.iter().flatten().all(|it| it.is_finite()).then_some(window)
}

fn panel(plan: &Plan, [x, y]: [[f64; 2]; 2]) -> Panel {
    let mut marks = grid_marks(plan, [x, y]);
    for (group, positions) in plan.groups.iter().enumerate() {
        marks.extend(positions.iter().map(|&[x, y]| SeriesMark(group).marker((x, y))));
    }
    let closed = |outline: &Vec<[f64; 2]>| {
        let corners = outline.iter().chain(outline.first()).map(|&[x, y]| (x, y));
        Mark::line(corners, BLACK, LINE_WIDTH_PX)
    };
    marks.extend(plan.outlines.iter().map(closed));
    let x = Axis::linear("forward of the sensor (m)", x, 8);
    let y = Axis::linear("left of the sensor (m)", y, 8);
    let chart = Chart {
        caption: Some((plan.title.clone(), TEXT_PX + 2)),
        frame: Frame { margins_px: [12; 4], room_px: [40, 56], grid: Grid::None, ..USUAL_FRAME },
        ..Chart::new(x, y, marks)
    };
    chart.into()
}

/// The grids of all sizes; the widest is darker.
fn grid_marks(plan: &Plan, [x, y]: [[f64; 2]; 2]) -> Vec<Mark> {
    let mut marks = Vec::new();
    for (level, &size_m) in plan.cell_sizes_m.iter().enumerate() {
        let is_widest = level + 1 == plan.cell_sizes_m.len();
        let color = if is_widest { RGBColor(130, 130, 130) } else { QUIET };
        let steps = |axis: usize, [from, to]: [f64; 2]| {
            let origin_m = plan.grid_origin_m[axis];
            let (first, last) =
                (((from - origin_m) / size_m).ceil() as i64, ((to - origin_m) / size_m).floor() as i64);
            (first..=last).map(move |step| origin_m + step as f64 * size_m)
        };
        marks.extend(steps(0, x).map(|at| Mark::line([(at, y[0]), (at, y[1])], color, 1)));
        marks.extend(steps(1, y).map(|at| Mark::line([(x[0], at), (x[1], at)], color, 1)));
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

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
        check_holds(
            &svg,
            &["one", "other", "Pair (simulated)", "forward of the sensor (m)", "left of the sensor (m)"],
        );
        assert!(plan_plot(&[], "Nothing").contains("</svg>"));
    }
}
