//! How many pairs are separated, by gap: a table, and `gaps.csv` with one row for every detector, kind of pair, layout,
//! range and gap.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::{Fixed, decimals_or_dash, fixed_decimals};
use crate::numbers::gap_curve::{GapBin, GapCurve, PairCounts};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};

/// One part for each range, one row a gap.
#[derive(Debug, Clone, Copy)]
pub struct GapTable<'a> {
    /// The curves of every detector and range.
    pub curves: &'a [GapCurve],
    /// The meaning of *separated*.
    pub definition: &'a str,
}

impl Tabular for GapTable<'_> {
    fn sheet(&self) -> Sheet {
        let part = |of_range: &Vec<&GapCurve>| {
            let [from_m, to_m] = of_range[0].range_m;
            let lines = of_range[0].points.iter().map(|&(gap_m, _)| line(gap_m, of_range));
            Part {
                title: Some(format!("Pairs at {from_m} to {to_m} m (simulated). Shares in %.")),
                grid: Grid { columns: columns(of_range), lines: lines.collect() },
            }
        };
        let sentences = vec![
            "judged: number of judged pairs. sep: share of them that is separated. low, high: its 95 % interval (Wilson). joined: share of them that one detection joins."
                .to_owned(),
            self.definition.to_owned(),
        ];
        Sheet::of_parts(curves_by_range(self.curves).iter().map(part).collect(), sentences).labelled("gaps")
    }
}

/// The curves of each range, ranges in the order of their first curve.
pub(crate) fn curves_by_range(curves: &[GapCurve]) -> Vec<Vec<&GapCurve>> {
    let mut ranges: Vec<Vec<&GapCurve>> = Vec::new();
    for curve in curves {
        match ranges.iter_mut().find(|it| it[0].range_m == curve.range_m) {
            Some(of_range) => of_range.push(curve),
            None => ranges.push(vec![curve]),
        }
    }
    ranges
}

fn columns(curves: &[&GapCurve]) -> Vec<Column> {
    let of_detector = |curve: &&GapCurve| {
        ["sep", "low", "high", "joined"].map(|title| Column::number(title).within(&curve.detector))
    };
    let of_all = ["gap m", "judged"].map(Column::number);
    of_all.into_iter().chain(curves.iter().flat_map(of_detector)).collect()
}

fn line(gap_m: f64, curves: &[&GapCurve]) -> Line {
    let counts_at = |curve: &GapCurve| {
        let found = curve.points.iter().find(|(it, _)| *it == gap_m);
        found.map_or_else(PairCounts::default, |(_, counts)| *counts)
    };
    let percent = |share: Option<f64>| decimals_or_dash(share.map(|it| 100.0 * it), 0);
    let of_detector = |curve: &&GapCurve| {
        let counts = counts_at(curve);
        let within = counts.separated_within();
        let joined = (counts.n_seen > 0).then(|| counts.n_joined as f64 / counts.n_seen as f64);
        [counts.separated(), within.map(|it| it[0]), within.map(|it| it[1]), joined].map(percent)
    };
    // Whether a pair is seen does not depend on the detector.
    let texts = [fixed_decimals(gap_m, 1), counts_at(curves[0]).n_seen.to_string()];
    let texts = texts.into_iter().chain(curves.iter().flat_map(of_detector));
    Line { kind: LineKind::Dataset, cells: texts.map(Cell::new).collect() }
}

row! {
    /// One bin, with what its share is made of.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct GapRow {
        data: String,
        detector: String,
        pair: String,
        layout: String,
        range_from_m: Fixed<1>,
        range_to_m: Fixed<1>,
        gap_m: Fixed<2>,
        n_pairs: u64,
        n_seen: u64,
        n_separated: u64,
        n_joined: u64,
        separated: Option<Fixed<4>>,
        separated_low: Option<Fixed<4>>,
        separated_high: Option<Fixed<4>>,
    }
}

impl GapRow {
    /// The row of `bin`, which was simulated.
    pub fn simulated(bin: &GapBin) -> Self {
        let within = bin.counts.separated_within();
        Self {
            data: "simulated".to_owned(),
            detector: bin.detector.clone(),
            pair: bin.pair.clone(),
            layout: bin.layout.clone(),
            range_from_m: Fixed(bin.range_m[0]),
            range_to_m: Fixed(bin.range_m[1]),
            gap_m: Fixed(bin.gap_m),
            n_pairs: bin.counts.n_pairs,
            n_seen: bin.counts.n_seen,
            n_separated: bin.counts.n_separated,
            n_joined: bin.counts.n_joined,
            separated: bin.counts.separated().map(Fixed),
            separated_low: within.map(|it| Fixed(it[0])),
            separated_high: within.map(|it| Fixed(it[1])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};
    use crate::numbers::gap_curve::gap_curves;
    use crate::numbers::gap_curve::tests::bin;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;

    #[test]
    fn every_range_has_a_part_and_every_share_its_denominator() {
        let bins = [
            bin("grid", "cars", false, 0.2, 3),
            bin("grid", "cars", false, 0.3, 10),
            bin("tree", "cars", false, 0.2, 0),
            bin("tree", "cars", false, 0.3, 5),
            bin("grid", "cars", true, 0.2, 1),
        ];
        let curves = gap_curves(&bins);
        let table = GapTable { curves: &curves, definition: "Separated: apart." };
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&table), @r"
        Pairs at 5 to 10 m (simulated). Shares in %.

                                 grid                     tree
                        ──────────────────────   ──────────────────────
        gap m  judged   sep  low  high  joined   sep  low  high  joined
        ───────────────────────────────────────────────────────────────
          0.2      10    30   11    60      70     0    0    28     100
          0.3      10   100   72   100       0    50   24    76      50

        Pairs at 10 to 20 m (simulated). Shares in %.

                                 grid
                        ──────────────────────
        gap m  judged   sep  low  high  joined
        ──────────────────────────────────────
          0.2      10    10    2    40      90

        judged: number of judged pairs. sep: share of them that is separated. low, high: its 95 % interval
          (Wilson). joined: share of them that one detection joins.
        Separated: apart.
        ");
    }

    #[test]
    fn a_share_of_nothing_is_left_empty() {
        let mut unseen = bin("grid", "cars", true, 0.3, 0);
        unseen.counts.n_seen = 0;
        unseen.counts.n_joined = 0;
        let rows = [bin("grid", "cars", false, 0.2, 7), unseen].map(|it| GapRow::simulated(&it));
        let text = csv_text(&rows);
        insta::assert_snapshot!(text, @r"
        data,detector,pair,layout,range_from_m,range_to_m,gap_m,n_pairs,n_seen,n_separated,n_joined,separated,separated_low,separated_high
        simulated,grid,cars,beside,5.0,10.0,0.20,12,10,7,3,0.7000,0.3968,0.8922
        simulated,grid,cars,beside,10.0,20.0,0.30,12,0,0,0,,,
        ");
        assert_eq!(rows_of::<GapRow>(&text).unwrap().len(), rows.len());
    }
}
