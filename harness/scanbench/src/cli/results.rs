//! Results of other programs, and results for other programs.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};
use evaluation::run::config::check_name;
use scans::conversion::results::result_folder::ResultOutput;
use scans::foreign::foreign_results::MissingResults;

use super::help_text::{DETECTORS, OUTPUT};

/// What other programs found.
#[derive(Debug, Args)]
#[command(next_help_heading = DETECTORS)]
pub struct ForeignArgs {
    /// Judge what another program found; may be repeated
    ///
    /// PATH has a file for each scan or drive, or is a file: KITTI's .txt, nuScenes' .json, Argoverse 2's .feather,
    /// SemanticKITTI's .label, .mcap (also `a.mcap:/topic`), or what `detect` writes. docs/formats.md describes them.
    /// Without -d, the default detectors run as well.
    #[arg(long, value_name = "NAME=PATH")]
    pub detections: Vec<NamedResults>,
    /// Keep network, data sets and runs from programs of scanbench.toml
    ///
    /// For detectors that you do not trust with the labels. `sandbox = true` does so for one, in every command. It needs a
    /// Linux that lets its users make namespaces. Data sets, with what links in them lead to, are hidden, and around a single
    /// scan its folder. Runs are hidden in `runs/`, at --output and --add-to, and while they are made. Labels elsewhere are
    /// not.
    #[arg(long, hide_short_help = true)]
    pub sandbox: bool,
    /// What to do if --detections have no result for a scan
    #[arg(long, value_enum, value_name = "RULE", default_value = "error", hide_short_help = true)]
    pub missing_detections: MissingRule,
}

/// What is written for the evaluators of others.
#[derive(Debug, Args)]
#[command(next_help_heading = OUTPUT)]
pub struct ResultFilesArgs {
    /// Write all detections for the evaluators of others, too; needs --as
    ///
    /// The folder must not exist. It gets a folder for each detector, and in it one for each of several data sets.
    #[arg(
        long,
        value_name = "DIR",
        requires = "result_format",
        conflicts_with = "shard",
        hide_short_help = true
    )]
    pub detections_out: Option<PathBuf>,
    /// Format of --detections-out
    #[arg(
        long = "as",
        id = "result_format",
        value_enum,
        value_name = "FORMAT",
        requires = "detections_out",
        hide_short_help = true
    )]
    pub result_format: Option<ResultFormatName>,
}

/// Results, and the name that they have in tables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedResults {
    /// The name.
    pub name: String,
    /// Where they are.
    pub path: PathBuf,
}

impl FromStr for NamedResults {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((name, path)) if !path.is_empty() => {
                check_name(name).map_err(|problem| format!("{name:?} {problem}"))?;
                Ok(Self { name: name.to_owned(), path: PathBuf::from(path) })
            }
            _ => Err("write NAME=PATH, such as pointrcnn=results/pointrcnn".to_owned()),
        }
    }
}

/// What becomes of scans without results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MissingRule {
    /// Refuse the results
    Error,
    /// Count the scan as if nothing had been found
    Empty,
}

impl MissingRule {
    /// The rule.
    pub fn rule(self) -> MissingResults {
        match self {
            Self::Error => MissingResults::Refuse,
            Self::Empty => MissingResults::AreEmpty,
        }
    }
}

/// Formats of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ResultFormatName {
    /// KITTI's .txt, for scans in KITTI's layouts
    Kitti,
    /// A submission, for nuScenes
    Nuscenes,
    /// A .feather table, for Argoverse 2
    Argoverse2,
    /// What `detect` writes
    Csv,
}

impl ResultFormatName {
    /// The format.
    pub fn output(self) -> ResultOutput {
        match self {
            Self::Kitti => ResultOutput::Kitti,
            Self::Nuscenes => ResultOutput::NuScenes,
            Self::Argoverse2 => ResultOutput::Argoverse2,
            Self::Csv => ResultOutput::Csv,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_have_a_name_of_their_own() {
        let expected = NamedResults { name: "deep".to_owned(), path: "a=b/c".into() };
        assert_eq!("deep=a=b/c".parse(), Ok(expected));
        for (text, part) in [
            ("results", "write NAME=PATH"),
            ("deep=", "write NAME=PATH"),
            ("=results", "is no name of a detector"),
            ("a b=results", "is no name of a detector"),
            ("pca=results", "\"pca\" has the name of a built-in detector"),
        ] {
            let problem = text.parse::<NamedResults>().expect_err(text);
            assert!(problem.contains(part), "{problem}");
        }
    }
}
