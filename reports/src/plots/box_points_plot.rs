//! All points of a class, laid over one another in the frames of boxes.

use plotters::style::RGBColor;

use super::figure::{Axis, Chart, Figure, Frame, Grid, Panel, TEXT_PX, USUAL_FRAME};
use super::marks::{LINE_WIDTH_PX, Mark, color};
use super::palette::{N_SHADES, VERMILION, shade_hue};
use crate::numbers::box_points::{Across, BoxPoints, CELL_M};

const PANEL_WIDTH_PX: u32 = 420;
const HEADING_PX: u32 = 44;
/// Room of a panel for its caption and the titles of its axes.
const AROUND_PX: u32 = 84;
const LEFT_PX: u32 = 52;
const FRAME: Frame = Frame {
    margins_px: [0, 16, 0, 8],
    room_px: [44, LEFT_PX - 8],
    text_px: [TEXT_PX - 2, TEXT_PX - 2],
    grid: Grid::None,
    ..USUAL_FRAME
};
/// Room beyond each side of the box, as a share of its length and of its width.
const BEYOND: [f64; 2] = [0.3, 0.5];

/// The panels of each class in a row, to the same scale within the row, as an SVG document. `title` says what is shown, and
/// whether it is simulated.
pub fn box_points_plot(rows: &[Vec<BoxPoints>], title: &str) -> String {
    let widest = rows.iter().map(Vec::len).max().unwrap_or(0).max(1) as u32;
    let row = |points: &Vec<BoxPoints>| {
        let half_m = half_window_m(points);
        (row_height_px(half_m), points.iter().map(|it| panel(it, half_m)).collect())
    };
    let figure = Figure {
        width_px: PANEL_WIDTH_PX * widest,
        heading_px: HEADING_PX,
        heading: vec![Mark::title(title, (16.0, 24.0))],
        rows: rows.iter().map(row).collect(),
    };
    figure.svg(title)
}

/// Half of the window along and across, in metres: half of the largest box of the row, and some room.
fn half_window_m(row: &[BoxPoints]) -> [f64; 2] {
    std::array::from_fn(|axis| {
        let largest_m = row.iter().map(|it| it.length_width_m[axis]).fold(0.1, f64::max);
        largest_m * (0.5 + BEYOND[axis])
    })
}

/// Height of a row, in pixels, in which a metre is as long along as across.
fn row_height_px([half_length_m, half_width_m]: [f64; 2]) -> u32 {
    let width_px = f64::from(PANEL_WIDTH_PX - LEFT_PX - 24);
    (width_px * half_width_m / half_length_m) as u32 + AROUND_PX
}

fn panel(points: &BoxPoints, [half_length_m, half_width_m]: [f64; 2]) -> Panel {
    let is_shown = |[x, y]: [i32; 2]| {
        let within = |it: i32, half_m: f64| {
            let [from_m, to_m] = [it, it + 1].map(|it| f64::from(it) * CELL_M);
            from_m >= -half_m && to_m <= half_m
        };
        within(x, half_length_m) && within(y, half_width_m)
    };
    let fullest = points.shares.values().copied().fold(0.0, f64::max);
    let shaded = points.shares.iter().filter(|(cell, _)| is_shown(**cell));
    let shaded = shaded.filter_map(|(&cell, share)| Some((cell, shade(share / fullest)?)));
    let cells = columns(shaded).into_iter().map(|column| {
        let side = |it: i32| f64::from(it) * CELL_M;
        let corners = [(side(column.x), side(column.from)), (side(column.x + 1), side(column.to))];
        Mark::rectangle(corners, color_of(column.shade))
    });
    let mut marks: Vec<Mark> = cells.collect();
    let [length_m, width_m] = points.length_width_m.map(|it| 0.5 * it);
    marks.push(Mark::outline([(-length_m, -width_m), (length_m, width_m)], color(VERMILION)));
    // Its front.
    let front = [(length_m, -width_m), (length_m, width_m)];
    marks.push(Mark::line(front, color(VERMILION), 2 * LINE_WIDTH_PX));
    let caption = format!("{}, {} (n {})", points.class.name(), points.frame, points.n_vehicles);
    let x = Axis::linear("to the front (m)", [-half_length_m, half_length_m], 7);
    let across = match points.across {
        Across::Left => "to the left (m)",
        Across::Up => "up (m)",
    };
    let y = Axis::linear(across, [-half_width_m, half_width_m], 5);
    let caption = Some((caption, TEXT_PX + 1));
    Chart { caption, frame: FRAME, ..Chart::new(x, y, marks) }.into()
}

