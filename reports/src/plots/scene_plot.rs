//! The surroundings of an object, seen from above: points of the sensor, annotations, and detections of every detector.
//!
//! Forward is up. Cells are runs in one path, not marks of the drawing library, which would be ten times as long.

use std::fmt::Write as _;

use super::marks::SeriesMark;
use super::palette::{BLACK, QUIET, Rgb, YELLOW, detector_hue};
use super::theme::{Paint, hex, painted};
use super::themed_panel::{KEY_SIZE_PX, KeyEntry, ThemedPanel};
use crate::rows::match_outcome::BoxFacts;
use crate::worst::objects::PlanWindow;
use crate::worst::points::{PLAN_CELL_M, PlanCells};

const SIDE_PX: u32 = 200;
/// Radius of the disc that marks an object without a box.
const POSITION_RADIUS_PX: u32 = 14;
/// Dashes of detections that were taken for something else.
const ANOTHER_CLASS: Option<[i32; 2]> = Some([1, 3]);

/// The surroundings of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene<'a> {
    /// The window that is drawn.
    pub window: PlanWindow,
    /// Box of the object; one without extent is a position, in the middle of the window.
    pub subject: BoxFacts,
    /// Cells with points, if they were kept.
    pub cells: Option<&'a PlanCells>,
    /// Boxes of all annotations around.
    pub annotations: Vec<BoxFacts>,
    /// Boxes of all detections around.
    pub detections: Vec<SceneDetection>,
}

/// A box of a detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneDetection {
    /// Index of the detector in the order of the run.
    pub detector_idx: usize,
    /// The box.
    pub bounding_box: BoxFacts,
    /// Whether it counts in the task that is shown; otherwise it was found, and taken for something else.
    pub is_asked: bool,
}

