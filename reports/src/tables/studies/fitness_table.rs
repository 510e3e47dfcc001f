//! The table of the cell sizes that readings of the fitness recommend, and of what these cost.

use std::collections::{BTreeMap, BTreeSet};

use crate::files::fixed_decimals::{Fixed, decimals_or_dash, fixed_decimals, percent_or_dash};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::verdicts::fitness_verdict::{CONFIGURED, FitnessVerdict};
use crate::vocabulary::extent::Extent;
use crate::vocabulary::task::Task;

const TITLE: &str = "Cell size that each reading of the cell fitness recommends.";

const SUMMARY_TITLE: &str = "The same over all data sets, with equal weights.";

const OF_SEVERAL: &str = "Over all data sets: on how many curves the reading recommends a cell size, on how many of them the least or \
     greatest of the sweep, the mean and the greatest loss, and the mean rank correlation.";

const NOTES: [&str; 3] = [
    "best: the cell size with the highest rate, in m, and that rate in %. A reading recommends the cell size with its \
     greatest value, within its range if it has one. *: the least or greatest cell size of the sweep, so the reading may \
     recommend one beyond it.",
    "defined: cell sizes at which the reading has a value, within its range if it has one/all cell sizes. lost: best rate \
     minus rate at the recommended size, in percentage points. rank: Spearman's rank correlation of reading and rate. as \
     configured: the configured cell size.",
    "Where false objects cannot be counted, the rate is the recall; very large cells may raise it by joining everything.",
];

/// Recommendations on every curve, and over all data sets.
#[derive(Debug, Clone, Copy)]
pub struct FitnessTable<'a> {
    /// The verdicts on the readings of every curve.
    pub verdicts: &'a [FitnessVerdict],
}

impl Tabular for FitnessTable<'_> {
    fn sheet(&self) -> Sheet {
        let part = |title: &str, grid| Part { title: Some(title.to_owned()), grid };
        let mut parts = vec![part(TITLE, grid(self.verdicts))];
        let mut notes = NOTES.map(str::to_owned).to_vec();
        let datasets: BTreeSet<&str> = of_datasets(self.verdicts).map(|it| it.dataset.as_str()).collect();
        if datasets.len() > 1 {
            parts.push(part(SUMMARY_TITLE, summary_grid(self.verdicts)));
            notes.push(OF_SEVERAL.to_owned());
        }
        Sheet::of_parts(parts, notes).labelled("cell-fitness")
    }
}

/// The verdicts about one data set.
fn of_datasets(verdicts: &[FitnessVerdict]) -> impl Iterator<Item = &FitnessVerdict> {
    verdicts.iter().filter(|it| !Extent::is_name_of_several(&it.dataset))
}

/// The conclusion, a sentence for each task: the loss of the best variant of the formula against the best cell size, beside
/// that of the configured size.
pub fn fitness_sentences(verdicts: &[FitnessVerdict]) -> Vec<String> {
    let tasks: BTreeSet<(Task, &str)> = verdicts.iter().map(|it| (it.task, it.rate.as_str())).collect();
    let sentence = |(task, rate): (Task, &str)| {
        let mut losses: BTreeMap<&str, Vec<Option<f64>>> = BTreeMap::new();
        for it in of_datasets(verdicts).filter(|it| it.task == task && it.rate == rate) {
            losses.entry(&it.reading).or_default().push(it.loss.map(|it| it.0));
        }
        let mean = |losses: &Vec<Option<f64>>| {
            let sum: f64 = losses.iter().copied().sum::<Option<f64>>()?;
            Some(sum / losses.len() as f64)
        };
        let points = |it: f64| fixed_decimals(100.0 * it, 1);
        let variants = losses.iter().filter(|it| *it.0 != CONFIGURED);
        let least =
            variants.filter_map(|(name, it)| Some((name, mean(it)?))).min_by(|a, b| a.1.total_cmp(&b.1));
        let (name, loss) = least?;
        let configured = losses
            .get(CONFIGURED)
            .and_then(mean)
            .map_or_else(String::new, |it| format!(", the configured cell size {}", points(it)));
        Some(format!(
            "Cell fitness, {task}: against the best cell size, the reading that does best ({name}) loses {} points of {rate} on \
             average{configured}.",
            points(loss)
        ))
    };
    tasks.into_iter().filter_map(sentence).collect()
}

fn grid(verdicts: &[FitnessVerdict]) -> Grid {
    let names = ["data set, sensor, task, rate", "reading"].map(Column::left);
    let numbers = ["NO", "best m", "best %", "defined", "recommends m", "there %", "lost", "rank"];
    let columns = names.into_iter().chain(numbers.map(Column::number)).collect();
    let mut lines = Vec::new();
    let mut before = String::new();
    for verdict in verdicts {
        let subject = subject(verdict);
        let is_first = subject != before;
        lines.push(line(verdict, if is_first { &subject } else { "" }));
        before = subject;
    }
    Grid { columns, lines }
}

