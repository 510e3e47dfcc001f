//! `[detector.NAME]`: detectors that are not built in.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use toml::{Table, Value};

use super::error::{ConfigError, ConfigPosition};
use crate::run::foreign_detector::{ForeignDetector, ForeignProcess, ForeignWork, VehicleRule};
use crate::run::kept_names::kept;

/// The table of detectors that are not built in.
pub const DETECTOR_TABLE: &str = "detector";

/// Keys that a table of a detector may have.
pub(super) const KEYS: [&str; 8] =
    ["command", "results", "parameters", "start_limit_s", "time_limit_s", "threads", "sandbox", "vehicles"];
/// Names of built-in detectors.
pub const TAKEN_NAMES: [&str; 9] = [
    "hierarchical",
    "kd-tree-trained",
    "kd-tree-tree",
    "paper",
    "kd-tree",
    "kd-tree-same-walls",
    "pca",
    "simple-grid",
    "nothing",
];
/// Default time limit until a detector can be asked.
pub(super) const START_LIMIT: Duration = Duration::from_secs(30);
/// Default time limit for a scan.
pub(super) const TIME_LIMIT: Duration = Duration::from_secs(10);
/// Longest time limit, in seconds.
pub(super) const LONGEST_LIMIT_S: f64 = 3600.0;
/// Most threads.
pub(super) const MOST_THREADS: i64 = 1024;

/// The detectors that the file at `path` defines in its table `written`, and a table of parameters for each detector that
/// has any; `position_of` gives the position of a key in the file.
pub(super) fn foreign_detectors(
    path: &Path,
    position_of: &dyn Fn(&[String]) -> ConfigPosition,
    written: Value,
) -> Result<(Vec<ForeignDetector>, Table), ConfigError> {
    let folder = folder_of(path);
    let top = DetectorTable { folder: &folder, position_of, keys: vec![DETECTOR_TABLE.to_owned()] };
    let mut detectors = Vec::new();
    let mut parameters = Table::new();
    for (name, value) in top.table(written)? {
        let entry = top.below(&name);
        entry.check_name(&name)?;
        let mut table = entry.table(value)?;
        if let Some(of_detector) = table.remove("parameters") {
            let of_detector = entry.below("parameters").table(of_detector)?;
            parameters.insert(name.clone(), Value::Table(of_detector));
        }
        detectors.push(entry.detector(&name, table)?);
    }
    Ok((detectors, parameters))
}

/// A value within a file, and the keys that lead to it.
struct DetectorTable<'a> {
    folder: &'a Path,
    position_of: &'a dyn Fn(&[String]) -> ConfigPosition,
    keys: Vec<String>,
}

