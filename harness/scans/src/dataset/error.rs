//! What can be wrong with labelled scans, and with the way they are asked for.

use std::path::PathBuf;

use super::shown_name::shown;
use super::unpaired_files::UnpairedFiles;

/// Where to download, after everything else.
fn download(url: Option<&str>) -> String {
    url.map_or_else(String::new, |it| format!(" (download: {it})"))
}

/// Why labelled scans cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The name is neither in the catalogue nor on disk.
    #[error("there is no data set {name:?}: it is neither in the catalogue ({}) nor a path that exists", known.join(", "))]
    UnknownDataset {
        /// What was asked for.
        name: String,
        /// The catalogue's data sets.
        known: Vec<String>,
    },
    /// No format is called so.
    #[error("unknown format {name:?}; formats are {}", known.join(", "))]
    UnknownFormat {
        /// What was asked for.
        name: String,
        /// The formats there are.
        known: Vec<String>,
    },
    /// No sensor is called so, and no file describes it.
    #[error("there is no sensor {name:?}: it is neither one of {} nor a file", known.join(", "))]
    UnknownSensor {
        /// What was asked for.
        name: String,
        /// The sensors there are.
        known: Vec<String>,
    },
    /// A file that should describe a sensor does not.
    #[error("{path:?} does not describe a sensor")]
    Sensor {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A file that should say where a sensor is does not.
    #[error("{path:?} {}", shown(problem))]
    Transform {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, as the rest of a sentence about it.
        problem: String,
    },
    /// The format asked for is not the catalogue's.
    #[error("the catalogue says that {id:?} is {catalogued}, so it cannot be read as {asked_for}")]
    FormatContradictsCatalogue {
        /// The data set.
        id: String,
        /// Its format according to the catalogue.
        catalogued: String,
        /// The format asked for.
        asked_for: String,
    },
    /// Nothing at the path looks like a data set.
    #[error("{path:?} has no data set in a known format ({})", formats.join(", "))]
    UnrecognizedFormat {
        /// The path.
        path: PathBuf,
        /// The formats looked for.
        formats: Vec<String>,
    },
    /// Several data sets lie at the path.
    #[error("{path:?} has several data sets; give the path of one: {}", shown(&found.join(", ")))]
    SeveralDatasets {
        /// The path.
        path: PathBuf,
        /// Format and folder of each.
        found: Vec<String>,
    },
    /// A recording without the topic asked for, or with several where none was.
    #[error("{path:?} {problem}: {}", topics.join(", "))]
    Topic {
        /// The recording.
        path: PathBuf,
        /// What is wrong, as the rest of a sentence about it.
        problem: String,
        /// The topics there are.
        topics: Vec<String>,
    },
    /// The selection of scans cannot be understood, or selects nothing.
    #[error("scan selection {selection:?}: {problem}")]
    ScanSelection {
        /// The selection as written.
        selection: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The catalogue of data sets has a mistake.
    #[error("{}, line {line}: {}", shown(catalogue), shown(problem))]
    Catalogue {
        /// Its file, or what it is called if it is built in.
        catalogue: String,
        /// Line, counted from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
    /// The root of a catalogued data set depends on a variable without a value.
    #[error("the folder of {id:?} is not known: set {variable} to it{}", download(url.as_deref()))]
    UnsetVariable {
        /// The data set.
        id: String,
        /// The environment variable.
        variable: String,
        /// Where to get the data, if anywhere.
        url: Option<String>,
    },
    /// A catalogued data set is not where the catalogue says.
    #[error("{id:?} is not at {root:?}: {remedy}{}", download(url.as_deref()))]
    MissingRoot {
        /// The data set.
        id: String,
        /// Where it should be.
        root: PathBuf,
        /// What to change.
        remedy: String,
        /// Where to get the data, if anywhere.
        url: Option<String>,
    },
    /// The data are not those of the catalogue.
    #[error("{id:?} has checksum {found}, the catalogue says {expected}")]
    Checksum {
        /// The data set.
        id: String,
        /// The catalogue's.
        expected: String,
        /// That of the files.
        found: String,
    },
    /// The operating system refused.
    #[error("cannot read {path:?}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
    },
    /// There is nothing to evaluate.
    #[error("{path:?} has no scans")]
    NoScans {
        /// The folder.
        path: PathBuf,
    },
    /// The catalogue names a part of the data set that does not exist.
    #[error("the catalogue names {path:?}, which does not exist")]
    MissingSelected {
        /// The scan or the folder of the sequence.
        path: PathBuf,
    },
    /// Several scans or drives that cannot be told apart.
    #[error("several {kind} are called {name:?}: {}", paths.iter().map(|it| format!("{it:?}")).collect::<Vec<_>>().join(", "))]
    SameName {
        /// What they are.
        kind: &'static str,
        /// What they are called.
        name: String,
        /// Where they are.
        paths: Vec<PathBuf>,
    },
    /// A name that cannot be shown.
    #[error("{path:?}: the {kind} {name:?} has a control character in its name; rename it")]
    UnprintableName {
        /// The data set.
        path: PathBuf,
        /// What is called so.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// The list of the scans of a catalogued data set is not where the catalogue says.
    #[error(
        "the data set {id:?} reads the numbers of its scans, one a line, from {path:?}, which does not exist; put the list there"
    )]
    MissingScanList {
        /// The data set.
        id: String,
        /// The list.
        path: PathBuf,
    },
    /// The data set cannot be scored.
    #[error("{scans:?} has no labels ({labels:?} does not exist): a test split cannot be scored")]
    Unlabeled {
        /// The folder of the scans.
        scans: PathBuf,
        /// The folder in which the labels should be.
        labels: PathBuf,
    },
    /// A drive without its labels.
    #[error("the labels {labels:?} of {scan:?} do not exist")]
    ScanWithoutLabels {
        /// The folder of the drive's scans.
        scan: PathBuf,
        /// The missing file.
        labels: PathBuf,
    },
    /// Scans and labels, a file each, that do not go together.
    #[error("{labels:?} does not go with the scans: {unpaired}")]
    Unpaired {
        /// The folder of the labels.
        labels: PathBuf,
        /// Which files lack the other.
        unpaired: UnpairedFiles,
    },
    /// A scan without its calibration.
    #[error("the calibration {calibration:?} of {scan:?} does not exist")]
    ScanWithoutCalibration {
        /// The scan, or the folder of the sequence.
        scan: PathBuf,
        /// The missing file.
        calibration: PathBuf,
    },
    /// A file whose name does not follow the format.
    #[error("{path:?} has a wrong name; the format requires {expected}")]
    FileName {
        /// The file.
        path: PathBuf,
        /// How such files are named.
        expected: &'static str,
    },
    /// A scan without points.
    #[error("{path:?} has no points")]
    NoPoints {
        /// The file.
        path: PathBuf,
    },
    /// A scan that ends within a point.
    #[error(
        "{path:?} is damaged or cut off: its {n_bytes} bytes are not a multiple of the {n_bytes_per_point} of a point"
    )]
    PartialPoint {
        /// The file.
        path: PathBuf,
        /// Its size.
        n_bytes: usize,
        /// The size of a point.
        n_bytes_per_point: usize,
    },
    /// Labels of another scan.
    #[error("{path:?} has {n_labels} labels, but its scan has {n_points} points")]
    LabelCount {
        /// The file of the labels.
        path: PathBuf,
        /// Labels in it.
        n_labels: usize,
        /// Points of the scan.
        n_points: usize,
    },
    /// Labels of classes that nobody knows.
    #[error("the labels of {id:?} have {n_names} unknown classes:\n{listing}")]
    UnknownClasses {
        /// The data set.
        id: String,
        /// How many names there are in the list.
        n_names: usize,
        /// The names, and how to say what they are.
        listing: String,
    },
    /// Folders of objects whose names are no classes.
    #[error(
        "{path:?} has folders that are called after no class: {}; classes are {}, and what else of a street has a name",
        shown(&names.join(", ")), known.join(", ")
    )]
    UnknownClassFolders {
        /// The folder around them.
        path: PathBuf,
        /// Their names.
        names: Vec<String>,
        /// The classes.
        known: Vec<String>,
    },
    /// No clouds of objects where they should be.
    #[error("{path:?} has no {expected}")]
    NoObjects {
        /// The folder.
        path: PathBuf,
        /// What should be in it.
        expected: String,
    },
    /// A file that does not follow its format.
    #[error("{path:?} {}", shown(problem))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, as the rest of a sentence about it.
        problem: String,
    },
    /// Bytes that are no text.
    #[error("{path:?} is not text: invalid UTF-8 at byte {byte_offset}")]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first bad byte, counted from 0.
        byte_offset: usize,
    },
    /// A line that does not follow the format.
    #[error("{path:?}, line {line}: {}", shown(problem))]
    Line {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// A calibration that lacks a matrix.
    #[error("{path:?} has no line {expected}")]
    CalibrationEntry {
        /// The file.
        path: PathBuf,
        /// The name or names of the missing line.
        expected: &'static str,
    },
    /// A calibration whose rotation is none.
    #[error(
        "{path:?}: {entry} is not a rotation: its columns differ from right angles and unit length by {deviation}, more than {allowed}"
    )]
    NotARotation {
        /// The file.
        path: PathBuf,
        /// The name or names of the line.
        entry: &'static str,
        /// Largest difference between the matrix times its transpose and the identity; infinite for a reflection.
        deviation: f64,
        /// The largest difference that rounding explains.
        allowed: f64,
    },
    /// Results of another program that are not of a known format, or cannot belong to the data set.
    #[error("{path:?} {}", shown(problem))]
    UnusableResults {
        /// The file or folder of the results.
        path: PathBuf,
        /// What is wrong with it, as the rest of a sentence about it.
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
        /// The first of them, and what can be done.
        first: String,
    },
    /// An image whose size cannot be read.
    #[error("{path:?} is not a PNG image")]
    NotAPng {
        /// The file.
        path: PathBuf,
    },
}

impl DatasetError {
    /// Whether the user asked for something that does not exist (exit code 2), rather than the data being missing or
    /// damaged (exit code 3).
    pub fn is_usage_error(&self) -> bool {
        matches!(
            self,
            Self::UnknownDataset { .. }
                | Self::UnknownFormat { .. }
                | Self::UnknownSensor { .. }
                | Self::Sensor { .. }
                | Self::Transform { .. }
                | Self::FormatContradictsCatalogue { .. }
                | Self::UnrecognizedFormat { .. }
                | Self::SeveralDatasets { .. }
                | Self::Topic { .. }
                | Self::ScanSelection { .. }
                | Self::Catalogue { .. }
                | Self::UnknownClasses { .. }
                | Self::UnknownClassFolders { .. }
                | Self::UnusableResults { .. }
        )
    }
}
