//! The table of how well the statistics of two collections of scans agree.

use std::fmt::Write as _;

use crate::curve_pair::{ALIKE_FACTOR, Agreement, CurvePair, Sides};
use crate::fixed_decimals::{fixed_decimals, three_digits};
use crate::table::grid::{Alignment, Cell, Column, Grid, Line, LineKind};
use crate::table::notes::Notes;
use crate::table::terminal::{wrapped, write_grid};

/// The table for a terminal: one row a statistic, then from where on a bin counts.
///
/// `names` says what was measured on each side, whether it is simulated, and of how many scans.
pub fn agreement_table(names: Sides<&str>, curves: &[CurvePair]) -> String {
    let mut text = format!("Left:  {}\nRight: {}\n\n", names.left, names.right);
    let grid = Grid { columns: columns(), lines: curves.iter().map(line).collect() };
    write_grid(&mut text, &grid, &Notes::none());
    text.push('\n');
    text.push_str(&wrapped(&format!(
        "ratio: left over right. alike: share of the bins compared, in %, whose ratio is within a factor of \
         {ALIKE_FACTOR} of 1, either way. worst bin: the one whose ratio is farthest from 1."
    )));
    text.push_str(&wrapped(&format!("compared: bins made of at least {}.", thresholds(curves))));
    text
}

fn columns() -> Vec<Column> {
    let column =
        |group: Option<&str>, title, alignment| Column { group: group.map(str::to_owned), title, alignment };
    let worst = Some("worst bin");
    vec![
        column(None, "statistic", Alignment::Left),
        column(None, "unit", Alignment::Left),
        column(None, "compared", Alignment::Left),
        column(None, "alike", Alignment::Decimal),
        column(None, "median ratio", Alignment::Decimal),
        column(worst, "bin", Alignment::Left),
        column(worst, "left", Alignment::Decimal),
        column(worst, "right", Alignment::Decimal),
        column(worst, "ratio", Alignment::Decimal),
    ]
}

fn line(curves: &CurvePair) -> Line {
    let agreement = curves.agreement();
    let n_compared = agreement.map_or(0, |it| it.n_compared);
    let mut texts = vec![
        curves.statistic.to_owned(),
        curves.unit.to_owned(),
        format!("{n_compared} of {}", curves.bins.len()),
    ];
    match agreement {
        Some(agreement) => texts.extend(numbers(curves, &agreement)),
        None => texts.extend(["–", "–", "–", "–", "–", "–"].map(str::to_owned)),
    }
    Line { kind: LineKind::Dataset, cells: texts.into_iter().map(Cell::new).collect() }
}

fn numbers(curves: &CurvePair, agreement: &Agreement) -> [String; 6] {
    let worst = &curves.bins[agreement.worst_bin_idx];
    let text = |number: Option<f64>| number.map_or_else(|| "–".to_owned(), three_digits);
    [
        fixed_decimals(100.0 * agreement.n_alike as f64 / agreement.n_compared as f64, 1),
        fixed_decimals(agreement.median_ratio, 2),
        worst.name.clone(),
        text(worst.measured.left.value),
        text(worst.measured.right.value),
        curves.ratio(agreement.worst_bin_idx).map_or_else(|| "–".to_owned(), |it| fixed_decimals(it, 2)),
    ]
}

/// From where on the bins of each statistic are compared, in words.
fn thresholds(curves: &[CurvePair]) -> String {
    let mut text = String::new();
    for (curves_idx, curves) in curves.iter().enumerate() {
        let Sides { left, right } = curves.least_n;
        let separator = if curves_idx == 0 { "" } else { "; " };
        let on_the_left = if left == 0 { String::new() } else { format!(", {left} on the left") };
        let sides = format!("{right} {} on the right{on_the_left}", curves.counted);
        write!(text, "{separator}{sides} ({})", curves.statistic)
            .expect("a string takes all that is written");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve_pair::tests::pair;

    #[test]
    fn every_statistic_has_a_row_with_its_worst_bin() {
        let density = pair(&[(120.0, 100.0), (3.0, 1.0), (0.5, 0.0)]);
        let mut nothing = pair(&[(1.0, 0.0)]);
        nothing.statistic = "points_per_car";
        nothing.least_n.left = 5;
        nothing.counted = "cars";
        let names = Sides { left: "street (simulated), 2 scans", right: "kitti, 40 scans" };
        insta::assert_snapshot!(agreement_table(names, &[density, nothing]), @r"
        Left:  street (simulated), 2 scans
        Right: kitti, 40 scans

                                                                          worst bin
                                                                   ───────────────────────
        statistic       unit       compared  alike  median ratio   bin  left  right  ratio
        ──────────────────────────────────────────────────────────────────────────────────
        ring_density    points/m²  2 of 3     50.0          1.20   2-3  3.00   1.00   3.00
        points_per_car  points/m²  0 of 1      –            –      –    –      –      –

        ratio: left over right. alike: share of the bins compared, in %, whose ratio is within a factor of
          1.5 of 1, either way. worst bin: the one whose ratio is farthest from 1.
        compared: bins made of at least 5 points on the right (ring_density); 5 cars on the right, 5 on the
          left (points_per_car).
        ");
    }
}