impl DetectorTable<'_> {
    fn below(&self, key: &str) -> Self {
        let keys = self.keys.iter().cloned().chain([key.to_owned()]).collect();
        Self { keys, ..*self }
    }

    fn detector(&self, name: &str, mut table: Table) -> Result<ForeignDetector, ConfigError> {
        if let Some(key) = table.keys().find(|it| !KEYS.contains(&it.as_str())) {
            let remedy = format!("a detector has {}", KEYS.join(", "));
            let position = (self.position_of)(&self.below(key).keys);
            return Err(ConfigError::Unknown { position, key: self.below(key).keys.join("."), remedy });
        }
        let work = match (table.remove("command"), table.remove("results")) {
            (Some(_), Some(_)) => {
                return Err(self.problem(" has both a command and results; a detector has one".to_owned()));
            }
            (None, Some(results)) => ForeignWork::Results(self.below("results").path(results)?),
            (Some(command), None) => ForeignWork::Process(ForeignProcess {
                command: self.below("command").command(command)?,
                start_limit: self.limit("start_limit_s", table.remove("start_limit_s"), START_LIMIT)?,
                time_limit: self.limit("time_limit_s", table.remove("time_limit_s"), TIME_LIMIT)?,
                threads: self.threads(table.remove("threads"))?,
                sandbox: self.sandbox(table.remove("sandbox"))?,
                files: BTreeMap::new(),
                introduction: Arc::default(),
            }),
            (None, None) => {
                let remedy = "write command = [\"python3\", \"detector.py\"], or results = \"FOLDER\"";
                return Err(self.problem(format!(" says no command; {remedy}")));
            }
        };
        let vehicles = self.vehicles(table.remove("vehicles"))?;
        if let Some(key) = table.keys().next() {
            return Err(self.below(key).problem(" is for programs alone".to_owned()));
        }
        Ok(ForeignDetector { name: kept(name), folder: self.folder.to_owned(), work, vehicles })
    }

    /// A path, relative to the folder of the file.
    fn path(&self, written: Value) -> Result<PathBuf, ConfigError> {
        match written {
            Value::String(path) if path.is_empty() => {
                Err(self.problem(" names no file or folder".to_owned()))
            }
            Value::String(path) => Ok(self.folder.join(path)),
            other => Err(self.wrong_type(&other, "string")),
        }
    }

    fn command(&self, written: Value) -> Result<Vec<String>, ConfigError> {
        let Value::Array(words) = written else { return Err(self.wrong_type(&written, "array")) };
        let word = |it: Value| match it {
            Value::String(word) if !word.contains('\0') => Ok(word),
            Value::String(_) => Err(self.problem(" has a word with a zero byte".to_owned())),
            other => Err(self.wrong_type(&other, "array of strings")),
        };
        let words = words.into_iter().map(word).collect::<Result<Vec<String>, _>>()?;
        if words.first().is_none_or(String::is_empty) {
            return Err(self.problem(" names no program".to_owned()));
        }
        Ok(words)
    }

    fn limit(&self, key: &str, written: Option<Value>, default: Duration) -> Result<Duration, ConfigError> {
        let entry = self.below(key);
        let limit_s = match written {
            None => return Ok(default),
            Some(Value::Float(limit_s)) => limit_s,
            Some(Value::Integer(limit_s)) => limit_s as f64,
            Some(other) => return Err(entry.wrong_type(&other, "float")),
        };
        if limit_s > 0.0 && limit_s <= LONGEST_LIMIT_S {
            return Ok(Duration::from_secs_f64(limit_s));
        }
        Err(entry.problem(format!(" = {limit_s} is not above 0 and at most {LONGEST_LIMIT_S}")))
    }

    fn threads(&self, written: Option<Value>) -> Result<u32, ConfigError> {
        let entry = self.below("threads");
        match written {
            None => Ok(1),
            Some(Value::Integer(threads @ 1..=MOST_THREADS)) => Ok(threads as u32),
            Some(Value::Integer(threads)) => {
                Err(entry.problem(format!(" = {threads} is not within 1 to {MOST_THREADS}")))
            }
            Some(other) => Err(entry.wrong_type(&other, "integer")),
        }
    }

    fn sandbox(&self, written: Option<Value>) -> Result<bool, ConfigError> {
        match written {
            None => Ok(false),
            Some(Value::Boolean(sandbox)) => Ok(sandbox),
            Some(other) => Err(self.below("sandbox").wrong_type(&other, "boolean")),
        }
    }

    fn vehicles(&self, written: Option<Value>) -> Result<VehicleRule, ConfigError> {
        let entry = self.below("vehicles");
        match written {
            None => Ok(VehicleRule::default()),
            Some(Value::String(word)) => {
                let known = VehicleRule::ALL.map(VehicleRule::name).join(", ");
                VehicleRule::from_name(&word)
                    .ok_or_else(|| entry.problem(format!(" = {word:?} is none of {known}")))
            }
            Some(other) => Err(entry.wrong_type(&other, "string")),
        }
    }

    fn check_name(&self, name: &str) -> Result<(), ConfigError> {
        check_name(name).map_err(|problem| self.problem(format!(" {problem}")))
    }

    fn table(&self, written: Value) -> Result<Table, ConfigError> {
        match written {
            Value::Table(table) => Ok(table),
            other => Err(self.wrong_type(&other, "table")),
        }
    }

    fn wrong_type(&self, found: &Value, expected: &'static str) -> ConfigError {
        let (position, key) = ((self.position_of)(&self.keys), self.keys.join("."));
        ConfigError::WrongType { position, key, found: found.type_str(), expected }
    }

    fn problem(&self, problem: String) -> ConfigError {
        ConfigError::Value { position: (self.position_of)(&self.keys), key: self.keys.join("."), problem }
    }
}

/// Checks that `name` is allowed for a detector. Errors are the rest of a sentence about the name.
///
/// # Errors
///
/// If it is no valid name, or the name of a built-in detector.
pub fn check_name(name: &str) -> Result<(), String> {
    let is_of_name = |it: char| it.is_ascii_alphanumeric() || it == '-' || it == '_';
    if name.len() > 40
        || !name.starts_with(|it: char| it.is_ascii_alphanumeric())
        || !name.chars().all(is_of_name)
    {
        return Err("is no name of a detector: letters, digits, - and _, at most 40".to_owned());
    }
    if TAKEN_NAMES.contains(&name) {
        return Err("has the name of a built-in detector".to_owned());
    }
    Ok(())
}

