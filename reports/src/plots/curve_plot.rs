//! The plot of one statistic of two collections of scans.

use plotters::prelude::*;

use super::bar_panel::draw_bars;
use super::heading::{HEADING_PX, KeyForm, draw_heading};
use super::line_panel::draw_lines;
use super::ratio_panel::draw_ratios;
use super::style::{Area, Drawn, SIZE_PX};
use crate::numbers::curve_pair::{CurvePair, Sides};

/// Height of the panel of the curves; the ratios have the rest.
const CURVES_PX: u32 = 320;

/// The plot as an SVG document: curves over a length with their ratios beneath, or bars where the bins are kinds of
/// something. `names` says what was measured on each side, and whether it is simulated.
pub fn curve_plot(curves: &CurvePair, names: Sides<&str>) -> String {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, SIZE_PX).into_drawing_area();
    draw(&root, curves, names).expect("the panels have room, and memory takes all that is drawn");
    drop(root);
    svg.push('\n');
    svg
}

fn draw(root: &Area<'_>, curves: &CurvePair, names: Sides<&str>) -> Drawn {
    root.fill(&WHITE)?;
    let (heading, panels) = root.split_vertically(HEADING_PX);
    let ends_m = curves.bins.first().zip(curves.bins.last()).and_then(|(first, last)| {
        let ([from_m, _], [_, to_m]) = first.ends_m.zip(last.ends_m)?;
        Some([from_m, to_m])
    });
    let form = if ends_m.is_some() { KeyForm::Lines } else { KeyForm::Bars };
    let by = curves.bins_of.map_or_else(String::new, |it| format!(" by {it}"));
    draw_heading(&heading, &format!("{}{by}", curves.title), names, form)?;
    if let Some(ends_m) = ends_m {
        let (upper, lower) = panels.split_vertically(CURVES_PX);
        draw_lines(&upper, curves, ends_m)?;
        draw_ratios(&lower, curves, ends_m)?;
    } else {
        draw_bars(&panels, curves)?;
    }
    root.present()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::curve_pair::tests::pair;

    const NAMES: Sides<&str> = Sides { left: "street (simulated)", right: "kitti" };

    #[track_caller]
    fn check_holds(svg: &str, parts: &[&str]) {
        for part in parts {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
    }

    #[test]
    fn curves_over_a_length_have_units_on_both_axes_and_both_names() {
        let svg = curve_plot(&pair(&[(1.0, 2.0), (30.0, 4.0), (0.0, 5.0)]), NAMES);
        check_holds(&svg, &["<svg ", "</svg>", "street (simulated)", "kitti", "range (m)", "(points/m²)"]);
    }

    #[test]
    fn kinds_have_names_values_and_ratios() {
        let mut curves = pair(&[(1.0, 2.0), (30.0, 0.0)]);
        for (bin, name) in curves.bins.iter_mut().zip(["short", "tall"]) {
            (bin.name, bin.ends_m) = (name.to_owned(), None);
        }
        let svg = curve_plot(&curves, NAMES);
        check_holds(&svg, &["short", "tall", "ratio 0.50", "no ratio", "30.0", "street (simulated)"]);
    }

    #[test]
    fn nothing_measured_can_be_drawn() {
        let mut curves = pair(&[(0.0, 0.0)]);
        check_holds(&curve_plot(&curves, NAMES), &["</svg>"]);
        curves.bins.clear();
        check_holds(&curve_plot(&curves, NAMES), &["</svg>"]);
    }

    #[test]
    fn the_same_curves_give_the_same_bytes() {
        let curves = pair(&[(1.0, 2.0), (30.0, 4.0)]);
        assert_eq!(curve_plot(&curves, NAMES), curve_plot(&curves, NAMES));
    }
}
