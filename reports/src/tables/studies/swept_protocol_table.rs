//! The table of a sweep under protocols of others: for every principal number the best point.

use crate::files::fixed_decimals::fixed_decimals;
use crate::protocols::drawn_scans::N_PROTOCOL_RESAMPLES;
use crate::protocols::swept_numbers::SweptNumbers;
use crate::tables::grid::{Column, Grid};
use crate::tables::notes::about_interval_of;
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::studies::sweep_table::best_line;

/// For every principal number the best point.
#[derive(Debug, Clone, Copy)]
pub struct SweptProtocolTable<'a> {
    /// All numbers of the sweep.
    pub swept: &'a SweptNumbers,
}

impl Tabular for SweptProtocolTable<'_> {
    fn sheet(&self) -> Sheet {
        let curves = self.swept.principal_curves();
        let columns = ["data set", "detector", "protocol", "class", "metric"].map(Column::left);
        let numbers = ["n", "best at", "value there", "95 %", "worst"].map(Column::number);
        let kind = self.swept.numbers.iter().find_map(|it| it.number.interval).map(|it| it.blocks.kind);
        let about_interval = kind.map(|it| format!("95 %: {}", about_interval_of(N_PROTOCOL_RESAMPLES, it)));
        let sentences = [
            Some("n: annotations, scans or points that the number is made of. Best at: the first of the best values.".to_owned()),
            about_interval,
            Some("All numbers at all points: sweep_protocols.csv.".to_owned()),
        ];
        let n_values = curves.first().map_or(0, |it| it.points.len());
        let title =
            format!("Protocols of others: best of {n_values} values over {}.", self.swept.parameters[0]);
        let lines = curves
            .iter()
            .map(|it| best_line(it, &[it.first().number.metric.n], |value| fixed_decimals(value, 4)));
        let columns = columns.into_iter().chain(numbers).collect();
        let grid = Grid::with_one_rule(columns, lines.collect());
        Sheet::of(title, grid, sentences.into_iter().flatten().collect()).labelled("sweep_protocols")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocols::swept_numbers::tests::swept;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;

    #[test]
    fn every_principal_number_has_its_best_point() {
        let swept = swept(&[Some(0.25), Some(0.5), None]);
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&SweptProtocolTable { swept: &swept }), @r"
        Protocols of others: best of 3 values over hierarchical.grouping.ranked_probability.

        data set            detector      protocol  class    metric  n  best at  value there               95 %   worst
        ───────────────────────────────────────────────────────────────────────────────────────────────────────────────
        street (simulated)  hierarchical  nuscenes  present  ap      9      0.2       0.5000  0.3750 to 0.6250§  0.2500

        n: annotations, scans or points that the number is made of. Best at: the first of the best values.
        95 %: cluster bootstrap, 1000 resamples; each second of driving is one block, because there are
          fewer than 10 drives: the intervals cover other scans of the same drives, but not other drives.
        All numbers at all points: sweep_protocols.csv.
        § from fewer than 10 blocks: too few for a reliable interval and for conclusions.
        ");
    }
}