/// The working folder of a detector that a file defines.
fn folder_of(file: &Path) -> PathBuf {
    let folder = file.parent().filter(|it| !it.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::config::RunConfig;

    fn load(text: &str) -> Result<RunConfig, ConfigError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scanbench.toml");
        std::fs::write(&path, text).unwrap();
        RunConfig::load(Some(&path))
    }

    const DBSCAN: &str = "[detector.dbscan]\ncommand = [\"python3\", \"dbscan.py\"]\nparameters = { eps = 0.5, kind = \"tree\" }\n";

    #[test]
    fn a_detector_has_its_command_and_parameters() {
        let config = load(&format!("{DBSCAN}time_limit_s = 2\nthreads = 4\nvehicles = \"model\"")).unwrap();
        let [detector] = &config.foreign[..] else { panic!("{:?}", config.foreign) };
        let ForeignWork::Process(process) = &detector.work else { panic!("{:?}", detector.work) };
        assert_eq!((detector.name, detector.vehicles), ("dbscan", VehicleRule::Model));
        assert_eq!(
            (process.command.len(), process.time_limit, process.threads),
            (2, Duration::from_secs(2), 4)
        );
        assert_eq!(config.resolved["detector"]["dbscan"]["eps"].as_float(), Some(0.5));
    }

    #[test]
    fn results_lie_beside_the_file_that_names_them() {
        let config = load("[detector.deep]\nresults = \"out/deep\"\nvehicles = \"model\"").unwrap();
        let [detector] = &config.foreign[..] else { panic!("{:?}", config.foreign) };
        let ForeignWork::Results(path) = &detector.work else { panic!("{:?}", detector.work) };
        assert_eq!((path, detector.vehicles), (&detector.folder.join("out/deep"), VehicleRule::Model));
    }

    #[test]
    fn its_parameters_are_chosen_as_ours_are() {
        let config = load(DBSCAN).unwrap();
        for written in ["eps=0.7", "dbscan.eps=0.7", "detector.dbscan.eps=0.7"] {
            let option = written.parse().unwrap();
            let changed = config.overridden(&[option], &["detector.dbscan", "kd_tree"]).unwrap();
            assert_eq!(changed.value_of("detector.dbscan.eps").and_then(Value::as_float), Some(0.7));
            assert_eq!(changed.foreign, config.foreign);
        }
        let refused = |written: &str| {
            let option = written.parse().unwrap();
            config.overridden(&[option], &["detector.dbscan"]).unwrap_err().to_string()
        };
        assert!(refused("epsilon=0.7").contains("dbscan"), "{}", refused("epsilon=0.7"));
        assert!(refused("eps=far").contains("is of type string, but must be float"));
    }

    #[test]
    fn mistakes_are_reported_with_their_line() {
        for (text, expected) in [
            ("[detector.dbscan]\nthreads = 2", "line 1: detector.dbscan says no command"),
            (
                "[detector.dbscan]\ncommand = \"python3\"",
                "line 2: detector.dbscan.command is of type string, but must be array",
            ),
            (
                "[detector.deep]\nresults = 3",
                "line 2: detector.deep.results is of type integer, but must be string",
            ),
            (
                "[detector.deep]\nresults = \"a\"\ncommand = [\"x\"]",
                "line 1: detector.deep has both a command and results",
            ),
            (
                "[detector.deep]\nresults = \"a\"\nthreads = 2",
                "line 3: detector.deep.threads is for programs alone",
            ),
            ("[detector.dbscan]\ncommand = []", "line 2: detector.dbscan.command names no program"),
            (
                "[detector.dbscan]\ncommand = [\"x\"]\nthread = 2",
                "line 3: unknown parameter detector.dbscan.thread",
            ),
            (
                "[detector.dbscan]\ncommand = [\"x\"]\nthreads = 0",
                "line 3: detector.dbscan.threads = 0 is not within 1 to 1024",
            ),
            ("[detector.dbscan]\ncommand = [\"x\"]\ntime_limit_s = nan", "time_limit_s = NaN is not above 0"),
            ("[detector.dbscan]\ncommand = [\"x\"]\nvehicles = \"all\"", "\"all\" is none of size, model"),
            ("[detector.pca]\ncommand = [\"x\"]", "has the name of a built-in detector"),
            ("[detector.\"a b\"]\ncommand = [\"x\"]", "is no name of a detector"),
            ("detector = 3", "detector is of type integer, but must be table"),
        ] {
            let error = load(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
