//! What was around an object, seen from above: what the sensor saw, what is annotated, and what every detector made of it.
//!
//! Forward is up. Cells are runs in one path, not marks of the drawing library, which would be ten times as long.

use std::fmt::Write as _;

use super::marks::SeriesMark;
use super::palette::{DETECTOR_HUES, QUIET, detector_hue};
use super::theme::hex;
use super::themed_panel::{KEY_SIZE_PX, KeyEntry, ThemedPanel};
use crate::rows::match_outcome::BoxFacts;
use crate::worst::places::PlanWindow;
use crate::worst::points::{PLAN_CELL_M, PlanCells};

const SIDE_PX: u32 = 200;
const BLACK_HEX: &str = "#000000";
/// Behind what a scene is about: yellow, as what is missed in the viewer.
const SUBJECT_HEX: &str = "#F0E442";

/// Of the disc that marks an object without a box.
const PLACE_RADIUS_PX: u32 = 14;

/// What is around an object.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene<'a> {
    /// Where.
    pub window: PlanWindow,
    /// What it is about; a box without extent is a place, in the middle of the window.
    pub subject: BoxFacts,
    /// What was seen, if that was kept.
    pub cells: Option<&'a PlanCells>,
    /// Boxes of all annotations around.
    pub annotations: Vec<BoxFacts>,
    /// Boxes of all detections around.
    pub detections: Vec<SceneDetection>,
}

/// A box of a detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneDetection {
    /// Place of the detector in the order of the run.
    pub detector_idx: usize,
    /// The box.
    pub bounding_box: BoxFacts,
    /// Whether the task that is shown asks for it; otherwise it was found, and taken for something else.
    pub is_asked: bool,
}

/// What the sensor saw, from above, at `scale` pixels a metre.
fn seen_cells(cells: &PlanCells, scale: f64) -> String {
    let mut elements = String::new();
    let middle = SIDE_PX / 2;
    let per_cell = scale * f64::from(PLAN_CELL_M);
    let paths = [(&cells.low, "k-grid", QUIET, 1.0), (&cells.high, "k-ink", [90, 90, 90], 0.62)];
    for (cells, class, color, opacity) in paths.into_iter().filter(|(cells, ..)| !cells.is_empty()) {
        // Writing to a string cannot fail.
        let _ = write!(
            elements,
            r#"<path class="{class}" transform="translate({middle} {middle}) scale({per_cell:.3})" opacity="{opacity}" fill="none" stroke="{}" d="{}"/>"#,
            hex(color),
            runs(cells)
        );
    }
    elements
}

