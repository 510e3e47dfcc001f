//! F-rates after each step away from the letter of the papers, data set by data set.

use crate::files::fixed_decimals::percent_or_dash;
use crate::reproduction::steps::Basis;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Sheet, Tabular};

/// A row for each step and each rival, and a column for each data set.
#[derive(Debug, Clone, PartialEq)]
pub struct StepTable {
    /// Title.
    pub title: String,
    /// Data sets with the number of annotations that count.
    pub scenes: Vec<(String, u64)>,
    /// Rows, the method to the letter first.
    pub rows: Vec<StepRow>,
    /// Sentences beneath.
    pub notes: Vec<String>,
}

/// F-rates after a step, or of a rival.
#[derive(Debug, Clone, PartialEq)]
pub struct StepRow {
    /// Step or rival in words.
    pub name: String,
    /// Section of the paper.
    pub place: String,
    /// Basis of the step; `None` for a rival.
    pub basis: Option<Basis>,
    /// F-rate on each data set, 0 to 1.
    pub rates: Vec<Option<f64>>,
}

impl Tabular for StepTable {
    fn sheet(&self) -> Sheet {
        let mut columns = ["each step upon those before it", "place", "rests on"].map(Column::left).to_vec();
        let of_scene = |(scene, no): &(String, u64)| Column::number(format!("NO {no}")).within(scene.clone());
        columns.extend(self.scenes.iter().map(of_scene));
        let line = |row: &StepRow| {
            let basis = row.basis.map_or("", Basis::name).to_owned();
            let kind = if row.basis.is_some() { LineKind::Dataset } else { LineKind::Paper };
            let rates = row.rates.iter().map(|rate| percent_or_dash(*rate));
            let cells = [row.name.clone(), row.place.clone(), basis].into_iter().chain(rates);
            Line { kind, cells: cells.map(Cell::new).collect() }
        };
        let grid = Grid { columns, lines: self.rows.iter().map(line).collect() };
        Sheet::of(self.title.clone(), grid, self.notes.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;

    #[test]
    fn steps_say_what_they_rest_on_and_rivals_stand_below() {
        let row = |name: &str, basis, rate| StepRow {
            name: name.to_owned(),
            place: "HG 4".to_owned(),
            basis,
            rates: vec![rate],
        };
        let table = StepTable {
            title: "Steps".to_owned(),
            scenes: vec![("street".to_owned(), 12)],
            rows: vec![
                row("letter", Some(Basis::Text), Some(0.5)),
                row("walls", Some(Basis::Ours), Some(0.75)),
                row("kd-tree", None, None),
            ],
            notes: Vec::new(),
        };
        insta::assert_snapshot!(Markdown.text(&table), @r"
        **Steps**

        | each step upon those before it | place | rests on | street: NO 12 |
        | :-- | :-- | :-- | --: |
        | letter | HG 4 | the text | 50.0 |
        | walls | HG 4 | no text | 75.0 |
        | *kd-tree* | *HG 4* |  | *–* |
        ");
    }
}
