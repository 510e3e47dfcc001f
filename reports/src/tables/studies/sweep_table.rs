//! The table of a sweep: for every curve the best point.

use crate::files::fixed_decimals::{decimals_or_dash, percent};
use crate::numbers::blocks::BlockKind;
use crate::numbers::sweep_curve::{Curve, CurvePoint, Reached, SweepCurve};
use crate::numbers::sweep_score::SweepScores;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::notes::about_interval;
use crate::tables::sheet::{Sheet, Tabular};

/// For every curve the best point.
#[derive(Debug, Clone, Copy)]
pub struct SweepTable<'a> {
    /// All numbers of the sweep.
    pub sweep: &'a SweepScores,
}

impl Tabular for SweepTable<'_> {
    fn sheet(&self) -> Sheet {
        let sweep = self.sweep;
        let kinds = sweep.scores.iter().map(|it| it.blocks.kind);
        let kind = kinds.reduce(BlockKind::with);
        let about_interval = kind.map_or_else(String::new, about_interval);
        let sentence = format!(
            "NO: annotations that count. Best at: the value with the highest rate, the first one if several are equal. 95 %: \
             {about_interval} Lowest: the rate at the worst value. Time: the shortest detection of each scan at the best value, \
             median over scans."
        );
        let title = format!("Best of {} over {}. Rates in %.", n_values(sweep), sweep.parameters[0]);
        Sheet::of(title, grid(sweep), vec![sentence]).labelled("sweep")
    }
}

fn grid(sweep: &SweepScores) -> Grid {
    let names = ["data set", "detector", "task", "rate"].map(Column::left);
    let numbers = ["scans", "NO", "best at", "rate there", "95 %", "lowest", "time ms"].map(Column::number);
    let lines = sweep.curves().iter().map(|it| line(sweep, it)).collect();
    Grid::with_one_rule(names.into_iter().chain(numbers).collect(), lines)
}

fn n_values(sweep: &SweepScores) -> String {
    let n = sweep.curves().first().map_or(0, |it| it.points.len());
    format!("{n} values")
}

fn line(sweep: &SweepScores, curve: &SweepCurve<'_>) -> Line {
    let first = curve.first();
    let mut line = best_line(curve, &[first.n_scans, first.counts.no()], percent);
    let time = curve.best().and_then(|it| sweep.time_of(&it.reached.subject));
    line.cells.push(Cell::new(decimals_or_dash(time.map(|it| it.typical_ms), 2)));
    line
}

/// The line of a curve: its subject, these `counts`, and its best and its worst point, as `shown`.
pub(super) fn best_line<T: Reached>(
    curve: &Curve<'_, T>,
    counts: &[u64],
    shown: impl Fn(f64) -> String,
) -> Line {
    let subject = curve.first().subject();
    let name = format!("{}{}", subject.extent.name(), subject.origin.in_brackets());
    let mut texts = vec![name, curve.named(&subject.detector)];
    texts.extend(curve.first().about().into_iter().map(str::to_owned));
    texts.extend(counts.iter().map(u64::to_string));
    let (best, worst) = (curve.best(), curve.worst());
    let or_dash = |text: Option<String>| Cell::new(text.unwrap_or_else(|| "–".to_owned()));
    let value = |it: Option<&CurvePoint<'_, T>>| or_dash(it.and_then(|it| it.reached.value()).map(&shown));
    let interval = best.and_then(|it| it.reached.interval());
    let interval = interval
        .map_or_else(|| or_dash(None), |it| Cell::interval(it.ends.map(&shown).join(" to "), it.blocks));
    let of_points = [or_dash(best.map(|it| it.x_text.to_owned())), value(best), interval, value(worst)];
    Line {
        kind: LineKind::of(&subject.extent),
        cells: texts.into_iter().map(Cell::new).chain(of_points).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::sweep_score::tests::cell_sizes;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;

    #[test]
    fn every_curve_has_its_best_point() {
        let sweep = cell_sizes(&[(4, Some(6), None, 0.1), (8, Some(2), None, 0.3), (6, Some(4), None, 0.4)]);
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&SweepTable { sweep: &sweep }), @r"
        Best of 3 values over hierarchical.grid.cell_size_m. Rates in %.

        data set            detector      task     rate    scans  NO  best at  rate there           95 %  lowest  time ms
        ─────────────────────────────────────────────────────────────────────────────────────────────────────────────────
        street (simulated)  hierarchical  objects  F-rate      2  10      0.4        80.0  10.0 to 90.0§    40.0     3.20

        NO: annotations that count. Best at: the value with the highest rate, the first one if several are
          equal. 95 %: cluster bootstrap, 10000 resamples; each second of driving is one block, because
          there are fewer than 10 drives: the intervals cover other scans of the same drives, but not other
          drives. Lowest: the rate at the worst value. Time: the shortest detection of each scan at the best
          value, median over scans.
        § from fewer than 10 blocks: too few for a reliable interval and for conclusions.
        ");
    }
}
