//! Two runs over the same scans side by side, or two detectors of one run, without a verdict.

use crate::estimates::Question;
use crate::gate::comparability::{NotComparable, check_comparable};
use crate::gate::drift::drift;
use crate::gate::paired_difference::{PairedDifference, paired_difference};
use crate::gate::wording::{
    about_differences, difference_text, interval_cell, least_effect_text, metric_text, value_text,
};
use crate::run_archive::RunArchive;
use crate::run_report::OVERALL;
use crate::slice::Slice;
use crate::sums::RATIOS;
use crate::table::grid::{Alignment, Cell, Column, Grid, Line, LineKind};
use crate::table::notes::Notes;
use crate::table::{markdown, terminal};

/// What was compared with what, and what came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// In words.
    pub title: String,
    /// Task by task, detector by detector, slice by slice.
    pub differences: Vec<NamedDifference>,
    /// Number of scans that a detector is judged otherwise on; `None` where two detectors are compared, of which that is
    /// expected.
    pub n_changed_scans: Option<usize>,
}

/// A difference with what it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedDifference {
    /// Name of the task.
    pub task: String,
    /// Name of the detector, or of both.
    pub detector: String,
    /// Name of the slice.
    pub slice: String,
    /// The numbers.
    pub difference: PairedDifference,
}

/// Which slices are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparedSlices {
    /// Everything as one.
    All,
    /// Every slice as well.
    Each,
}

/// Compares two runs over the same scans, over all data sets together.
///
/// # Errors
///
/// [`NotComparable`] if the scans or the rules of judging are not the same.
pub fn compare_runs(
    before: &RunArchive,
    after: &RunArchive,
    slices: ComparedSlices,
) -> Result<Comparison, NotComparable> {
    check_comparable(before, after)?;
    let tallies = [before.tally(), after.tally()];
    let draws = tallies[0].draw();
    let mut differences = Vec::new();
    for task in tallies[0].tasks() {
        for detector in tallies[0].detectors() {
            for slice in tallies[0].slices(task, detector).iter().filter(|it| is_compared(it, slices)) {
                let question = Question { dataset: OVERALL, task, detector, slice };
                let [Some(before), Some(after)] = [0, 1].map(|side| tallies[side].sample(&question, &draws))
                else {
                    continue;
                };
                let of_metrics = RATIOS.iter().filter_map(|it| paired_difference(&before, &after, it));
                differences.extend(of_metrics.map(|it| named(task, detector, slice, it)));
            }
        }
    }
    let title = "Two runs over the same scans, all data sets together".to_owned();
    Ok(Comparison { title, differences, n_changed_scans: Some(drift(before, after).len()) })
}

/// Compares detector `second` of `run` with detector `first`, over all data sets together.
pub fn compare_detectors(run: &RunArchive, first: &str, second: &str, slices: ComparedSlices) -> Comparison {
    let tally = run.tally();
    let draws = tally.draw();
    let mut differences = Vec::new();
    for task in tally.tasks() {
        for slice in tally.slices(task, first).iter().filter(|it| is_compared(it, slices)) {
            let sample =
                |detector| tally.sample(&Question { dataset: OVERALL, task, detector, slice }, &draws);
            let [Some(before), Some(after)] = [first, second].map(sample) else { continue };
            let of_metrics = RATIOS.iter().filter_map(|it| paired_difference(&before, &after, it));
            let name = format!("{second} − {first}");
            differences.extend(of_metrics.map(|it| named(task, &name, slice, it)));
        }
    }
    let title =
        format!("{first} (before) and {second} (after) on the same scans of one run, all data sets together");
    Comparison { title, differences, n_changed_scans: None }
}

fn is_compared(slice: &Slice, slices: ComparedSlices) -> bool {
    slices == ComparedSlices::Each || *slice == Slice::All
}

fn named(task: &str, detector: &str, slice: &Slice, difference: PairedDifference) -> NamedDifference {
    let [task, detector] = [task, detector].map(str::to_owned);
    NamedDifference { task, detector, slice: slice.name(), difference }
}

impl Comparison {
    /// The comparison for a terminal.
    pub fn to_terminal(&self) -> String {
        let mut text = format!("{}.\n\n", self.title);
        let (grid, notes) = self.grid_and_notes();
        terminal::write_grid(&mut text, &grid, &notes);
        text.push('\n');
        for sentence in &notes.sentences {
            text.push_str(&terminal::wrapped(sentence));
        }
        text
    }

    /// The comparison as Markdown.
    pub fn to_markdown(&self) -> String {
        let mut text = format!("**{}.**\n\n", markdown::escaped(&self.title));
        let (grid, notes) = self.grid_and_notes();
        markdown::write_grid(&mut text, &grid, &notes);
        text.push('\n');
        for sentence in &notes.sentences {
            markdown::push_line(&mut text, &format!("- {}", markdown::escaped(sentence)));
        }
        text
    }

    fn grid_and_notes(&self) -> (Grid, Notes) {
        let grid = self.grid();
        let notes = Notes::beneath(std::slice::from_ref(&grid), self.sentences());
        (grid, notes)
    }

    fn sentences(&self) -> Vec<String> {
        let about_scans = self.n_changed_scans.map(|n| match n {
            0 => "No result of a scan changed.".to_owned(),
            n => format!("Results changed {n} times (counted per scan, detector and task)."),
        });
        let kind = self.differences.iter().find_map(|it| it.difference.interval).map(|it| it.blocks.kind);
        let about_numbers = match kind {
            Some(kind) => about_differences(kind),
            None => "There is only one block of scans, so there is no interval.".to_owned(),
        };
        [about_numbers].into_iter().chain(about_scans).collect()
    }

    fn grid(&self) -> Grid {
        let column = |title, alignment| Column { group: None, title, alignment };
        let left = ["task", "detector", "slice", "metric"].map(|title| column(title, Alignment::Left));
        let numbers =
            ["before", "after", "difference", "95 %", "least"].map(|title| column(title, Alignment::Decimal));
        let lines = self.differences.iter().map(|named| {
            let it = &named.difference;
            let metric = &it.metric;
            let cells = vec![
                Cell::new(named.task.clone()),
                Cell::new(named.detector.clone()),
                Cell::new(named.slice.clone()),
                Cell::new(metric_text(metric)),
                Cell::new(value_text(metric, it.before)),
                Cell::new(value_text(metric, it.after)),
                Cell::new(difference_text(metric, it.difference())),
                interval_cell(it),
                Cell::new(least_effect_text(it)),
            ];
            Line { kind: LineKind::Dataset, cells }
        });
        Grid { columns: left.into_iter().chain(numbers).collect(), lines: lines.collect() }
    }
}
