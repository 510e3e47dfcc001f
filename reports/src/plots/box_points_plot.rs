//! All points of a class, laid over one another in the frames of boxes.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::style::{Area, Drawn, LEFT_COLOR, LINE_WIDTH_PX, RIGHT_COLOR, TEXT_PX, axis_text, outline, text};
use crate::numbers::box_points::{BoxPoints, CELL_M};

const PANEL_WIDTH_PX: u32 = 420;
const HEADING_PX: u32 = 44;
/// Room of a panel for its caption and the description of its axes.
const AROUND_PX: u32 = 84;
const LEFT_PX: u32 = 52;
/// What is shown beyond the box, as a share of its length and of its width.
const BEYOND: [f64; 2] = [0.3, 0.5];
/// Shades of the cells. The darkest is for the fullest, and each holds half of what the next one does.
const N_SHADES: u32 = 7;

/// The panels of each class in a row, to the same scale within the row, as an SVG document. `title` says what is shown, and whether it is simulated.
pub fn box_points_plot(rows: &[Vec<BoxPoints>], title: &str) -> String {
    let widest = rows.iter().map(Vec::len).max().unwrap_or(0).max(1) as u32;
    let heights_px: Vec<u32> = rows.iter().map(|it| row_height_px(it)).collect();
    let size_px = (PANEL_WIDTH_PX * widest, HEADING_PX + heights_px.iter().sum::<u32>());
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, size_px).into_drawing_area();
    draw(&root, rows, &heights_px, title).expect("the panels have room, and memory takes all that is drawn");
    drop(root);
    svg.push('\n');
    svg
}

fn draw(root: &Area<'_>, rows: &[Vec<BoxPoints>], heights_px: &[u32], title: &str) -> Drawn {
    root.fill(&WHITE)?;
    let (heading, mut rest) = root.split_vertically(HEADING_PX);
    heading.draw_text(title, &text(20, HPos::Left), (16, 24))?;
    for (row, height_px) in rows.iter().zip(heights_px) {
        let (here, below) = rest.split_vertically(*height_px);
        rest = below;
        let half_m = half_window_m(row);
        for (place, points) in row.iter().enumerate() {
            let (_, from_here) = here.split_horizontally(PANEL_WIDTH_PX * place as u32);
            let (panel, _) = from_here.split_horizontally(PANEL_WIDTH_PX);
            draw_panel(&panel, points, half_m)?;
        }
    }
    root.present()
}

/// Half of what is shown along and across, in metres: the largest box of the row and some room.
fn half_window_m(row: &[BoxPoints]) -> [f64; 2] {
    std::array::from_fn(|axis| {
        let largest_m = row.iter().map(|it| it.length_width_m[axis]).fold(0.1, f64::max);
        largest_m * (0.5 + BEYOND[axis])
    })
}

/// So high that a metre is as long along as across.
fn row_height_px(row: &[BoxPoints]) -> u32 {
    let [half_length_m, half_width_m] = half_window_m(row);
    let width_px = f64::from(PANEL_WIDTH_PX - LEFT_PX - 24);
    (width_px * half_width_m / half_length_m) as u32 + AROUND_PX
}

fn draw_panel(area: &Area<'_>, points: &BoxPoints, [half_length_m, half_width_m]: [f64; 2]) -> Drawn {
    let caption = format!("{}, {} (n {})", points.class.name(), points.frame, points.n_vehicles);
    let mut chart = ChartBuilder::on(area)
        .margin_left(8)
        .margin_right(16)
        .caption(caption, text(TEXT_PX + 1, HPos::Left))
        .x_label_area_size(44)
        .y_label_area_size(LEFT_PX - 8)
        .build_cartesian_2d(-half_length_m..half_length_m, -half_width_m..half_width_m)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(7)
        .y_labels(5)
        .x_label_formatter(&|value| axis_text(*value))
        .y_label_formatter(&|value| axis_text(*value))
        .x_desc("to the front (m)")
        .y_desc("to the left (m)")
        .label_style(text(TEXT_PX - 2, HPos::Center))
        .axis_desc_style(text(TEXT_PX - 2, HPos::Center))
        .draw()?;
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
    chart.draw_series(columns(shaded).into_iter().map(|column| {
        let side = |it: i32| f64::from(it) * CELL_M;
        let corners = [(side(column.x), side(column.from)), (side(column.x + 1), side(column.to))];
        Rectangle::new(corners, color_of(column.shade).filled())
    }))?;
    let [length_m, width_m] = points.length_width_m.map(|it| 0.5 * it);
    chart.draw_series([outline([(-length_m, -width_m), (length_m, width_m)], RIGHT_COLOR)])?;
    // Its front.
    let front = vec![(length_m, -width_m), (length_m, width_m)];
    chart.draw_series([PathElement::new(front, RIGHT_COLOR.stroke_width(2 * LINE_WIDTH_PX))])?;
    Ok(())
}

/// 1 to [`N_SHADES`] for what holds so much of what the fullest cell holds; nothing for less than the lightest.
fn shade(of_fullest: f64) -> Option<u32> {
    let steps_below = (-of_fullest.log2()).floor();
    (steps_below < f64::from(N_SHADES)).then(|| N_SHADES - steps_below.max(0.0) as u32)
}

/// Between white and the colour of the fullest. Without transparency, of which files become large.
fn color_of(shade: u32) -> RGBColor {
    let mixed = |channel: u8| (255 - (255 - u32::from(channel)) * shade / N_SHADES) as u8;
    RGBColor(mixed(LEFT_COLOR.0), mixed(LEFT_COLOR.1), mixed(LEFT_COLOR.2))
}

/// Cells of one shade above one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ShadedColumn {
    x: i32,
    /// The first cell, and the one after the last.
    from: i32,
    to: i32,
    shade: u32,
}

/// Joins neighbours of one shade, so that the file stays small. The cells come column by column.
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
    use crate::numbers::box_points::FramedPoints;
    use crate::plots::style::hex;
    use crate::vocabulary::class::AnnotationClass;

    #[test]
    fn panels_have_titles_units_and_a_box() {
        let places_m = [[2.0, 0.1], [2.0, 0.2], [2.0, 0.2], [90.0, 0.0]];
        let framed = FramedPoints { length_width_m: [4.0, 2.0], places_m: &places_m };
        let points = BoxPoints::of(AnnotationClass::Car, "hull box", [framed].into_iter());
        let svg = box_points_plot(&[vec![points.clone(), points]], "Streets (simulated)");
        for part in ["Streets (simulated)", "car, hull box (n 1)", "to the front (m)"] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        // In each panel the fullest cell, and one half as full; what lies far away in none.
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
