//! The table of a sweep: for every curve the best point.

use crate::files::fixed_decimals::{decimals_or_dash, percent, percent_or_dash};
use crate::numbers::blocks::BlockKind;
use crate::numbers::sweep_curve::SweepCurve;
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
    let subject = &first.subject;
    let name = format!("{}{}", subject.extent.name(), subject.origin.in_brackets());
    let undefined = || "–".to_owned();
    let best = curve.best().map(|it| &curve.points[it]);
    let lowest = curve.points.iter().filter_map(|it| it.reached.rate()).reduce(f64::min);
    let within = best.and_then(|it| it.reached.rate_within());
    let detector = curve.named(&subject.detector);
    let texts = [
        name,
        detector,
        first.task.name().to_owned(),
        first.rate_name().to_owned(),
        first.n_scans.to_string(),
        first.counts.no().to_string(),
        best.map_or_else(undefined, |it| it.x_text.to_owned()),
        percent_or_dash(best.and_then(|it| it.reached.rate())),
    ];
    let interval = within.map_or_else(
        || Cell::new(undefined()),
        |it| Cell::interval(it.map(percent).join(" to "), first.blocks),
    );
    let time = best.and_then(|it| sweep.time_of(&it.reached.subject));
    let time = decimals_or_dash(time.map(|it| it.typical_ms), 2);
    let last = [interval, Cell::new(percent_or_dash(lowest)), Cell::new(time)];
    Line {
        kind: LineKind::of(&subject.extent),
        cells: texts.map(Cell::new).into_iter().chain(last).collect(),
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
