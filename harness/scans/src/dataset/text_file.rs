//! Text files of white-space separated fields, with errors that name the line.

use std::path::Path;
use std::str::{FromStr, SplitWhitespace};

use super::DatasetError;
use super::on_disk::bytes_of;

/// Larger numbers are mistakes, whatever the unit; below it, no product of a few of them overflows.
const MAX_MAGNITUDE: f64 = 1e9;

/// A field is quoted in messages up to this many characters.
const MAX_QUOTED_CHARS: usize = 40;

/// Reads the text file at `path`.
pub fn read_text_file(path: &Path) -> Result<String, DatasetError> {
    String::from_utf8(bytes_of(path)?).map_err(|error| {
        let byte_offset = error.utf8_error().valid_up_to();
        DatasetError::damaged(path, format!("is not text: invalid UTF-8 at byte {byte_offset}"))
    })
}

/// The lines of `text` that are not blank; `path` is named in errors.
pub fn text_lines<'a>(path: &'a Path, text: &'a str) -> impl Iterator<Item = TextLine<'a>> {
    let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
    lines.map(move |(line, content)| TextLine { path, line, fields: content.split_whitespace() })
}

/// One line, whose fields are taken from left to right.
#[derive(Debug, Clone)]
pub struct TextLine<'a> {
    path: &'a Path,
    line: usize,
    fields: SplitWhitespace<'a>,
}

impl<'a> TextLine<'a> {
    /// The next field as it is; `name` is its name in the format.
    pub fn word(&mut self, name: &str) -> Result<&'a str, DatasetError> {
        self.fields.next().ok_or_else(|| self.error(format!("ends before its {name}")))
    }

    /// The next field as a whole number.
    pub fn integer<Integer: FromStr>(&mut self, name: &str) -> Result<Integer, DatasetError> {
        let word = self.word(name)?;
        word.parse().map_err(|_| self.error(format!("{name} {} is not a valid whole number", quoted(word))))
    }

    /// The next field as a number.
    pub fn number(&mut self, name: &str) -> Result<f64, DatasetError> {
        let word = self.word(name)?;
        match word.parse::<f64>() {
            Ok(number) if number.abs() <= MAX_MAGNITUDE => Ok(number),
            Ok(_) => Err(self.error(format!("{name} {} is not a number up to 1e9", quoted(word)))),
            Err(_) => Err(self.error(format!("{name} {} is not a number", quoted(word)))),
        }
    }

    /// The next `N` fields as numbers.
    pub fn numbers<const N: usize>(&mut self, name: &str) -> Result<[f64; N], DatasetError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number(name)?;
        }
        Ok(numbers)
    }

    /// Whether fields are left.
    pub fn has_more(&self) -> bool {
        self.fields.clone().next().is_some()
    }

    /// Makes sure that no field is left.
    pub fn end(mut self) -> Result<(), DatasetError> {
        match self.fields.next() {
            None => Ok(()),
            Some(word) => Err(self.error(format!("has more than expected: {}", quoted(word)))),
        }
    }

    /// The place of this line, for messages.
    pub fn position(&self) -> String {
        format!("{:?}, line {}", self.path, self.line)
    }

    /// An error about this line.
    pub fn error(&self, problem: String) -> DatasetError {
        DatasetError::Line { path: self.path.to_path_buf(), line: self.line, problem }
    }
}

/// `word` in quotation marks, cut to a length that a terminal can show.
pub fn quoted(word: &str) -> String {
    match word.char_indices().nth(MAX_QUOTED_CHARS) {
        None => format!("{word:?}"),
        Some((end, _)) => format!("{:?}…", &word[..end]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_number(text: &str, expected: Result<f64, &str>) {
        let mut line = text_lines(Path::new("a.txt"), text).next().expect("a line");
        let number = line.number("width").map_err(|error| error.to_string());
        assert_eq!(number, expected.map_err(str::to_owned));
    }

    #[test]
    fn numbers_may_have_an_exponent() {
        check_number("7.5e-1", Ok(0.75));
    }

    #[test]
    fn what_is_no_finite_number_is_named_with_its_line() {
        check_number("\n \nx1", Err(r#""a.txt", line 3: width "x1" is not a number"#));
        check_number("NaN", Err(r#""a.txt", line 1: width "NaN" is not a number up to 1e9"#));
        check_number("-inf", Err(r#""a.txt", line 1: width "-inf" is not a number up to 1e9"#));
    }

    #[test]
    fn long_fields_are_cut_in_messages() {
        assert_eq!(quoted(&"ä".repeat(1000)), format!("\"{}\"…", "ä".repeat(40)));
    }

    #[test]
    fn what_is_too_many_is_named() {
        let line = text_lines(Path::new("a.txt"), "5 6").next().expect("a line");
        assert_eq!(
            line.end().expect_err("two fields").to_string(),
            r#""a.txt", line 1: has more than expected: "5""#
        );
    }

    #[test]
    fn bytes_that_are_no_text_are_refused_with_their_position() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        std::fs::write(&path, b"P2: \xff").unwrap();
        let error = read_text_file(&path).expect_err("not UTF-8");
        assert!(error.to_string().ends_with("is not text: invalid UTF-8 at byte 4"), "{error}");
    }
}
