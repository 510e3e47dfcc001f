//! How far detectors agree with one another where nothing is labelled.

use crate::files::fixed_decimals::fixed_decimals;
use crate::rows::agreement_row::AgreementRow;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Sheet, Tabular};

/// A line for each two detectors, one after the other.
#[derive(Debug, Clone, Copy)]
pub struct AgreementOfDetectors<'a> {
    /// The lines.
    pub rows: &'a [AgreementRow],
}

impl Tabular for AgreementOfDetectors<'_> {
    fn sheet(&self) -> Sheet {
        let mut columns = ["data set", "task", "detector", "compared with"].map(Column::left).to_vec();
        columns.extend(["scans", "detections", "a scan", "agreed [%]"].map(Column::number));
        let mut before = None;
        let lines = self.rows.iter().map(|row| {
            let place = (&row.dataset, row.task, &row.detector);
            let is_first = before.replace(place) != Some(place);
            let head = if is_first {
                [row.dataset.clone(), row.task.to_string(), row.detector.clone()]
            } else {
                [const { String::new() }; 3]
            };
            let counts = if is_first {
                let a_scan = row.n_detections as f64 / row.n_scans.max(1) as f64;
                [row.n_scans.to_string(), row.n_detections.to_string(), fixed_decimals(a_scan, 1)]
            } else {
                [const { String::new() }; 3]
            };
            let agreed = match row.n_detections {
                0 => "–".to_owned(),
                n => fixed_decimals(100.0 * row.n_both as f64 / n as f64, 1),
            };
            let cells = head.into_iter().chain([row.other.clone()]).chain(counts).chain([agreed]);
            let kind = if is_first { LineKind::Dataset } else { LineKind::Detail };
            Line { kind, cells: cells.map(Cell::new).collect() }
        });
        let grid = Grid { columns, lines: lines.collect() };
        let notes = [
            "agreed: detections of the detector that the other one has, too: they share half of the points of both, and are matched one \
             with one.",
            "Nothing is labelled, so nothing was scored: who is right is not known.",
        ];
        let title = "Detections, and how far detectors agree".to_owned();
        Sheet::of(title, grid, notes.map(str::to_owned).to_vec()).labelled("agreement")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;
    use crate::vocabulary::task::Task;

    #[test]
    fn every_share_is_of_the_detections_of_its_detector() {
        let row = |detector: &str, other: &str, [n_detections, n_other]: [u64; 2], n_both| AgreementRow {
            dataset: "robot".to_owned(),
            task: Task::Objects,
            detector: detector.to_owned(),
            other: other.to_owned(),
            n_scans: 4,
            n_detections,
            n_other,
            n_both,
        };
        let rows = [
            row("grid", "tree", [10, 5], 4),
            row("grid", "none", [10, 0], 0),
            row("tree", "grid", [5, 10], 4),
            row("none", "grid", [0, 10], 0),
        ];
        let text = Terminal::UNFOLDED.text(&AgreementOfDetectors { rows: &rows });
        let shares: Vec<&str> =
            text.lines().skip(4).take(4).map(|it| it.rsplit(' ').next().expect("it has words")).collect();
        assert_eq!(shares, ["40.0", "0.0", "80.0", "–"], "{text}");
    }
}