/// The mean cost of each reading, for every task and rate.
fn summary_grid(verdicts: &[FitnessVerdict]) -> Grid {
    let names = ["task, rate", "reading"].map(Column::left);
    let numbers = ["data sets", "recommends", "at an end", "mean lost", "most lost", "mean rank"];
    let columns = names.into_iter().chain(numbers.map(Column::number)).collect();
    let mut groups: Vec<(String, &str, Vec<&FitnessVerdict>)> = Vec::new();
    for verdict in of_datasets(verdicts) {
        let subject = format!("{}, {}", verdict.task, verdict.rate);
        match groups.iter_mut().find(|(task, reading, _)| *task == subject && *reading == verdict.reading) {
            Some((_, _, of_group)) => of_group.push(verdict),
            None => groups.push((subject, &verdict.reading, vec![verdict])),
        }
    }
    groups.sort_by(|a, b| a.0.cmp(&b.0));
    Grid {
        columns,
        lines: groups.iter().map(|(subject, reading, it)| summary_line(subject, reading, it)).collect(),
    }
}

fn summary_line(subject: &str, reading: &str, verdicts: &[&FitnessVerdict]) -> Line {
    let losses: Vec<f64> = verdicts.iter().filter_map(|it| Some(it.loss?.0)).collect();
    let ranks: Vec<f64> = verdicts.iter().filter_map(|it| Some(it.rank_correlation?.0)).collect();
    let mean =
        |values: &[f64]| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
    let count =
        |is_counted: fn(&&&FitnessVerdict) -> bool| verdicts.iter().filter(is_counted).count().to_string();
    let cells = [
        subject.to_owned(),
        reading.to_owned(),
        verdicts.len().to_string(),
        count(|it| it.recommended_cell_size_m.is_some()),
        count(|it| it.recommends_an_end == Some(true)),
        percent_or_dash(mean(&losses)),
        percent_or_dash(losses.iter().copied().reduce(f64::max)),
        decimals_or_dash(mean(&ranks), 2),
    ];
    Line { kind: LineKind::Dataset, cells: cells.map(Cell::new).to_vec() }
}

/// The subject of a curve, which all its readings have in common.
fn subject(verdict: &FitnessVerdict) -> String {
    let FitnessVerdict { dataset, origin, sensor, detector, others, task, rate, .. } = verdict;
    let origin = origin.in_brackets();
    let others = if others.is_empty() { String::new() } else { format!(", {others}") };
    format!("{dataset}{origin}, {sensor}, {detector}{others}, {task}, {rate}")
}

fn line(verdict: &FitnessVerdict, subject: &str) -> Line {
    let percent = |value: Option<Fixed<6>>| percent_or_dash(value.map(|it| it.0));
    let size = |value: Option<Fixed<3>>| decimals_or_dash(value.map(|it| it.0), 2);
    let mark = if verdict.recommends_an_end == Some(true) { "*" } else { "" };
    let of_curve = |text: String| if subject.is_empty() { String::new() } else { text };
    let cells = [
        subject.to_owned(),
        verdict.reading.clone(),
        of_curve(verdict.no.to_string()),
        of_curve(size(verdict.best_cell_size_m)),
        of_curve(percent(verdict.best_rate)),
        format!("{}/{}", verdict.n_defined, verdict.n_points),
        format!("{}{mark}", size(verdict.recommended_cell_size_m)),
        percent(verdict.rate_there),
        percent(verdict.loss),
        decimals_or_dash(verdict.rank_correlation.map(|it| it.0), 2),
    ];
    Line { kind: LineKind::Dataset, cells: cells.map(Cell::new).to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::sweep_score::tests::four_cell_sizes;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;
    use crate::tables::formats::terminal::Terminal;
    use crate::verdicts::fitness_verdict::fitness_verdicts;

    #[test]
    fn readings_stand_below_each_other() {
        let sweep = four_cell_sizes();
        let verdicts = fitness_verdicts(&sweep);
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&FitnessTable { verdicts: &verdicts }), @r"
        Cell size that each reading of the cell fitness recommends.

        data set, sensor, task, rate                               reading        NO  best m  best %  defined  recommends m  there %  lost  rank
        ────────────────────────────────────────────────────────────────────────────────────────────────────────────────────────────────────────
        street (simulated), vlp-16, hierarchical, objects, F-rate  printed        10    0.40    80.0      1/4         0.80*     50.0  30.0  –
                                                                   dense-share                            4/4         0.60      60.0  20.0  0.80
                                                                   as configured                          1/4         0.40      80.0   0.0  –

        best: the cell size with the highest rate, in m, and that rate in %. A reading recommends the cell
          size with its greatest value, within its range if it has one. *: the least or greatest cell size
          of the sweep, so the reading may recommend one beyond it.
        defined: cell sizes at which the reading has a value, within its range if it has one/all cell sizes.
          lost: best rate minus rate at the recommended size, in percentage points. rank: Spearman's rank
          correlation of reading and rate. as configured: the configured cell size.
        Where false objects cannot be counted, the rate is the recall; very large cells may raise it by
          joining everything.
        ");
        let markdown = Markdown.text(&FitnessTable { verdicts: &verdicts });
        assert!(
            markdown.contains("| dense-share |") && markdown.contains("street (simulated)"),
            "{markdown}"
        );
    }
}
