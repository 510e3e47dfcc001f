//! A run on one screen: a table for each task and origin, facts that decide the lead, and the verdict.

use crate::numbers::pools::{Pool, pools};
use crate::rows::agreement_row::AgreementRow;
use crate::tables::agreement_table::AgreementOfDetectors;
use crate::tables::class_table::ClassTable;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::notes::{Notes, abbreviations, about_detectors, about_interval, about_matching};
use crate::tables::protocol_in_short::ProtocolInShort;
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::tables::task_grids::{fps_cell, interval_cell, rate_cell, recall_cell};
use crate::tables::task_table::{MeasuredRow, Score, TableRow, TaskTable};
use crate::vocabulary::extent::Extent;

/// Where the rest is.
const IN_FULL: &str =
    "Each data set, counts, times and published numbers are on the page, and printed with -v.";

/// A run in few lines. Its page has everything.
#[derive(Debug, Clone, PartialEq)]
pub struct RunInShort {
    /// Task by task, of runs that have labels.
    pub tables: Vec<TaskTable>,
    /// Classes that detectors give, on all data sets of one origin together.
    pub classes: Vec<ClassTable>,
    /// Numbers under protocols of others.
    pub protocols: Vec<ProtocolInShort>,
    /// How far detectors agree where nothing is labelled.
    pub agreement: Vec<AgreementRow>,
    /// The leaders, and the fastest detectors, a text each.
    pub verdict: Vec<String>,
}

impl Tabular for RunInShort {
    fn sheet(&self) -> Sheet {
        let of_tasks = self.tables.iter().flat_map(parts);
        let of_classes = self.classes.iter().map(ClassTable::rates_sheet);
        let of_protocols: Vec<Sheet> = of_classes.chain(self.protocols.iter().map(Tabular::sheet)).collect();
        let of_agreement =
            (!self.agreement.is_empty()).then(|| AgreementOfDetectors { rows: &self.agreement }.sheet());
        let more = of_agreement.iter().chain(&of_protocols);
        let parts: Vec<Part> = of_tasks.chain(more.clone().flat_map(|it| it.parts.clone())).collect();
        let sentences = self.sentences().into_iter().chain(more.flat_map(|it| it.notes.sentences.clone()));
        let mut unique: Vec<String> = Vec::new();
        for it in sentences {
            if !unique.contains(&it) {
                unique.push(it);
            }
        }
        let notes = Notes::beneath(parts.iter().map(|it| &it.grid), Vec::new());
        // The meaning of a sign may stand beneath a part already.
        unique.retain(|it| !notes.sentences.contains(it));
        Sheet::of_parts(parts, unique)
    }
}

impl RunInShort {
    /// Sentences about the numbers of tasks, and about facts that decide the lead.
    fn sentences(&self) -> Vec<String> {
        let Some(first) = self.tables.first() else { return Vec::new() };
        let about_numbers =
            format!("{} {}", about_matching(&first.matching_criterion), abbreviations(&first.cpu_model));
        let about_intervals = first.block_kind().map(|it| format!("95 %: {}", about_interval(it)));
        let is_unknown = |it: &TaskTable| headlines(it).iter().any(|(_, row)| has_unknown_false(row));
        let about_unknown = self.tables.iter().any(is_unknown).then(|| {
            "Without F-rate: not every class of object is annotated, so false objects cannot be counted."
                .to_owned()
        });
        let about_detectors = self.tables.iter().flat_map(about_detectors).chain([IN_FULL.to_owned()]);
        [Some(about_numbers), about_intervals, about_unknown]
            .into_iter()
            .flatten()
            .chain(about_detectors)
            .collect()
    }
}

/// The rows of all data sets of one origin together, each with these data sets.
fn headlines(table: &TaskTable) -> Vec<(Pool, &MeasuredRow)> {
    let measured = || {
        table.rows.iter().filter_map(|it| match it {
            TableRow::Measured(row) => Some(row),
            TableRow::Paper(_) => None,
        })
    };
    let of_datasets = measured().filter_map(|it| match &it.extent {
        Extent::Dataset(id) => Some((id.as_str(), it.origin)),
        Extent::Overall | Extent::OverallOf(_) => None,
    });
    let with_row = |pool: Pool| measured().find(|it| it.extent == pool.extent).map(|it| (pool, it));
    pools(of_datasets).into_iter().filter_map(with_row).collect()
}

fn has_unknown_false(row: &MeasuredRow) -> bool {
    row.scores.iter().any(|it| it.counts.fo().is_none())
}

