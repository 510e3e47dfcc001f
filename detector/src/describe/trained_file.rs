//! What all files that training writes have in common.

use serde::Deserialize;

/// What a file was made of: enough to make it again.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
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

/// Why a file is not what it should be.
#[derive(Debug, thiserror::Error)]
pub enum TrainedFileError {
    /// Not TOML, or something missing, unknown or of the wrong kind in it.
    #[error("{0}")]
    Syntax(#[from] toml::de::Error),
    /// Another kind of file.
    #[error("format is {found:?}, not {expected:?}")]
    Format {
        /// What it says.
        found: String,
        /// What was looked for.
        expected: &'static str,
    },
    /// A file of another time.
    #[error("version {found} of the format, this program reads {expected}")]
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

/// Whether `text` calls itself a file of this format and version.
///
/// # Errors
///
/// [`TrainedFileError`] if it does not, before anything else in it is looked at.
pub fn check_head(text: &str, format: &'static str, version: i64) -> Result<(), TrainedFileError> {
    let head: Head = toml::from_str(text)?;
    if head.format != format {
        return Err(TrainedFileError::Format { found: head.format, expected: format });
    }
    if head.version != version {
        return Err(TrainedFileError::Version { found: head.version, expected: version });
    }
    Ok(())
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
