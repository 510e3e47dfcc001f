//! A foreign detector, as a configuration file defines it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use reports::vocabulary::named::named;

use crate::process::message::Introduction;

/// Definition of a foreign detector.
#[derive(Debug, Clone, PartialEq)]
pub struct ForeignDetector {
    /// Its name in tables and files.
    pub name: &'static str,
    /// The folder of the file that defines it.
    pub folder: PathBuf,
    /// How it makes its detections.
    pub work: ForeignWork,
    /// Rule that classifies vehicles among its objects if it predicts no class.
    pub vehicles: VehicleRule,
}

/// How a foreign detector makes its detections.
#[derive(Debug, Clone, PartialEq)]
pub enum ForeignWork {
    /// It is a program.
    Process(ForeignProcess),
    /// Its results, which a program made elsewhere: a file, a folder, or the topic of a recording.
    Results(PathBuf),
}

/// How its program is run.
#[derive(Debug, Clone, PartialEq)]
pub struct ForeignProcess {
    /// The program and its arguments.
    pub command: Vec<String>,
    /// Time limit from its start until it can be asked.
    pub start_limit: Duration,
    /// Time limit for a scan.
    pub time_limit: Duration,
    /// Most threads that it should use.
    pub threads: u32,
    /// Whether it has no network, and sees neither data sets nor runs.
    pub sandbox: bool,
    /// SHA-256 of the files that the command and text parameters name; empty before it is chosen.
    pub files: BTreeMap<String, String>,
    /// Its introduction, once it has been started.
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
