//! How far detectors agree where nothing is labelled.

use crate::files::fixed_decimals::fixed_decimals;
use crate::rows::agreement_row::AgreementRow;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};

/// A table for each data set and task, with a line and a column for each detector.
#[derive(Debug, Clone, Copy)]
pub struct AgreementOfDetectors<'a> {
    /// The agreement of each two detectors, one pair after the other.
    pub rows: &'a [AgreementRow],
}

const TITLE_OF_OTHERS: &str = "also found by [%]";
const FOUND_BY_OTHERS: &str = "also found by: share of a detector's detections that the other one has, too: they share half of the \
    points of both, and are matched one with one. alone: share that no other one has.";
const UNLABELLED: &str = "The scans have no labels, so there are no scores.";

impl Tabular for AgreementOfDetectors<'_> {
    fn sheet(&self) -> Sheet {
        let parts =
            self.rows.chunk_by(|a, b| (&a.dataset, a.task) == (&b.dataset, b.task)).map(|rows| Part {
                title: Some(format!(
                    "Task {} on {}, {} scans without labels.",
                    rows[0].task, rows[0].dataset, rows[0].n_scans
                )),
                grid: grid(rows),
            });
        let mut notes = vec![UNLABELLED];
        if self.rows.iter().any(|it| it.detector != it.other) {
            notes.insert(0, FOUND_BY_OTHERS);
        }
        Sheet::of_parts(parts.collect(), notes.into_iter().map(str::to_owned).collect()).labelled("agreement")
    }
}

fn grid(rows: &[AgreementRow]) -> Grid {
    let of_detectors: Vec<&[AgreementRow]> = rows.chunk_by(|a, b| a.detector == b.detector).collect();
    let has_others = of_detectors.len() > 1;
    let mut columns = vec![Column::left("detector")];
    columns.extend(["detections", "a scan"].map(Column::number));
    if has_others {
        columns.push(Column::number("alone [%]"));
        let others = of_detectors.iter().map(|it| Column::number(it[0].detector.clone()));
        columns.extend(others.map(|it| it.within(TITLE_OF_OTHERS)));
    }
    let lines = of_detectors.iter().map(|of_detector| {
        let first = &of_detector[0];
        let share = |n: u64| match first.n_detections {
            0 => Cell::new("–"),
            all => Cell::new(fixed_decimals(100.0 * n as f64 / all as f64, 1)),
        };
        let a_scan = first.n_detections as f64 / first.n_scans.max(1) as f64;
        let texts = [first.detector.clone(), first.n_detections.to_string(), fixed_decimals(a_scan, 1)];
        let mut cells = texts.map(Cell::new).to_vec();
        if has_others {
            cells.push(share(first.n_alone));
            cells.extend(of_detectors.iter().map(|other| {
                let row = of_detector.iter().find(|it| it.other == other[0].detector);
                row.map_or_else(Cell::default, |it| share(it.n_both))
            }));
        }
        Line { kind: LineKind::Dataset, cells }
    });
    let lines = lines.collect();
    Grid { columns, lines }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;
    use crate::vocabulary::task::Task;

    #[test]
    fn every_share_is_of_the_detections_of_its_detector() {
        let row = |detector: &str,
                   other: &str,
                   [n_detections, n_other]: [u64; 2],
                   [n_both, n_alone]: [u64; 2]| AgreementRow {
            dataset: "robot".to_owned(),
            task: Task::Objects,
            detector: detector.to_owned(),
            other: other.to_owned(),
            n_scans: 4,
            n_detections,
            n_other,
            n_both,
            n_alone,
        };
        let rows = [
            row("grid", "tree", [10, 5], [4, 6]),
            row("grid", "none", [10, 0], [0, 6]),
            row("tree", "grid", [5, 10], [4, 1]),
            row("tree", "none", [5, 0], [0, 1]),
            row("none", "grid", [0, 10], [0, 0]),
            row("none", "tree", [0, 5], [0, 0]),
        ];
        let text = Terminal { width: Some(100) }.text(&AgreementOfDetectors { rows: &rows });
        insta::assert_snapshot!(text, @r"
        Task objects on robot, 4 scans without labels.

                                                  also found by [%]
                                                  ────────────────
        detector  detections  a scan  alone [%]   grid  tree  none
        ──────────────────────────────────────────────────────────
        grid              10     2.5       60.0         40.0   0.0
        tree               5     1.2       20.0   80.0         0.0
        none               0     0.0        –      –     –

        also found by: share of a detector's detections that the other one has, too: they share half of the
          points of both, and are matched one with one. alone: share that no other one has.
        The scans have no labels, so there are no scores.
        ");
    }

    #[test]
    fn a_single_detector_has_no_others() {
        let row = AgreementRow {
            dataset: "robot".to_owned(),
            task: Task::Objects,
            detector: "grid".to_owned(),
            other: "grid".to_owned(),
            n_scans: 4,
            n_detections: 10,
            n_other: 10,
            n_both: 10,
            n_alone: 0,
        };
        let text = Terminal::UNFOLDED.text(&AgreementOfDetectors { rows: &[row] });
        assert!(text.contains("2.5") && !text.contains("%]"), "{text}");
    }
}
