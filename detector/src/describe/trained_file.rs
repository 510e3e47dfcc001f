//! What all files that training writes have in common.

use serde::{Deserialize, Serialize};
use toml::de::{DeTable, DeValue};

/// What a file was made of: enough to make it again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The command that makes it.
    pub command: String,
    /// Data sets it was trained on.
    pub data: Vec<String>,
    /// The seed of everything random.
    pub seed: u64,
    /// What was held out.
    pub split: String,
}

/// What is wrong with a file, and where in it.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct AtLine<P: std::error::Error> {
    /// Counted from 1.
    pub line: usize,
    /// What is wrong there.
    pub problem: P,
}

/// Why a file is not what it should be.
#[derive(Debug, thiserror::Error)]
pub enum TrainedFileError {
    /// Not TOML, or something missing, unknown or of the wrong kind in it.
    #[error("{0}")]
    Syntax(String),
    /// Another kind of file.
    #[error("the format is {found:?}, not {expected:?}")]
    Format {
        /// What it says.
        found: String,
        /// What was looked for.
        expected: &'static str,
    },
    /// A file of another time.
    #[error("the format has version {found}, but this program reads version {expected}")]
    Version {
        /// What it says.
        found: i64,
        /// What was looked for.
        expected: i64,
    },
}

#[derive(Deserialize)]
struct Head {
    format: String,
    version: i64,
}

/// The file that `text` is, if it calls itself one of this format and version.
///
/// # Errors
///
/// [`TrainedFileError`] if it does not, before anything else in it is looked at, or if it is damaged.
pub fn read_file<File: serde::de::DeserializeOwned>(
    text: &str,
    format: &'static str,
    version: i64,
) -> Result<File, AtLine<TrainedFileError>> {
    let head: Head = parse(text)?;
    if head.format != format {
        let problem = TrainedFileError::Format { found: head.format, expected: format };
        return Err(AtLine { line: line_of(text, &["format"], None), problem });
    }
    if head.version != version {
        let problem = TrainedFileError::Version { found: head.version, expected: version };
        return Err(AtLine { line: line_of(text, &["version"], None), problem });
    }
    parse(text)
}

fn parse<Value: serde::de::DeserializeOwned>(text: &str) -> Result<Value, AtLine<TrainedFileError>> {
    toml::from_str(text).map_err(|error: toml::de::Error| AtLine {
        line: line_at(text, error.span().map_or(0, |span| span.start)),
        problem: TrainedFileError::Syntax(error.message().to_owned()),
    })
}

/// The line, from 1, of what `keys` lead to, and of an element of it if it is a list; of as much of this as is there.
pub fn line_of(text: &str, keys: &[&str], element_idx: Option<usize>) -> usize {
    let Ok(document) = DeTable::parse(text) else { return 1 };
    let mut offset = 0;
    let mut table = document.get_ref();
    for key in keys {
        let Some((key, value)) = table.get_key_value(*key) else { break };
        offset = key.span().start;
        match value.get_ref() {
            DeValue::Table(inner) => table = inner,
            DeValue::Array(elements) => {
                let element = element_idx.and_then(|element_idx| elements.get(element_idx));
                offset = element.map_or(offset, |it| it.span().start);
                break;
            }
            _ => break,
        }
    }
    line_at(text, offset)
}

fn line_at(text: &str, byte_offset: usize) -> usize {
    1 + text.bytes().take(byte_offset).filter(|&byte| byte == b'\n').count()
}

/// The beginning of a file: its format and version, `values` as they are in TOML, and the table `made`.
pub fn head_and_provenance(
    (format, version): (&str, i64),
    values: &[(&str, String)],
    made: &Provenance,
) -> String {
    let quoted = |text: &str| toml::Value::from(text).to_string();
    let data: Vec<String> = made.data.iter().map(|it| quoted(it)).collect();
    let values: String = values.iter().flat_map(|(name, value)| [name, " = ", value, "\n"]).collect();
    format!(
        "format = {}\nversion = {version}\n{values}\n[made]\ncommand = {}\ndata = [{}]\nseed = {}\nsplit = {}\n",
        quoted(format),
        quoted(&made.command),
        data.join(", "),
        made.seed,
        quoted(&made.split),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_those_of_keys_and_of_elements() {
        let text = "a = 1\n\n[t]\nb = 2\nc = [\n  1,\n  2,\n]\n";
        let line = |keys: &[&str], element_idx| line_of(text, keys, element_idx);
        assert_eq!([line(&["a"], None), line(&["t", "b"], None), line(&["t", "c"], None)], [1, 4, 5]);
        assert_eq!(
            [line(&["t", "c"], Some(1)), line(&["t", "c"], Some(9)), line(&["t", "d"], None)],
            [7, 5, 3]
        );
    }
}