/// The scene; `label` says what is seen.
pub fn scene_plot(scene: &Scene<'_>, label: String) -> ThemedPanel {
    let scale = f64::from(SIDE_PX) / (2.0 * f64::from(scene.window.half_m));
    let mut elements = scene.cells.map(|cells| seen_cells(cells, scale)).unwrap_or_default();
    let place = |[x_m, y_m]: [f64; 2]| {
        let [forward, left] =
            [x_m - f64::from(scene.window.center_m[0]), y_m - f64::from(scene.window.center_m[1])];
        let half = f64::from(SIDE_PX) / 2.0;
        format!("{:.1},{:.1}", half - left * scale, half - forward * scale)
    };
    let polygon = |bounding_box: &BoxFacts| corners(bounding_box).map(place).join(" ");
    let [length_m, width_m, _] = scene.subject.length_width_height_m;
    let _ = if length_m > 0.0 || width_m > 0.0 {
        write!(
            elements,
            r#"<polygon class="f-subject" points="{}" fill="{SUBJECT_HEX}" opacity="0.35"/>"#,
            polygon(&scene.subject)
        )
    } else {
        // No box is labelled: the place is all that is known.
        let middle = SIDE_PX / 2;
        write!(
            elements,
            r#"<circle class="f-subject" cx="{middle}" cy="{middle}" r="{PLACE_RADIUS_PX}" fill="{SUBJECT_HEX}" opacity="0.35"/>"#
        )
    };
    for it in &scene.annotations {
        let width = if *it == scene.subject { 2.8 } else { 1.5 };
        let _ = write!(
            elements,
            r#"<polygon class="k-ink" points="{}" fill="none" stroke="{BLACK_HEX}" stroke-width="{width}"/>"#,
            polygon(it)
        );
    }
    for it in &scene.detections {
        let mark = SeriesMark(it.detector_idx);
        let dashes = match (it.is_asked, mark.dashes_px()) {
            (false, _) => r#" stroke-dasharray="1 3""#.to_owned(),
            (true, Some([dash, gap])) => format!(r#" stroke-dasharray="{dash} {gap}""#),
            (true, None) => String::new(),
        };
        let _ = write!(
            elements,
            r#"<polygon class="k-d{}" points="{}" fill="none" stroke="{}" stroke-width="1.8"{dashes}/>"#,
            it.detector_idx % DETECTOR_HUES.len(),
            polygon(&it.bounding_box),
            hex(detector_hue(it.detector_idx).on_light)
        );
    }
    elements.push_str(&scale_bar(scene.window, scale));
    elements.push_str(&sensor_mark(scene.window));
    ThemedPanel { size_px: [SIDE_PX, SIDE_PX], label, elements }
}

/// The key to scenes of the detectors of these names.
pub fn scene_keys(names: &[&str]) -> Vec<KeyEntry> {
    let sample = |name: &str, class: &str, color: &str, width: f32, dashes: &str| {
        let elements = format!(
            r#"<path class="{class}" d="M1 8h34" fill="none" stroke="{color}" stroke-width="{width}"{dashes}/>"#
        );
        let name = name.to_owned();
        KeyEntry { swatch: ThemedPanel { size_px: KEY_SIZE_PX, label: name.clone(), elements }, name }
    };
    let subject = format!(
        r#"<rect class="f-subject" x="6" y="1" width="24" height="14" fill="{SUBJECT_HEX}" opacity="0.35"/>"#
    );
    let name = "missed or false object".to_owned();
    let swatch = ThemedPanel { size_px: KEY_SIZE_PX, label: name.clone(), elements: subject };
    let mut keys = vec![KeyEntry { name, swatch }, sample("annotated", "k-ink", BLACK_HEX, 1.8, "")];
    keys.extend(names.iter().enumerate().map(|(idx, name)| {
        let dashes = SeriesMark(idx).dashes_px();
        let dashes =
            dashes.map_or_else(String::new, |[dash, gap]| format!(r#" stroke-dasharray="{dash} {gap}""#));
        let color = hex(detector_hue(idx).on_light);
        sample(name, &format!("k-d{}", idx % DETECTOR_HUES.len()), &color, 2.0, &dashes)
    }));
    keys.push(sample("found, but as another class", "k-ink", BLACK_HEX, 2.0, r#" stroke-dasharray="1 3""#));
    keys
}

/// A bar of two metres, where `scale` are the pixels of a metre.
fn scale_bar(window: PlanWindow, scale: f64) -> String {
    let bar_px = 2.0 * scale;
    // Below, unless the sensor is pointed at there.
    let [forward_m, left_m] = window.center_m;
    let y_px = if forward_m > 0.0 && left_m < 0.0 { 12 } else { SIDE_PX - 8 };
    format!(
        r#"<path class="k-ink" d="M8 {y_px}h{bar_px:.1}" stroke="{BLACK_HEX}" stroke-width="2"/><text class="f-ink" x="{:.1}" y="{}" font-family="sans-serif" font-size="12" fill="{BLACK_HEX}">2 m</text>"#,
        12.0 + bar_px,
        y_px + 4
    )
}

/// A small wedge at the edge, on the side of the sensor, that points to it; a cross where the sensor is inside.
fn sensor_mark(window: PlanWindow) -> String {
    let [x_m, y_m] = window.center_m.map(f64::from);
    let half = f64::from(SIDE_PX) / 2.0;
    // From the middle of the window to the sensor, on the screen: right is −y, down is −x.
    let [right, down] = [y_m, x_m];
    let reach = right.abs().max(down.abs());
    if reach <= f64::from(window.half_m) {
        let scale = half / f64::from(window.half_m);
        let [x, y] = [half + right * scale, half + down * scale];
        return format!(
            r#"<path class="k-ink" d="M{:.1} {y:.1}h8m-4 -4v8" stroke="{BLACK_HEX}" fill="none"/>"#,
            x - 4.0
        );
    }
    let [x, y] = [right, down].map(|it| half + it / reach * (half - 3.0));
    let turned_deg = down.atan2(right).to_degrees();
    format!(
        r#"<path class="f-ink" transform="translate({x:.1} {y:.1}) rotate({turned_deg:.0})" d="M0 0l-9 -5v10z" fill="{BLACK_HEX}"/>"#
    )
}

/// Cells as runs from left to right, in cells from the middle of the object.
fn runs(cells: &[[i32; 2]]) -> String {
    // On the screen: down is −forward, right is −left.
    let mut places: Vec<[i32; 2]> = cells.iter().map(|[forward, left]| [-forward, -left]).collect();
    places.sort_unstable();
    let mut path = String::new();
    for run in places.chunk_by(|a, b| a[0] == b[0] && b[1] == a[1] + 1) {
        let [down, right] = run[0];
        let _ = write!(path, "M{right} {down}h{}", run.len());
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
        assert_eq!(runs(&[[2, 1], [2, 0], [-1, 0]]), "M-1 -2h2M0 1h1");
        let svg = scene_plot(&scene(None, WINDOW), "a < b".to_owned()).inline();
        // 4 m long in a window of 10 m and 200 pixels: from 60 to 140 down, from 80 to 120 across.
        assert!(svg.contains("points=\"80.0,60.0 80.0,140.0 120.0,140.0 120.0,60.0\""), "{svg}");
        for part in ["a &lt; b", "2 m", "k-d1", "stroke-dasharray=\"1 3\"", "f-subject"] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        assert!(!svg.contains("k-grid"), "{svg}");
    }

    #[test]
    fn what_was_seen_is_drawn_where_it_was_kept() {
        let cells = PlanCells { low: vec![[0, 0]], high: vec![[1, 0]] };
        let svg = scene_plot(&scene(Some(&cells), WINDOW), String::new()).inline();
        assert!(svg.contains("M0 0h1") && svg.contains("M0 -1h1"), "{svg}");
    }

    #[test]
    fn the_sensor_is_pointed_at_or_shown() {
        // It is behind, to the right: below on the page.
        let svg = sensor_mark(WINDOW);
        assert!(svg.contains("translate(124.2 197.0) rotate(76)"), "{svg}");
        let around = PlanWindow { center_m: [1.0, 0.0], half_m: 5.0 };
        assert!(sensor_mark(around).contains("M96.0 120.0h8"), "{}", sensor_mark(around));
    }
}