/// Shade of a cell, 1 to [`N_SHADES`], by its share of the fullest cell. Each shade stands for half the share of the next
/// one; `None` below the first.
fn shade(of_fullest: f64) -> Option<u32> {
    let steps_below = (-of_fullest.log2()).floor();
    (steps_below < f64::from(N_SHADES)).then(|| N_SHADES - steps_below.max(0.0) as u32)
}

/// Colour of a shade, without transparency, which would make files large.
fn color_of(shade: u32) -> RGBColor {
    color(shade_hue(shade).on_light)
}

/// Neighbouring cells of one shade above one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ShadedColumn {
    x: i32,
    /// The first cell; `to` is the one after the last.
    from: i32,
    to: i32,
    shade: u32,
}

/// Joins neighbouring cells of one shade, so that the file stays small. The cells must come column by column.
fn columns(cells: impl Iterator<Item = ([i32; 2], u32)>) -> Vec<ShadedColumn> {
    let mut columns: Vec<ShadedColumn> = Vec::new();
    for ([x, y], shade) in cells {
        match columns.last_mut().filter(|it| (it.x, it.to, it.shade) == (x, y, shade)) {
            Some(column) => column.to = y + 1,
            None => columns.push(ShadedColumn { x, from: y, to: y + 1, shade }),
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
    use crate::numbers::box_points::FramedPoints;
    use crate::plots::theme::hex;
    use crate::vocabulary::class::AnnotationClass;

    #[test]
    fn panels_have_titles_units_and_a_box() {
        let positions_m = [[2.0, 0.1], [2.0, 0.2], [2.0, 0.2], [90.0, 0.0]];
        let framed = FramedPoints { length_width_m: [4.0, 2.0], positions_m: &positions_m };
        let points = BoxPoints::of(AnnotationClass::Car, "hull box", [framed].into_iter());
        let svg = box_points_plot(&[vec![points.clone(), points]], "Streets (simulated)");
        check_holds(&svg, &["Streets (simulated)", "car, hull box (n 1)", "to the front (m)"]);
        // In each panel the fullest cell and one half as full; far cells in none.
        let n_of_shade = |it: u32| {
            let RGBColor(red, green, blue) = color_of(it);
            svg.matches(&format!("fill=\"{}\"", hex([red, green, blue]))).count()
        };
        assert_eq!([N_SHADES, N_SHADES - 1].map(n_of_shade), [2, 2], "{svg}");
        assert!(box_points_plot(&[], "Nothing").contains("</svg>"));
    }

    #[test]
    fn shades_halve() {
        assert_eq!([1.0, 0.9, 0.5, 0.26, 0.0].map(shade), [Some(7), Some(7), Some(6), Some(6), None]);
    }

    #[test]
    fn neighbours_of_one_shade_are_one() {
        let cells = [([0, 0], 1), ([0, 1], 1), ([0, 3], 1), ([0, 4], 2), ([1, 5], 2)];
        let joined: Vec<[i32; 3]> =
            columns(cells.into_iter()).iter().map(|it| [it.x, it.from, it.to]).collect();
        assert_eq!(joined, [[0, 0, 2], [0, 3, 4], [0, 4, 5], [1, 5, 6]]);
    }
}
