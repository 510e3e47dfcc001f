//! A selection of scans of a data set: `0..500:5`, `3..10`, `7` or `1,4,20..30`.

use std::collections::BTreeSet;
use std::str::FromStr;

use super::DatasetError;

/// Positions in the list of scans, counted from 0.
///
/// Several parts are joined by commas. A part is a position `A`, a range `A..B` that ends before B, or every STEP-th
/// position of a range, `A..B:STEP`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScanSelection {
    // Invariant: in every part the start is below the end and the step is above 0.
    written: String,
    parts: Vec<Part>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Position(usize),
    Range { start: usize, end: usize, step: usize },
}

impl ScanSelection {
    /// The selected positions among `n_scans`, ascending, each once.
    ///
    /// A range may end beyond the last scan, so that `0..500` also works for shorter data sets.
    pub fn positions(&self, n_scans: usize) -> Result<Vec<usize>, DatasetError> {
        let mut positions = BTreeSet::new();
        for part in &self.parts {
            let (start, end, step) = match *part {
                Part::Position(position) => (position, position.saturating_add(1), 1),
                Part::Range { start, end, step } => (start, end, step),
            };
            if start >= n_scans {
                let problem = format!("there is no scan {start}: the data set has {n_scans}, counted from 0");
                return Err(refused(&self.written, &problem));
            }
            positions.extend((start..end.min(n_scans)).step_by(step));
        }
        Ok(positions.into_iter().collect())
    }
}

impl FromStr for ScanSelection {
    type Err = DatasetError;

    fn from_str(text: &str) -> Result<Self, DatasetError> {
        let parts = text.split(',').map(|part| parse_part(part.trim()));
        let parts = parts.collect::<Result<_, String>>().map_err(|problem| refused(text, &problem))?;
        Ok(Self { written: text.to_owned(), parts })
    }
}

fn refused(selection: &str, problem: &str) -> DatasetError {
    DatasetError::Usage(format!("scan selection {selection:?}: {problem}"))
}

fn parse_part(part: &str) -> Result<Part, String> {
    let Some((start, rest)) = part.split_once("..") else { return Ok(Part::Position(parse_number(part)?)) };
    let (end, step) = rest.split_once(':').unwrap_or((rest, "1"));
    let (start, end, step) = (parse_number(start)?, parse_number(end)?, parse_number(step)?);
    if start >= end {
        return Err(format!("the range {start}..{end} is empty: its start is not below its end"));
    }
    if step == 0 {
        return Err("the step must not be 0".to_owned());
    }
    Ok(Part::Range { start, end, step })
}

fn parse_number(text: &str) -> Result<usize, String> {
    text.parse()
        .map_err(|_| format!("{text:?} is not the number of a scan; write A, A..B, A..B:STEP or A,B,C"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Selects from 40 scans; `Err` is a part of the message.
    #[track_caller]
    fn check(selection: &str, expected: Result<&[usize], &str>) {
        let found = selection.parse::<ScanSelection>().and_then(|selection| selection.positions(40));
        match (found, expected) {
            (Ok(found), Ok(expected)) => assert_eq!(found, expected),
            (Err(error), Err(part)) => {
                assert!(error.to_string().contains(part), "{error}");
                assert!(error.is_usage_error());
            }
            (found, expected) => panic!("{found:?}, expected {expected:?}"),
        }
    }

    #[test]
    fn ranges_end_before_their_end() {
        check("3..6", Ok(&[3, 4, 5]));
        check("0..20:5", Ok(&[0, 5, 10, 15]));
    }

    #[test]
    fn ranges_may_end_beyond_the_last_scan() {
        check("38..500", Ok(&[38, 39]));
        check("0..18446744073709551615:30", Ok(&[0, 30]));
    }

    #[test]
    fn positions_ascend_and_come_once() {
        check("7", Ok(&[7]));
        check("9, 2,9,8..10", Ok(&[2, 8, 9]));
    }

    #[test]
    fn what_does_not_exist_cannot_be_selected() {
        check("40", Err("there is no scan 40: the data set has 40, counted from 0"));
        check("0,41..50", Err("there is no scan 41"));
    }

    #[test]
    fn what_is_not_understood_is_named() {
        check("", Err(r#""" is not the number of a scan"#));
        check("1,", Err(r#""" is not the number of a scan"#));
        check("5..", Err(r#""" is not the number of a scan"#));
        check("-1", Err(r#""-1" is not the number of a scan"#));
        check("1..2..3", Err(r#""2..3" is not the number of a scan"#));
        check("1:2", Err(r#""1:2" is not the number of a scan"#));
        check("5..5", Err("the range 5..5 is empty"));
        check("9..5", Err("the range 9..5 is empty"));
        check("1..5:0", Err("the step must not be 0"));
    }

    proptest! {
        #[test]
        fn any_text_gives_a_selection_or_an_error(text in "[0-9.,: -]{0,20}", n_scans in 0_usize..50) {
            if let Ok(positions) = text.parse::<ScanSelection>().and_then(|it| it.positions(n_scans)) {
                prop_assert!(positions.iter().all(|position| *position < n_scans));
                prop_assert!(positions.is_sorted_by(|a, b| a < b));
            }
        }
    }
}
