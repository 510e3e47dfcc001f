//! Errors of labelled scans, and of requests for them.

use std::path::{Path, PathBuf};

use reports::verdicts::suggestion::closest;

use super::shown_name::shown;

/// Why labelled scans cannot be read: a sentence. A kind is distinguished only where some code depends on it.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The user asked for something that does not exist, or is impossible.
    #[error("{0}")]
    Usage(String),
    /// A file that should describe a sensor does not.
    #[error("{path:?} does not describe a sensor")]
    Sensor {
        /// The file.
        path: PathBuf,
        /// The problem with it.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// Nothing at the path looks like a data set.
    #[error("{path:?} has no data set in a known format ({}); see docs/formats.md", formats.join(", "))]
    UnrecognizedFormat {
        /// The path.
        path: PathBuf,
        /// The formats looked for.
        formats: Vec<String>,
    },
    /// Results of another program that are not of a known format, or cannot belong to the data set.
    #[error("{path:?} {}", shown(problem))]
    UnusableResults {
        /// The file or folder of the results.
        path: PathBuf,
        /// The problem with it, as the rest of a sentence about it.
        problem: String,
    },
    /// Results of another program that lack scans.
    #[error("{path:?} has no results for {n_missing} of {n_asked} scans of {dataset:?}: {}", shown(first))]
    MissingResults {
        /// The file or folder of the results.
        path: PathBuf,
        /// The data set.
        dataset: String,
        /// Scans without results.
        n_missing: usize,
        /// Scans that are asked for.
        n_asked: usize,
        /// The first of the missing scans, and the way out.
        first: String,
    },
    /// The operating system refused.
    #[error("cannot read {path:?}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file or folder that does not follow its format.
    #[error("{path:?} {}", shown(problem))]
    Damaged {
        /// The file or folder.
        path: PathBuf,
        /// The problem with it, as the rest of a sentence about it.
        problem: String,
    },
    /// A line that does not follow the format.
    #[error("{path:?}, line {line}: {}", shown(problem))]
    Line {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// The problem with it.
        problem: String,
    },
    /// The data are missing, or not what they should be.
    #[error("{0}")]
    Unsound(String),
}

impl DatasetError {
    /// Whether the user asked for something that does not exist (exit code 2), rather than the data being missing or
    /// damaged (exit code 3).
    pub fn is_usage_error(&self) -> bool {
        matches!(
            self,
            Self::Usage(_)
                | Self::Sensor { .. }
                | Self::UnrecognizedFormat { .. }
                | Self::UnusableResults { .. }
        )
    }

    /// The error of the operating system about `path`.
    pub fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + Copy + '_ {
        move |source| Self::Io { path: path.to_path_buf(), source }
    }

    /// A problem with `path`, as the rest of a sentence about it.
    pub fn damaged(path: impl Into<PathBuf>, problem: impl Into<String>) -> Self {
        Self::Damaged { path: path.into(), problem: problem.into() }
    }

    /// There is nothing to evaluate in `path`.
    pub fn no_scans(path: impl Into<PathBuf>) -> Self {
        Self::damaged(path, "has no scans")
    }

    /// The name of `path` does not follow the format, which requires `expected`.
    pub fn file_name(path: impl Into<PathBuf>, expected: &str) -> Self {
        Self::damaged(path, format!("has a wrong name; the format requires {expected}"))
    }

    /// There is no data set of this name beside the `known` ones.
    pub fn unknown_dataset(name: &str, known: &[String]) -> Self {
        /// More names are not listed: a user with one name in mind does not read them.
        const MOST_LISTED: usize = 10;
        let closest = closest(name, known.iter().map(String::as_str));
        let listed =
            if known.len() > MOST_LISTED { "`scanbench data list`".to_owned() } else { known.join(", ") };
        let it = closest.map_or_else(|| ": it".to_owned(), |it| format!("; did you mean {it:?}? It"));
        let message = format!(
            "there is no data set {name:?}{it} is neither in the catalogue ({listed}) nor a path that exists"
        );
        Self::Usage(message)
    }

    /// The data set `id` of the catalogue, in `root`, has the same name as a folder here.
    pub fn two_of_a_name(id: &str, root: &Path) -> Self {
        Self::Usage(format!(
            "{id:?} is a data set of the catalogue, in {root:?}, and a folder here: write ./{id} for the folder here, or {root:?}"
        ))
    }

    /// The format asked for is not that of the catalogue.
    pub fn other_format(id: &str, catalogued: &str, asked_for: &str) -> Self {
        let message =
            format!("the catalogue says that {id:?} is {catalogued}, so it cannot be read as {asked_for}");
        Self::Usage(message)
    }

    /// Several data sets lie at `path`.
    pub fn several_datasets(path: &Path, found: &[String]) -> Self {
        let found = found.join(", ");
        Self::Usage(format!("{path:?} has several data sets; give the path of one: {}", shown(&found)))
    }

    /// A part of the data set that the catalogue names does not exist.
    pub fn missing_selected(path: &Path) -> Self {
        Self::Unsound(format!("the catalogue names {path:?}, which does not exist"))
    }

    /// Several scans or drives have the same name.
    pub fn same_name(kind: &str, name: &str, paths: &[&Path]) -> Self {
        let paths = paths.iter().map(|it| format!("{it:?}")).collect::<Vec<_>>().join(", ");
        Self::Unsound(format!("several {kind} are called {name:?}: {paths}"))
    }

    /// There is no folder `labels` to score the scans with.
    pub fn unlabeled(scans: &Path, labels: &Path) -> Self {
        Self::Unsound(format!(
            "{scans:?} has no labels ({labels:?} does not exist): a test split cannot be scored"
        ))
    }

    /// A scan or drive lacks its labels.
    pub fn without_labels(scan: &Path, labels: &Path) -> Self {
        Self::Unsound(format!("the labels {labels:?} of {scan:?} do not exist"))
    }

    /// A scan or drive lacks its calibration.
    pub fn without_calibration(scan: &Path, calibration: &Path) -> Self {
        Self::Unsound(format!("the calibration {calibration:?} of {scan:?} does not exist"))
    }

    /// A file of labels belongs to another scan.
    pub fn label_count(path: &Path, n_labels: usize, n_points: usize) -> Self {
        Self::damaged(path, format!("has {n_labels} labels, but its scan has {n_points} points"))
    }

    /// A file ends within a point or a label.
    pub fn partial_point(path: &Path, n_bytes: usize, n_bytes_per_point: usize) -> Self {
        let problem = format!(
            "is damaged or cut off: its {n_bytes} bytes are not a multiple of the {n_bytes_per_point} of a point"
        );
        Self::damaged(path, problem)
    }

    /// A calibration lacks the line `expected`.
    pub fn calibration_entry(path: &Path, expected: &str) -> Self {
        Self::damaged(path, format!("has no line {expected}"))
    }
}
