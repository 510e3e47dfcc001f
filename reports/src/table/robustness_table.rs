//! The table of what detectors find under one condition after another.

use std::fmt::Write as _;

use crate::condition_scores::{ConditionScores, DetectorCounts};
use crate::counts::Counts;
use crate::fixed_decimals::fixed_decimals;
use crate::table::grid::{Alignment, Cell, Column, Grid, Line, LineKind};
use crate::table::markdown::write_grid as write_markdown_grid;
use crate::table::notes::Notes;
use crate::table::terminal::{wrapped, write_grid};

const TITLE: &str = "F-rate in % under each condition (all simulated).";

/// The table for a terminal: one row a condition, the F-rates of both tasks for each detector.
pub fn robustness_to_terminal(conditions: &[ConditionScores], notes: &[String]) -> String {
    let mut text = format!("{TITLE}\n\n");
    write_grid(&mut text, &grid(conditions), &Notes::none());
    text.push('\n');
    for note in notes {
        text.push_str(&wrapped(note));
    }
    text
}

/// The same for pull requests and pages.
pub fn robustness_to_markdown(conditions: &[ConditionScores], notes: &[String]) -> String {
    let mut text = format!("**{TITLE}**\n\n");
    write_markdown_grid(&mut text, &grid(conditions), &Notes::none());
    text.push('\n');
    for note in notes {
        writeln!(text, "- {note}").expect("a string takes all that is written");
    }
    text
}

fn grid(conditions: &[ConditionScores]) -> Grid {
    let column =
        |group: Option<&str>, title, alignment| Column { group: group.map(str::to_owned), title, alignment };
    let mut columns = vec![
        column(None, "kind", Alignment::Left),
        column(None, "condition", Alignment::Left),
        column(Some("NO"), "obj", Alignment::Decimal),
        column(Some("NO"), "veh", Alignment::Decimal),
    ];
    for it in conditions.first().map_or(&[][..], |it| &it.detectors) {
        columns.extend(["obj", "veh"].map(|title| column(Some(&it.detector), title, Alignment::Decimal)));
    }
    let mut group_before = "";
    let lines = conditions.iter().map(|it| {
        let group = if it.group == group_before { "" } else { &it.group };
        group_before = &it.group;
        line(group, it)
    });
    Grid { columns, lines: lines.collect() }
}

fn line(group: &str, scores: &ConditionScores) -> Line {
    // Which annotations count does not depend on the detector.
    let no = |task: fn(&DetectorCounts) -> Counts| {
        scores.detectors.first().map_or_else(|| "–".to_owned(), |it| task(it).no().to_string())
    };
    let texts = [group.to_owned(), scores.condition.clone(), no(|it| it.objects), no(|it| it.vehicles)];
    let percent = |rate: Option<f64>| rate.map_or_else(|| "–".to_owned(), |it| fixed_decimals(100.0 * it, 1));
    let rates = scores.detectors.iter().flat_map(|it| it.tasks().map(|(_, counts)| percent(counts.f_rate())));
    Line { kind: LineKind::Dataset, cells: texts.into_iter().chain(rates).map(Cell::new).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition_row::ConditionRow;
    use crate::csv_rows::{CsvRowWriter, read_rows};
    use crate::whole_file::WholeFile;

    fn scores(group: &str, condition: &str, tp: u64) -> ConditionScores {
        let counts = |no, tp, fo| Counts::new(no, tp, Some(fo)).unwrap();
        let detector = |name: &str, tp| DetectorCounts {
            detector: name.to_owned(),
            objects: counts(200, tp, 50),
            vehicles: counts(0, 0, 0),
        };
        ConditionScores {
            group: group.to_owned(),
            condition: condition.to_owned(),
            n_scans: 6,
            detectors: vec![detector("grid", tp), detector("tree", tp / 2)],
        }
    }

    fn conditions() -> [ConditionScores; 3] {
        [
            scores("standard", "as drawn", 100),
            scores("sensor", "vlp-16", 30),
            scores("sensor", "os1-128", 120),
        ]
    }

    #[test]
    fn conditions_of_a_kind_stand_together_and_rates_over_nothing_are_undefined() {
        insta::assert_snapshot!(robustness_to_terminal(&conditions(), &["A note.".to_owned()]), @r"
        F-rate in % under each condition (all simulated).

                                 NO        grid        tree
                              ────────   ─────────   ─────────
        kind      condition   obj  veh    obj  veh    obj  veh
        ──────────────────────────────────────────────────────
        standard  as drawn    200    0   57.1    –   33.3    –
        sensor    vlp-16      200    0   21.4    –   11.3    –
                  os1-128     200    0   64.9    –   38.7    –

        A note.
        ");
        insta::assert_snapshot!(robustness_to_markdown(&conditions(), &["A note.".to_owned()]), @r"
        **F-rate in % under each condition (all simulated).**

        | kind | condition | NO: obj | veh | grid: obj | veh | tree: obj | veh |
        | :-- | :-- | --: | --: | --: | --: | --: | --: |
        | standard | as drawn | 200 | 0 | 57.1 | – | 33.3 | – |
        | sensor | vlp-16 | 200 | 0 | 21.4 | – | 11.3 | – |
        |  | os1-128 | 200 | 0 | 64.9 | – | 38.7 | – |

        - A note.
        ");
    }

    #[test]
    fn rows_hold_what_the_rates_are_made_of() {
        let rows = ConditionRow::simulated(&conditions()[0]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robustness.csv");
        let mut writer = CsvRowWriter::new(WholeFile::create(&path).unwrap()).unwrap();
        for row in &rows {
            writer.write(row).unwrap();
        }
        writer.finish().unwrap();
        insta::assert_snapshot!(std::fs::read_to_string(&path).unwrap(), @r"
        data,group,condition,task,detector,n_scans,no,tp,mo,fo,precision,recall,f_rate
        simulated,standard,as drawn,objects,grid,6,200,100,100,50,0.6667,0.5000,0.5714
        simulated,standard,as drawn,vehicles,grid,6,0,0,0,0,,,
        simulated,standard,as drawn,objects,tree,6,200,50,150,50,0.5000,0.2500,0.3333
        simulated,standard,as drawn,vehicles,tree,6,0,0,0,0,,,
        ");
        assert_eq!(read_rows::<ConditionRow>(&path).unwrap().len(), rows.len());
    }
}
