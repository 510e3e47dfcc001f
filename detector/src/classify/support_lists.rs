//! The long lists of a model file: coefficients on one line, then each support vector on one of its own.

use std::fmt::Write as _;

use super::svm_model_error::SvmModelError;
use crate::describe::trained_file::AtLine;

/// The coefficients of both classes cancel; this share of their sum is left over by rounding.
const MAX_IMBALANCE: f64 = 1e-4;
/// How a value outside of them is refused.
pub(super) const FINITE_NUMBERS: &str = "the finite numbers";

const COEFFICIENTS: &str = "coefficients";
const SUPPORT_VECTORS: &str = "support_vectors";
const BEGIN_COEFFICIENTS: &str = "coefficients = [";
const BEGIN_SUPPORT_VECTORS: &str = "support_vectors = [";
const ROW: &str = "[a support vector], or ]";
const END: &str = "]";

/// What stands in the lists.
pub(super) struct SupportLists<const D: usize> {
    pub(super) coefficients: Vec<f32>,
    pub(super) support_vectors: Vec<[f32; D]>,
    /// The line of the coefficients; the list of support vectors begins on the next one.
    line: usize,
}

/// Appends the lists to the text of a model.
pub(super) fn write_lists<const D: usize>(
    text: &mut String,
    coefficients: &[f32],
    support_vectors: &[[f32; D]],
) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{COEFFICIENTS} = {coefficients:?}");
    let _ = writeln!(text, "{BEGIN_SUPPORT_VECTORS}");
    for row in support_vectors {
        let _ = writeln!(text, "    {row:?},");
    }
    let _ = writeln!(text, "{END}");
}

/// The text of a model parted before its lists; what has none is head altogether.
pub(super) fn split_lists(text: &str) -> (&str, &str) {
    let begin = text.find(&format!("\n{BEGIN_COEFFICIENTS}"));
    text.split_at(begin.map_or(text.len(), |it| it + 1))
}

impl<const D: usize> SupportLists<D> {
    /// The lists of `text`, which stands below `n_lines_before` other lines; `features` are the names of the values.
    pub(super) fn read(
        text: &str,
        n_lines_before: usize,
        features: &[&'static str; D],
    ) -> Result<Self, AtLine<SvmModelError>> {
        let mut lines = NumberedLines { lines: text.lines(), n_read: n_lines_before };
        let coefficients = lines.next(BEGIN_COEFFICIENTS)?;
        let line = lines.n_read;
        let coefficients = entries(coefficients).and_then(|entries| {
            let entries = entries.enumerate();
            entries
                .map(|(idx, it)| number(it, || COEFFICIENTS.into(), || format!("coefficient {idx}")))
                .collect()
        });
        let coefficients = coefficients.map_err(|problem| AtLine { line, problem })?;
        if lines.next(BEGIN_SUPPORT_VECTORS)? != BEGIN_SUPPORT_VECTORS {
            return Err(lines.problem(BEGIN_SUPPORT_VECTORS, "more on the same line"));
        }
        let mut support_vectors = Vec::new();
        loop {
            let row = lines.next(ROW)?;
            if row == END {
                break;
            }
            let row = self::row(row.trim_end_matches(','), support_vectors.len(), features);
            support_vectors.push(row.map_err(|problem| AtLine { line: lines.n_read, problem })?);
        }
        match lines.lines.find(|it| !it.trim().is_empty()) {
            None => Ok(Self { coefficients, support_vectors, line }),
            Some(more) => Err(lines.problem("the end", more)),
        }
    }

    /// Whether there are as many of both as the head says, and the coefficients of both classes cancel.
    pub(super) fn check(&self, n_support_vectors: usize) -> Result<(), AtLine<SvmModelError>> {
        let counted = [
            (COEFFICIENTS, self.coefficients.len(), self.line),
            (SUPPORT_VECTORS, self.support_vectors.len(), self.line + 1),
        ];
        for (list, found, line) in counted {
            if found != n_support_vectors {
                let problem =
                    SvmModelError::Length { list: list.to_owned(), found, expected: n_support_vectors };
                return Err(AtLine { line, problem });
            }
        }
        let sum: f64 = self.coefficients.iter().map(|&it| f64::from(it)).sum();
        let size: f64 = self.coefficients.iter().map(|&it| f64::from(it).abs()).sum();
        let value = sum / size;
        if (-MAX_IMBALANCE..=MAX_IMBALANCE).contains(&value) {
            return Ok(());
        }
        let name = "sum of the coefficients over that of their sizes".to_owned();
        let problem = SvmModelError::OutOfRange { name, value, allowed: "0, but for rounding" };
        Err(AtLine { line: self.line, problem })
    }
}

/// Lines with the number of the latest, from 1.
struct NumberedLines<'a> {
    lines: std::str::Lines<'a>,
    n_read: usize,
}

impl<'a> NumberedLines<'a> {
    /// The next line without blanks around it, which has to begin as `expected` does if that ends in a bracket.
    fn next(&mut self, expected: &'static str) -> Result<&'a str, AtLine<SvmModelError>> {
        self.n_read += 1;
        let Some(line) = self.lines.next() else { return Err(self.problem(expected, "the end of the file")) };
        let line = line.trim();
        if expected.ends_with('[') && !line.starts_with(expected) {
            return Err(self.problem(expected, line));
        }
        Ok(line)
    }

    fn problem(&self, expected: &'static str, found: &str) -> AtLine<SvmModelError> {
        AtLine { line: self.n_read, problem: SvmModelError::Layout { expected, found: beginning(found) } }
    }
}

/// The entries of a list on one line, which may have a name before it.
fn entries(line: &str) -> Result<std::str::Split<'_, char>, SvmModelError> {
    let inner = line.split_once('[').and_then(|(_, it)| it.strip_suffix(']'));
    let not_closed = || SvmModelError::Layout { expected: "a list that ends in ]", found: beginning(line) };
    Ok(inner.ok_or_else(not_closed)?.split(','))
}

fn row<const D: usize>(
    line: &str,
    row_idx: usize,
    features: &[&'static str; D],
) -> Result<[f32; D], SvmModelError> {
    let list = || format!("{SUPPORT_VECTORS}[{row_idx}]");
    if !line.starts_with('[') {
        return Err(SvmModelError::Layout { expected: ROW, found: beginning(line) });
    }
    let (mut row, mut found) = ([0.0; D], 0);
    for entry in entries(line)? {
        if let Some(value) = row.get_mut(found) {
            *value = number(entry, list, || format!("{} of support vector {row_idx}", features[found]))?;
        }
        found += 1;
    }
    if found == D { Ok(row) } else { Err(SvmModelError::Length { list: list(), found, expected: D }) }
}

/// A finite number; texts for errors are made if there is one.
fn number(text: &str, list: impl Fn() -> String, name: impl Fn() -> String) -> Result<f32, SvmModelError> {
    let text = text.trim();
    let Ok(value) = text.parse::<f32>() else {
        return Err(SvmModelError::NoNumber { list: list(), text: beginning(text) });
    };
    if value.is_finite() {
        return Ok(value);
    }
    Err(SvmModelError::OutOfRange { name: name(), value: value.into(), allowed: FINITE_NUMBERS })
}

/// As much of a text as it takes to find it again.
fn beginning(text: &str) -> String {
    text.chars().take(40).collect()
}