/// A table for each origin.
fn parts(table: &TaskTable) -> Vec<Part> {
    let part = |(pool, row): (Pool, &MeasuredRow)| {
        let n_scans = row.scores.first().map_or(0, |it| it.n_scans);
        let title = format!("Task {} on {}, {n_scans} scans. Rates in %.", table.task, pool.in_words());
        Part { title: Some(title), grid: grid(&table.detectors, row) }
    };
    headlines(table).into_iter().map(part).collect()
}

fn grid(detectors: &[String], row: &MeasuredRow) -> Grid {
    let titles: &[&'static str] = if has_unknown_false(row) {
        &["recall", "95 %", "NO", "found", "fps"]
    } else {
        &["F-rate", "95 %", "precision", "recall", "NO", "ND", "fps"]
    };
    let columns = [Column::left("detector")].into_iter().chain(titles.iter().map(|it| Column::number(*it)));
    let lines = detectors.iter().zip(&row.scores).map(|(detector, score)| {
        let numbers = if has_unknown_false(row) { found_cells(score) } else { rate_cells(score) };
        let cells =
            [Cell::new(detector.as_str())].into_iter().chain(numbers).chain([fps_cell(score)]).collect();
        Line { kind: LineKind::Dataset, cells }
    });
    Grid { columns: columns.collect(), lines: lines.collect() }
}

fn rate_cells(score: &Score) -> Vec<Cell> {
    let counts = score.counts;
    vec![
        rate_cell(counts.f_rate(), counts),
        interval_cell(score.intervals.f_rate),
        rate_cell(counts.precision(), counts),
        recall_cell(counts),
        Cell::new(counts.no().to_string()),
        counts.nd().map_or_else(Cell::default, |it| Cell::new(it.to_string())),
    ]
}

fn found_cells(score: &Score) -> Vec<Cell> {
    let counts = score.counts;
    let [no, tp] = [counts.no(), counts.tp()].map(|it| Cell::new(it.to_string()));
    vec![recall_cell(counts), interval_cell(score.intervals.recall), no, tp]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;
    use crate::tables::sample;

    fn text(short: &RunInShort) -> String {
        Terminal { width: Some(100) }.text(short)
    }

    fn short() -> RunInShort {
        let (protocols, agreement, verdict) = (Vec::new(), Vec::new(), Vec::new());
        RunInShort { tables: sample::tables().to_vec(), classes: Vec::new(), protocols, agreement, verdict }
    }

    #[test]
    fn a_run_fits_one_screen() {
        insta::assert_snapshot!(text(&short()), @r"
        Task objects on main_road (simulated), 20 scans. Rates in %.

        detector  F-rate       95 %  precision  recall   NO   ND     fps
        ────────────────────────────────────────────────────────────────
        paper       88.9  86.4–90.4       87.7    90.0  412  423  121
        kd-tree     76.2  73.7–77.7       70.8    82.5  412  480    8.04
        pca         76.9  74.4–78.4       76.6    77.2  412  415   46.0

        Task objects on 2 recorded data sets, 40 scans. Rates in %.

        detector  recall  95 %   NO  found     fps
        ──────────────────────────────────────────
        paper       91.0        379    345  101
        kd-tree     87.6        379    332    0.49
        pca         64.4        379    244   40.4

        Task vehicles on main_road (simulated), 20 scans. Rates in %.

        detector  F-rate  95 %  precision  recall   NO   ND     fps
        ───────────────────────────────────────────────────────────
        paper       95.5             95.8    95.3  190  189  121
        kd-tree     84.2             79.4    89.5  190  214    8.04
        pca        100.0            100.0   100.0  190  190   46.0

        Task vehicles on 2 recorded data sets, 40 scans. Rates in %.

        detector  F-rate  95 %  precision  recall   NO    ND    fps
        ───────────────────────────────────────────────────────────
        paper       87.2             86.5    87.9  240   244  98.2
        kd-tree     26.9             16.0    82.9  240  1242   0.47
        pca         71.6             83.8    62.5  240   179  40.4

        Matched by a point-set IoU of at least 0.5. NO: annotations that count. ND: detections that count,
          TP + FO. F-rate: 2 TP / (NO + ND). fps: scans per second, detection only, on Example CPU @ 2 GHz.
        95 %: cluster bootstrap, 10000 resamples of whole drives.
        Without F-rate: not every class of object is annotated, so false objects cannot be counted.
        Each data set, counts, times and published numbers are on the page, and printed with -v.
        ");
    }
}