/// The drawing of a scene; `label` describes it.
pub fn scene_plot(scene: &Scene<'_>, label: String) -> ThemedPanel {
    let Scene { window, subject, cells, annotations, detections } = scene;
    let half = f64::from(SIDE_PX) / 2.0;
    let scale = half / f64::from(window.half_m);
    let position = |[x_m, y_m]: [f64; 2]| {
        let [forward, left] = [x_m - f64::from(window.center_m[0]), y_m - f64::from(window.center_m[1])];
        format!("{:.1},{:.1}", half - left * scale, half - forward * scale)
    };
    let polygon = |it: &BoxFacts| format!(r#"polygon points="{}""#, corners(it).map(position).join(" "));
    let mut elements = cells.map(|it| seen_cells(it, scale)).unwrap_or_default();
    let [length_m, width_m, _] = subject.length_width_height_m;
    elements.push(subject_shape(&if length_m > 0.0 || width_m > 0.0 {
        polygon(subject)
    } else {
        // No box is labelled: the position is all that is known.
        format!(r#"circle cx="{half}" cy="{half}" r="{POSITION_RADIUS_PX}""#)
    }));
    elements.extend(annotations.iter().map(|it| {
        let width_px = if it == subject { 2.8 } else { 1.5 };
        stroked(&polygon(it), BLACK, width_px, None)
    }));
    elements.extend(detections.iter().map(|it| {
        let dashes_px = if it.is_asked { SeriesMark(it.detector_idx).dashes_px() } else { ANOTHER_CLASS };
        stroked(&polygon(&it.bounding_box), detector_hue(it.detector_idx).on_light, 1.8, dashes_px)
    }));
    elements.push(scale_bar(*window, scale));
    elements.push(sensor_mark(*window));
    ThemedPanel { size_px: [SIDE_PX, SIDE_PX], label, elements: elements.concat() }
}

/// The key to scenes of detectors with these names.
pub fn scene_keys(names: &[&str], is_labelled: bool) -> Vec<KeyEntry> {
    let entry = |name: &str, elements: String| {
        let swatch = ThemedPanel { size_px: KEY_SIZE_PX, label: name.to_owned(), elements };
        KeyEntry { name: name.to_owned(), swatch }
    };
    let sample = |name: &str, color: Rgb, width_px: f32, dashes_px: Option<[i32; 2]>| {
        entry(name, stroked(r#"path d="M1 8h34""#, color, width_px, dashes_px))
    };
    let subject = subject_shape(r#"rect x="6" y="1" width="24" height="14""#);
    let mut keys = if is_labelled {
        vec![entry("missed, false or matched object", subject), sample("annotated", BLACK, 1.8, None)]
    } else {
        vec![entry("found by no other", subject)]
    };
    keys.extend(
        names
            .iter()
            .enumerate()
            .map(|(idx, name)| sample(name, detector_hue(idx).on_light, 2.0, SeriesMark(idx).dashes_px())),
    );
    keys.push(sample("found, but as another class", BLACK, 2.0, ANOTHER_CLASS));
    keys
}

/// An unfilled element; `shape` is its tag with its geometry.
fn stroked(shape: &str, color: Rgb, width_px: f32, dashes_px: Option<[i32; 2]>) -> String {
    let stroke = painted(Paint::Stroke, color);
    let dashes =
        dashes_px.map_or_else(String::new, |[dash, gap]| format!(r#" stroke-dasharray="{dash} {gap}""#));
    format!(r#"<{shape} {stroke} fill="none" stroke-width="{width_px}"{dashes}/>"#)
}

/// The element of the object of a scene.
fn subject_shape(shape: &str) -> String {
    format!(r#"<{shape} fill="{}" opacity="0.35"/>"#, hex(YELLOW))
}

/// The cells with points from above, at `scale` pixels a metre.
fn seen_cells(cells: &PlanCells, scale: f64) -> Vec<String> {
    let (middle, per_cell) = (SIDE_PX / 2, scale * f64::from(PLAN_CELL_M));
    let paths = [(&cells.low, QUIET, 1.0), (&cells.high, BLACK, 0.62)];
    let path = |(cells, color, opacity): (&Vec<[i32; 2]>, Rgb, f32)| {
        let stroke = painted(Paint::Stroke, color);
        let d = runs(cells);
        format!(
            r#"<path {stroke} transform="translate({middle} {middle}) scale({per_cell:.3})" opacity="{opacity}" fill="none" d="{d}"/>"#
        )
    };
    paths.into_iter().filter(|(cells, ..)| !cells.is_empty()).map(path).collect()
}

/// A bar of two metres, at `scale` pixels a metre.
fn scale_bar(window: PlanWindow, scale: f64) -> String {
    let bar_px = 2.0 * scale;
    // At the bottom, unless the mark of the sensor may be there.
    let [forward_m, left_m] = window.center_m;
    let y_px = if forward_m > 0.0 && left_m < 0.0 { 12 } else { SIDE_PX - 8 };
    let bar = stroked(&format!(r#"path d="M8 {y_px}h{bar_px:.1}""#), BLACK, 2.0, None);
    let (x_px, text_y_px, fill) = (12.0 + bar_px, y_px + 4, painted(Paint::Fill, BLACK));
    format!(
        r#"{bar}<text {fill} x="{x_px:.1}" y="{text_y_px}" font-family="sans-serif" font-size="12">2 m</text>"#
    )
}

/// A small wedge at the edge that points to the sensor; a cross if the sensor is inside.
fn sensor_mark(window: PlanWindow) -> String {
    let [x_m, y_m] = window.center_m.map(f64::from);
    let half = f64::from(SIDE_PX) / 2.0;
    // From the middle of the window to the sensor, on the screen: right is −y, down is −x.
    let [right, down] = [y_m, x_m];
    let reach = right.abs().max(down.abs());
    if reach <= f64::from(window.half_m) {
        let scale = half / f64::from(window.half_m);
        let [x, y] = [half + right * scale, half + down * scale];
        return stroked(&format!(r#"path d="M{:.1} {y:.1}h8m-4 -4v8""#, x - 4.0), BLACK, 1.0, None);
    }
    let [x, y] = [right, down].map(|it| half + it / reach * (half - 3.0));
    let turned_deg = down.atan2(right).to_degrees();
    let fill = painted(Paint::Fill, BLACK);
    format!(
        r#"<path {fill} transform="translate({x:.1} {y:.1}) rotate({turned_deg:.0})" d="M0 0l-9 -5v10z"/>"#
    )
}

/// Cells as runs from left to right, as a path in units of cells from the middle of the window.
fn runs(cells: &[[i32; 2]]) -> String {
    // On the screen: down is −forward, right is −left.
    let mut positions: Vec<[i32; 2]> = cells.iter().map(|[forward, left]| [-forward, -left]).collect();
    positions.sort_unstable();
    let mut path = String::new();
    // Where the run before ends: steps from there are shorter than positions.
    let [mut at_down, mut at_right] = [0; 2];
    for run in positions.chunk_by(|a, b| a[0] == b[0] && b[1] == a[1] + 1) {
        let [down, right] = run[0];
        let (step_right, step_down) = (right - at_right, down - at_down);
        let blank = if step_down < 0 { "" } else { " " };
        let _ = write!(path, "m{step_right}{blank}{step_down}h{}", run.len());
        [at_down, at_right] = [down, right + run.len() as i32];
    }
    path
}

fn corners(bounding_box: &BoxFacts) -> [[f64; 2]; 4] {
    let [x_m, y_m, _] = bounding_box.center_m.map(f64::from);
    let [length_m, width_m, _] = bounding_box.length_width_height_m.map(f64::from);
    let (sin, cos) = f64::from(bounding_box.yaw_rad).sin_cos();
    [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[ahead, aside]| {
        let [ahead_m, aside_m] = [ahead * length_m / 2.0, aside * width_m / 2.0];
        [x_m + ahead_m * cos - aside_m * sin, y_m + ahead_m * sin + aside_m * cos]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;

    const BOX: BoxFacts =
        BoxFacts { center_m: [20.0, 5.0, 0.0], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
    const WINDOW: PlanWindow = PlanWindow { center_m: [20.0, 5.0], half_m: 5.0 };

    fn scene(cells: Option<&PlanCells>, window: PlanWindow) -> Scene<'_> {
        let detection = |is_asked| SceneDetection { detector_idx: 1, bounding_box: BOX, is_asked };
        let detections = vec![detection(true), detection(false)];
        Scene { window, subject: BOX, cells, annotations: vec![BOX], detections }
    }

    #[test]
    fn forward_is_up_and_left_is_left() {
        // Two cells ahead and one to the left of the middle, in one run with its right neighbour.
        assert_eq!(runs(&[[2, 1], [2, 0], [-1, 0]]), "m-1-2h2m-1 3h1");
        let svg = scene_plot(&scene(None, WINDOW), "a < b".to_owned()).inline();
        // 4 m long in a window of 10 m and 200 pixels: from 60 to 140 down, from 80 to 120 across.
        assert!(svg.contains("points=\"80.0,60.0 80.0,140.0 120.0,140.0 120.0,60.0\""), "{svg}");
        check_holds(&svg, &["a &lt; b", "2 m", "k-d1", "stroke-dasharray=\"1 3\"", "opacity=\"0.35\""]);
        assert!(!svg.contains("k-grid"), "{svg}");
    }

    #[test]
    fn what_was_seen_is_drawn_where_it_was_kept() {
        let cells = PlanCells { low: vec![[0, 0]], high: vec![[1, 0]] };
        let svg = scene_plot(&scene(Some(&cells), WINDOW), String::new()).inline();
        assert!(svg.contains("m0 0h1") && svg.contains("m0-1h1"), "{svg}");
    }

    #[test]
    fn the_sensor_is_pointed_at_or_shown() {
        // The sensor is behind, to the right: below on the page.
        let svg = sensor_mark(WINDOW);
        assert!(svg.contains("translate(124.2 197.0) rotate(76)"), "{svg}");
        let around = PlanWindow { center_m: [1.0, 0.0], half_m: 5.0 };
        assert!(sensor_mark(around).contains("M96.0 120.0h8"), "{}", sensor_mark(around));
    }
}
