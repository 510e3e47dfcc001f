//! How many annotated objects survive each step of a detector.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::CsvRow;
use crate::files::fixed_decimals::fixed_decimals;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Sheet, Tabular};

/// Annotated objects of one class in one data set, or of all classes, and how many of them survive.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SurvivalRow {
    /// The data set.
    pub data: String,
    /// Whether it is simulated.
    pub simulated: bool,
    /// The class, or `all`.
    pub class: String,
    /// Annotated objects that count.
    pub objects: usize,
    /// At least half of their points are candidates.
    pub candidates: usize,
    /// They are shown by a group of the tree.
    pub in_tree: usize,
    /// They are shown by a group whose size is that of an object.
    pub described: usize,
    /// They are shown by a group that is taken.
    pub taken: usize,
    /// They are shown by a detection of the right class.
    pub classified: usize,
}

impl CsvRow for SurvivalRow {
    const COLUMNS: &'static [&'static str] = &[
        "data",
        "simulated",
        "class",
        "objects",
        "candidates",
        "in_tree",
        "described",
        "taken",
        "classified",
    ];
}

/// A line for each class of each data set.
#[derive(Debug, Clone, Copy)]
pub struct SurvivalTable<'a> {
    /// The lines.
    pub rows: &'a [SurvivalRow],
}

impl Tabular for SurvivalTable<'_> {
    fn sheet(&self) -> Sheet {
        let mut columns = ["data set", "class"].map(Column::left).to_vec();
        let titles = ["NO", "candidates", "in the tree", "described", "taken", "classified"];
        columns.extend(titles.map(Column::number));
        let mut before = None;
        let lines = self.rows.iter().map(|row| {
            let is_first = before.replace(&row.data) != Some(&row.data);
            let simulated = if row.simulated { " (simulated)" } else { "" };
            let data = if is_first { format!("{}{simulated}", row.data) } else { String::new() };
            let counts = [row.candidates, row.in_tree, row.described, row.taken, row.classified];
            let share = |n: usize| match row.objects {
                0 => "–".to_owned(),
                of => fixed_decimals(100.0 * n as f64 / of as f64, 1),
            };
            let head = [data, row.class.clone(), row.objects.to_string()];
            let cells = head.into_iter().chain(counts.map(share)).map(Cell::new).collect();
            let kind = if is_first { LineKind::Dataset } else { LineKind::Detail };
            Line { kind, cells }
        });
        let grid = Grid { columns, lines: lines.collect() };
        let notes = [
            "candidates: half of its points and more may belong to objects.",
            "in the tree, described, taken: such a group has points with an intersection over union of at least 0.5.",
            "classified: a detection shows it, and tells whether it is a vehicle.",
        ];
        let title = "Annotated objects that survive each step, in %".to_owned();
        Sheet::of(title, grid, notes.map(str::to_owned).to_vec()).labelled("oracle")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;

    #[test]
    fn every_share_is_of_the_objects_of_its_line() {
        let row = |class: &str, objects, taken| SurvivalRow {
            data: "street".to_owned(),
            simulated: true,
            class: class.to_owned(),
            objects,
            candidates: objects,
            in_tree: objects,
            described: objects,
            taken,
            classified: 0,
        };
        let rows = [row("all", 8, 7), row("tram", 0, 0)];
        insta::assert_snapshot!(Terminal::UNFOLDED.text(&SurvivalTable { rows: &rows }), @r"
        Annotated objects that survive each step, in %

        data set            class  NO  candidates  in the tree  described  taken  classified
        ────────────────────────────────────────────────────────────────────────────────────
        street (simulated)  all     8       100.0        100.0      100.0   87.5         0.0
                            tram    0         –            –          –      –           –

        candidates: half of its points and more may belong to objects.
        in the tree, described, taken: such a group has points with an intersection over union of at least
          0.5.
        classified: a detection shows it, and tells whether it is a vehicle.
        ");
    }
}
