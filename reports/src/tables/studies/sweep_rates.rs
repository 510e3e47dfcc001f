//! The rates of a sweep for a screen: a table for each detector and data set, a line for each value.

use crate::files::fixed_decimals::percent;
use crate::numbers::sweep_curve::{Reached as _, SweepCurve};
use crate::numbers::sweep_score::SweepScores;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};

/// The rates at all values.
#[derive(Debug, Clone, Copy)]
pub struct SweepRates<'a> {
    /// All numbers of the sweep.
    pub sweep: &'a SweepScores,
}

impl Tabular for SweepRates<'_> {
    fn sheet(&self) -> Sheet {
        let curves = self.sweep.curves();
        let of_detectors = curves.chunk_by(|a, b| title(a) == title(b));
        let parts = of_detectors.map(|it| Part { title: Some(title(&it[0])), grid: grid(self.sweep, it) });
        Sheet::of_parts(parts.collect(), Vec::new())
    }
}

/// The detector and the data set of a curve.
fn title(curve: &SweepCurve<'_>) -> String {
    let subject = &curve.first().subject;
    let named = curve.named(&subject.detector);
    format!("{named} on {}{}, in %", subject.extent.name(), subject.origin.in_brackets())
}

/// The curves of one detector on one data set side by side.
fn grid(sweep: &SweepScores, curves: &[SweepCurve<'_>]) -> Grid {
    let of_curve = |it: &SweepCurve<'_>| {
        let about = it.first().about();
        [Column::number(about[1].to_owned()), Column::number("95 %")].map(|it| it.within(about[0]))
    };
    let parameter = sweep.parameters[0].rsplit('.').next().unwrap_or_default().to_owned();
    let columns = [Column::number(parameter)].into_iter().chain(curves.iter().flat_map(of_curve)).collect();
    let line = |point_idx: usize| {
        let of_point = curves.iter().flat_map(|curve| {
            let reached = curve.points[point_idx].reached;
            let or_dash = |text: Option<String>| Cell::new(text.unwrap_or_else(|| "–".to_owned()));
            let interval =
                reached.interval().map(|it| Cell::interval(it.ends.map(percent).join(" to "), it.blocks));
            [or_dash(reached.value().map(percent)), interval.unwrap_or_else(|| or_dash(None))]
        });
        let value = Cell::new(curves[0].points[point_idx].x_text);
        Line { kind: LineKind::Dataset, cells: [value].into_iter().chain(of_point).collect() }
    };
    Grid { columns, lines: (0..curves[0].points.len()).map(line).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::sweep_score::tests::cell_sizes;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;

    #[test]
    fn every_value_has_its_rate() {
        let sweep = cell_sizes(&[(4, Some(6), None, 0.1), (8, Some(2), None, 0.3), (6, Some(4), None, 0.4)]);
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&SweepRates { sweep: &sweep }), @r"
        hierarchical on street (simulated), in %

                             objects
                      ─────────────────────
        cell_size_m   F-rate           95 %
        ───────────────────────────────────
                0.2     40.0  10.0 to 90.0§
                0.4     80.0  10.0 to 90.0§
                0.6     60.0  10.0 to 90.0§

        § from fewer than 10 blocks: too few for a reliable interval and for conclusions.
        ");
    }
}
