//! The table of how well the statistics of two collections of scans agree.

use crate::files::fixed_decimals::{decimals_or_dash, fixed_decimals, three_digits};
use crate::numbers::curve_pair::{ALIKE_FACTOR, Agreement, CurvePair, Sides};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};

/// One row a statistic, and beneath it the thresholds of bins.
#[derive(Debug, Clone, Copy)]
pub struct AgreementTable<'a> {
    /// The scans of each side, whether they are simulated, and their number.
    pub names: Sides<&'a str>,
    /// The statistics.
    pub curves: &'a [CurvePair],
}

impl Tabular for AgreementTable<'_> {
    fn sheet(&self) -> Sheet {
        let Self { names, curves } = *self;
        let grid = Grid { columns: columns(), lines: curves.iter().flat_map(lines).collect() };
        let mut sentences = vec![
            format!(
                "ratio: left divided by right. bins: bins with a ratio/all bins. alike: share of the bins with a ratio, in %, \
                 whose ratio is between 1/{ALIKE_FACTOR} and {ALIKE_FACTOR}. median: of the ratios. worst bin: the bin \
                 whose ratio is farthest from 1."
            ),
            format!("A bin has a ratio if it has at least {}.", thresholds(curves)),
        ];
        sentences.extend(
            left_out(curves).map(|it| format!("Bins without a ratio, because one side has too few: {it}.")),
        );
        let lead = vec![format!("Left:  {}", names.left), format!("Right: {}", names.right)];
        Sheet { lead, ..Sheet::of_parts(vec![Part { title: None, grid }], sentences) }
    }
}

fn columns() -> Vec<Column> {
    let about = ["statistic", "unit", "bins"].map(Column::left);
    let numbers = ["alike", "median"].map(Column::number);
    let worst =
        [Column::left("bin"), Column::number("left"), Column::number("right"), Column::number("ratio")];
    about.into_iter().chain(numbers).chain(worst.map(|it| it.within("worst bin"))).collect()
}

/// The row of a statistic and, if it has a focus, that of the bins there.
fn lines(curves: &CurvePair) -> Vec<Line> {
    let whole = line(LineKind::Dataset, curves.statistic.to_owned(), curves, curves.agreement());
    let in_focus = curves.focus_m.map(|[from_m, to_m]| {
        let name = format!("{from_m} to {to_m} m");
        line(LineKind::Detail, name, curves, curves.agreement_in_focus())
    });
    [whole].into_iter().chain(in_focus).collect()
}

fn line(kind: LineKind, name: String, curves: &CurvePair, agreement: Option<Agreement>) -> Line {
    let mut texts = vec![name, curves.unit.to_owned()];
    match agreement {
        Some(agreement) => texts.extend(numbers(curves, &agreement)),
        None => texts.extend(["none", "–", "–", "–", "–", "–", "–"].map(str::to_owned)),
    }
    Line { kind, cells: texts.into_iter().map(Cell::new).collect() }
}

fn numbers(curves: &CurvePair, agreement: &Agreement) -> [String; 7] {
    let worst = &curves.bins[agreement.worst_bin_idx];
    let text = |number: Option<f64>| number.map_or_else(|| "–".to_owned(), three_digits);
    [
        format!("{}/{}", agreement.n_compared, agreement.n_bins),
        fixed_decimals(100.0 * agreement.n_alike as f64 / agreement.n_compared as f64, 1),
        fixed_decimals(agreement.median_ratio, 2),
        worst.name.clone(),
        text(worst.measured.left.value),
        text(worst.measured.right.value),
        decimals_or_dash(curves.ratio(agreement.worst_bin_idx), 2),
    ]
}

/// The thresholds from which on bins have a ratio, in words; statistics of the same threshold together.
fn thresholds(curves: &[CurvePair]) -> String {
    let mut thresholds: Vec<(String, Vec<&str>)> = Vec::new();
    for pair in curves {
        let Sides { left, right } = pair.least_n;
        let on_the_left = if left == 0 { String::new() } else { format!(", and {left} on the left") };
        let threshold = format!("{right} {} on the right{on_the_left}", pair.counted);
        match thresholds.iter_mut().find(|(it, _)| *it == threshold) {
            Some((_, statistics)) => statistics.push(pair.statistic),
            None => thresholds.push((threshold, vec![pair.statistic])),
        }
    }
    let in_words = thresholds.iter().map(|(it, statistics)| format!("{it} ({})", statistics.join(", ")));
    in_words.collect::<Vec<_>>().join("; ")
}

/// Bins with values on both sides, but with too few on one of them to be compared, with their numbers; `None` if there are
/// none.
fn left_out(curves: &[CurvePair]) -> Option<String> {
    let of_pair = |pair: &CurvePair| {
        let too_few = pair.bins.iter().filter(|bin| {
            let Sides { left, right } = bin.measured;
            let is_enough = left.n >= pair.least_n.left && right.n >= pair.least_n.right;
            left.n > 0 && right.n > 0 && !is_enough
        });
        let in_words = too_few.map(|bin| {
            let Sides { left, right } = bin.measured;
            format!("{} ({} against {} {})", bin.name, left.n, right.n, pair.counted)
        });
        let bins: Vec<String> = in_words.collect();
        (!bins.is_empty()).then(|| format!("{} {}", pair.statistic, bins.join(", ")))
    };
    let pairs: Vec<String> = curves.iter().filter_map(of_pair).collect();
    (!pairs.is_empty()).then(|| pairs.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::curve_pair::tests::pair;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;

    #[test]
    fn bins_of_too_little_are_reported() {
        let mut tracks = pair(&[(120.0, 100.0), (3.0, 1.0), (5.0, 4.0)]);
        tracks.statistic = "points_per_track";
        tracks.counted = "tracks";
        tracks.bins[1].measured.right.n = 3;
        // No value on one side is not the same as too few.
        tracks.bins[2].measured.left.n = 0;
        assert_eq!(left_out(&[tracks]).as_deref(), Some("points_per_track 2-3 (10 against 3 tracks)"));
        assert_eq!(left_out(&[pair(&[(1.0, 1.0)])]), None);
    }

    #[test]
    fn every_statistic_has_a_row_with_its_worst_bin() {
        let mut density = pair(&[(120.0, 100.0), (3.0, 1.0), (0.5, 0.0)]);
        density.focus_m = Some([1.0, 2.0]);
        let mut nothing = pair(&[(1.0, 0.0)]);
        nothing.statistic = "points_per_car";
        nothing.least_n.left = 5;
        nothing.counted = "cars";
        let names = Sides { left: "street (simulated), 2 scans", right: "kitti, 40 scans" };
        let table = AgreementTable { names, curves: &[density, nothing] };
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&table), @r"
        Left:  street (simulated), 2 scans
        Right: kitti, 40 scans

                                                                 worst bin
                                                         ──────────────────────────
        statistic       unit       bins  alike  median   bin    left   right  ratio
        ───────────────────────────────────────────────────────────────────────────
        ring_density    points/m²  2/3    50.0    1.20   2-3    3.00    1.00   3.00
          1 to 2 m      points/m²  1/1   100.0    1.20   1-2  120     100      1.20
        points_per_car  points/m²  none    –      –      –      –       –      –

        ratio: left divided by right. bins: bins with a ratio/all bins. alike: share of the bins with a
          ratio, in %, whose ratio is between 1/1.5 and 1.5. median: of the ratios. worst bin: the bin whose
          ratio is farthest from 1.
        A bin has a ratio if it has at least 5 points on the right (ring_density); 5 cars on the right, and
          5 on the left (points_per_car).
        ");
    }
}
