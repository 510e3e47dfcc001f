//! Why detectors are wrong, and what repairing each reason alone would gain.

use crate::files::fixed_decimals::{fixed_decimals, percent_or_dash};
use crate::rows::error_row::ErrorRow;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::vocabulary::reason::{FalseReason, MissReason, MistakeKind};
use crate::vocabulary::slice::Slice;

/// The errors of all detectors in one task, on all data sets of one origin together.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorTable<'a> {
    /// The detectors, in the order of the columns.
    pub detectors: Vec<&'a str>,
    /// Their errors.
    pub rows: Vec<&'a ErrorRow>,
}

impl ErrorTable<'_> {
    /// The repair that would gain a detector most, in a sentence for each; none for detectors without an F-rate.
    pub(crate) fn largest_gains(&self) -> Vec<String> {
        let sentence = |detector: &&str| {
            let of_all = self.rows.iter().filter(|it| it.detector == **detector && it.slice == Slice::All);
            let gains = of_all.filter_map(|it| Some((*it, it.f_rate_gain?.0)));
            let (row, gain) = gains.max_by(|a, b| a.1.total_cmp(&b.1))?;
            let repair = match row.mistake {
                MistakeKind::Missed => "finding the objects that are missed",
                MistakeKind::False => "leaving out the detections that are false",
            };
            Some(format!(
                "{detector} would gain most by {repair} as “{}”: {} points of F-rate ({} of them).",
                row.reason,
                fixed_decimals(100.0 * gain, 1),
                row.n
            ))
        };
        self.detectors.iter().filter_map(sentence).collect()
    }

    /// Every kind of mistake with a reason, in the order in which the rows have them.
    pub(crate) fn reasons(&self, is_asked: impl Fn(&ErrorRow) -> bool) -> Vec<(MistakeKind, &str)> {
        let mut reasons: Vec<(MistakeKind, &str)> =
            self.rows.iter().filter(|it| is_asked(it)).map(|it| (it.mistake, it.reason.as_str())).collect();
        reasons.sort_by_key(|it| (it.0, index(*it)));
        reasons.dedup();
        reasons
    }

    /// A line for each reason: its number and its gain for every detector.
    fn gains(&self) -> Grid {
        let is_all = |it: &ErrorRow| it.slice == Slice::All;
        let mut columns = ["mistake", "reason"].map(Column::left).to_vec();
        for detector in &self.detectors {
            columns.extend(["n", "gain"].map(|it| Column::number(it).within(*detector)));
        }
        let mut before = None;
        let lines = self.reasons(is_all).into_iter().map(|(mistake, reason)| {
            let is_first = before.replace(mistake) != Some(mistake);
            let kind = if is_first { LineKind::Dataset } else { LineKind::Detail };
            let label = if is_first { Cell::new(mistake.name()) } else { Cell::default() };
            let mut cells = vec![label, Cell::new(reason)];
            for detector in &self.detectors {
                let is_it = |it: &&&ErrorRow| {
                    is_all(it)
                        && it.detector == *detector
                        && (it.mistake, it.reason.as_str()) == (mistake, reason)
                };
                let row = self.rows.iter().find(is_it);
                cells.push(Cell::new(row.map_or(0, |it| it.n).to_string()));
                let gain = match row {
                    None => Some(0.0),
                    Some(row) => row.f_rate_gain.map(|it| it.0),
                };
                cells.push(Cell::new(percent_or_dash(gain)));
            }
            Line { kind, cells }
        });
        let lines = lines.collect();
        Grid { columns, lines }
    }

    /// A line for each detector, class and range: the number of mistakes for each reason.
    fn slices(&self, mistake: MistakeKind, total: &'static str) -> Grid {
        let is_asked = |it: &ErrorRow| it.mistake == mistake && it.slice != Slice::All;
        let reasons = self.reasons(is_asked);
        let mut columns = vec![Column::left("detector"), Column::left("slice"), Column::number(total)];
        columns.extend(reasons.iter().map(|(_, reason)| Column::number((*reason).to_owned())));
        let mut lines = Vec::new();
        for detector in &self.detectors {
            let of_detector: Vec<&ErrorRow> =
                self.rows.iter().copied().filter(|it| is_asked(it) && it.detector == *detector).collect();
            for (idx, of_slice) in of_detector.chunk_by(|a, b| a.slice == b.slice).enumerate() {
                let first = idx == 0;
                let head = if first { Cell::new(*detector) } else { Cell::default() };
                let mut cells =
                    vec![head, Cell::new(of_slice[0].slice.name()), Cell::new(of_slice[0].of.to_string())];
                cells.extend(reasons.iter().map(|(_, reason)| {
                    let n = of_slice.iter().find(|it| it.reason == *reason).map_or(0, |it| it.n);
                    Cell::new(n.to_string())
                }));
                lines.push(Line { kind: if first { LineKind::Dataset } else { LineKind::Detail }, cells });
            }
        }
        Grid { columns, lines }
    }
}

/// The index of a reason in the vocabulary.
fn index((mistake, reason): (MistakeKind, &str)) -> Option<usize> {
    match mistake {
        MistakeKind::Missed => MissReason::ALL.iter().position(|it| it.name() == reason),
        MistakeKind::False => FalseReason::ALL.iter().position(|it| it.name() == reason),
    }
}

impl Tabular for ErrorTable<'_> {
    /// All reasons, then missed objects and false detections by class and range.
    fn sheet(&self) -> Sheet {
        let sentences = [
            "n: missed objects, or false detections.",
            "gain: points that the F-rate would gain if this reason alone were repaired: if these objects were found, or these \
             detections were not there. Gains of several reasons do not add up.",
            "A false detection has no class of its own, so it is counted by range only. NO: annotations that count. ND: detections \
             that count.",
        ];
        let part = |title: &str, grid| Part { title: Some(title.to_owned()), grid };
        let parts = vec![
            part("Errors by reason", self.gains()),
            part("Missed, by class and range", self.slices(MistakeKind::Missed, "NO")),
            part("False, by range", self.slices(MistakeKind::False, "ND")),
        ];
        Sheet::of_parts(parts, sentences.map(str::to_owned).to_vec()).labelled("errors")
    }
}
