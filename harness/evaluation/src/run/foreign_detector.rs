//! A detector that somebody else wrote, as a configuration file defines it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use reports::vocabulary::named::named;

use crate::process::message::Introduction;

/// What is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ForeignDetector {
    /// Its name in tables and files.
    pub name: &'static str,
    /// The folder of the file that defines it.
    pub folder: PathBuf,
    /// How it comes to its detections.
    pub work: ForeignWork,
    /// What classifies vehicles among its objects, where it does not.
    pub vehicles: VehicleRule,
}

/// How a foreign detector comes to its detections.
#[derive(Debug, Clone, PartialEq)]
pub enum ForeignWork {
    /// It is a program.
    Process(ForeignProcess),
    /// It was a program somewhere else, which left its results here: a file, a folder, or the topic of a recording.
    Results(PathBuf),
}

/// How its program is run.
#[derive(Debug, Clone, PartialEq)]
pub struct ForeignProcess {
    /// The program and its arguments.
    pub command: Vec<String>,
    /// How long it may take from its start until it can be asked.
    pub start_limit: Duration,
    /// How long it may take for a scan.
    pub time_limit: Duration,
    /// How many threads it should use at most.
    pub threads: u32,
    /// SHA-256 of the files that the command and text among the parameters name; none before it is chosen.
    pub files: BTreeMap<String, String>,
    /// What it said of itself, once it has been started.
    pub introduction: Arc<OnceLock<Introduction>>,
}

named! {
    /// What classifies vehicles.
    #[derive(Default)]
    pub enum VehicleRule {
        /// Their size.
        Size = "size",
        /// The model of our own clusterings.
        #[default]
        Model = "model",
    }
}
