//! The plot of the share of pairs that are separated, over the gap.

use super::figure::{Axis, Chart, Figure, LEFT_PX, Panel};
use super::marks::Mark;
use super::series::{DetectorMarks, KEY_LINE_PX, Points, Position, Series, key_lines, series_marks};
use crate::numbers::gap_curve::GapCurve;
use crate::tables::studies::gap_table::curves_by_range;

const WIDTH_PX: u32 = 900;
const PANEL_PX: u32 = 270;

/// The plot as an SVG document: a panel for each range with a curve for each detector, and the 95 % interval of every
/// share. `title` says what the pairs are, and that they are simulated.
pub fn gap_plot(curves: &[GapCurve], title: &str) -> String {
    let ranges = curves_by_range(curves);
    let marks = DetectorMarks::of(curves.iter().map(|it| it.detector.as_str()));
    let n_series = ranges.iter().map(Vec::len).max().unwrap_or(0);
    let mut heading = Vec::new();
    if let Some(of_range) = ranges.first() {
        heading.push(Mark::title(title, (LEFT_PX, 20.0)));
        let key = of_range.iter().map(|it| (marks.mark(&it.detector, 0), it.detector.as_str()));
        heading.extend(key_lines(key, 50.0));
    }
    let figure = Figure {
        width_px: WIDTH_PX,
        heading_px: 40 + KEY_LINE_PX * n_series as u32 + 10,
        heading,
        rows: ranges.iter().map(|it| (PANEL_PX, vec![panel(it, &marks)])).collect(),
    };
    figure.svg(title)
}

fn panel(curves: &[&GapCurve], marks: &DetectorMarks<'_>) -> Panel {
    let gaps_m = curves.iter().flat_map(|it| &it.points).map(|(gap_m, _)| *gap_m);
    let (least_m, most_m) =
        gaps_m.fold((f64::INFINITY, 0.0_f64), |(least, most), it| (least.min(it), most.max(it)));
    if least_m > most_m {
        return Panel::default();
    }
    let [from_m, to_m] = curves[0].range_m;
    let series: Vec<Series> = curves.iter().map(|it| series(it, marks)).collect();
    let shares = [-3.0, 103.0];
    let x_title = format!("gap (m), pairs {from_m} to {to_m} m from the sensor");
    let x = Axis::linear(x_title, [least_m - 0.06, most_m + 0.06], 12);
    let y = Axis::linear("separated (%)", shares, 6);
    Chart::new(x, y, series_marks(&series, Points::Marked { apart: 0.008 }, shares)).into()
}

/// The shares of separated pairs, at the gaps with seen pairs.
fn series(curve: &GapCurve, marks: &DetectorMarks<'_>) -> Series {
    let positions = curve.points.iter().filter_map(|(gap_m, counts)| {
        let within = counts.separated_within()?.map(|it| it * 100.0);
        Some(Some(Position { x: *gap_m, y: counts.separated()? * 100.0, within: Some(within) }))
    });
    let mark = marks.mark(&curve.detector, 0);
    Series { name: curve.detector.clone(), mark, positions: positions.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::texts::check_holds;
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
        check_holds(
            &svg,
            &[
                "gap (m), pairs 5 to 10 m",
                "10 to 20 m",
                "separated (%)",
                "Pairs of cars (simulated)",
                "simple-grid",
            ],
        );
    }

    #[test]
    fn nothing_put_up_can_be_drawn() {
        assert!(gap_plot(&[], "Nothing").contains("</svg>"));
        let mut unseen = bin("grid", "cars", true, 0.3, 0);
        unseen.counts.n_seen = 0;
        assert!(gap_plot(&gap_curves(&[unseen]), "Nothing").contains("</svg>"));
    }
}
