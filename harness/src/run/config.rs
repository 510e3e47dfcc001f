//! The parameters of a run: those that ship, overridden by a file.

use std::path::{Path, PathBuf};

use baselines::params::{BaselineParams, PARAMS_TOML};
use detector::params::{HierarchicalParams, PAPER_TOML, ParamsError};
use serde::Deserialize;
use toml::de::DeTable;
use toml::{Table, Value};

use crate::matching::assign::MatchingParams;
use crate::matching::criterion::Criterion;
use crate::matching::eligibility::EligibilityParams;

/// Parameters of everything that takes part in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunConfig {
    /// The hierarchical detector.
    pub hierarchical: HierarchicalParams,
    /// The baselines.
    pub baselines: BaselineParams,
    /// How detections are judged.
    pub matching: MatchingParams,
    /// All of it as one document, for the manifest.
    pub resolved: Table,
}

/// How detections are judged when nothing else is said; the same for every detector.
const MATCHING_TOML: &str = r#"
criterion = "points"
min_iou = 0.5
max_centre_distance_m = 2.0
min_points = 20
max_range_m = 80.0
"#;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MatchingTable {
    criterion: CriterionTable,
    min_iou: f64,
    max_centre_distance_m: f64,
    min_points: usize,
    max_range_m: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum CriterionTable {
    Points,
    Centre,
}

/// Why a configuration cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The operating system refused.
    #[error("cannot read the configuration {path:?}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("{path:?} is not a configuration: {source}")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: toml::de::Error,
    },
    /// A parameter that nothing reads.
    #[error("{path:?}, line {line}: unknown parameter {key}; there are {known}")]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The parameter with the tables it is in.
        key: String,
        /// The parameters there are in its table.
        known: String,
    },
    /// A parameter of the wrong type.
    #[error("{path:?}, line {line}: {key} is of type {found}, expected {expected}")]
    WrongType {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The parameter with the tables it is in.
        key: String,
        /// The type of its value.
        found: &'static str,
        /// The type it should have.
        expected: &'static str,
    },
    /// A value that cannot be worked with.
    #[error("{path:?}: {source}")]
    Params {
        /// The file.
        path: PathBuf,
        /// Which value, and why.
        source: ParamsError,
    },
}

/// All parameters there are, with the values they have unless overridden.
fn shipped() -> Table {
    let parse = |text: &str| text.parse::<Table>().expect("the embedded files are tested");
    let mut all = parse(PARAMS_TOML);
    all.insert("matching".to_owned(), Value::Table(parse(MATCHING_TOML)));
    all.insert("hierarchical".to_owned(), Value::Table(parse(PAPER_TOML)));
    all
}

impl RunConfig {
    /// The shipped parameters, with those that the TOML file at `overrides`, if any, gives other values.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] if the file cannot be read, or holds what no detector knows or can work with.
    pub fn load(overrides: Option<&Path>) -> Result<Self, ConfigError> {
        let Some(path) = overrides else { return Self::resolve("", Path::new("built-in configuration")) };
        let text = std::fs::read_to_string(path)
            .map_err(|source| ConfigError::Io { path: path.to_owned(), source })?;
        Self::resolve(&text, path)
    }

    /// Judges by `criterion`, whatever the file says.
    pub fn choose_criterion(&mut self, criterion: Criterion) {
        self.matching.criterion = match (criterion, self.resolved.get("matching").and_then(Value::as_table)) {
            (Criterion::Points { .. }, Some(table)) => {
                Criterion::Points { min_iou: number(table, "min_iou") }
            }
            (Criterion::Centre { .. }, Some(table)) => {
                Criterion::Centre { max_distance_m: number(table, "max_centre_distance_m") }
            }
            (criterion, None) => criterion,
        };
        if let Some(Value::Table(table)) = self.resolved.get_mut("matching") {
            table.insert("criterion".to_owned(), Value::String(criterion.name().to_owned()));
        }
    }

    fn resolve(overrides: &str, path: &Path) -> Result<Self, ConfigError> {
        let syntax = |source| ConfigError::Syntax { path: path.to_owned(), source };
        let values = overrides.parse::<Table>().map_err(syntax)?;
        let mut resolved = shipped();
        let source = OverrideSource { path, text: overrides };
        source.apply(&mut resolved, values, &mut Vec::new())?;
        let params = |source| ConfigError::Params { path: path.to_owned(), source };
        let document = |name: &str| resolved[name].as_table().map(Table::to_string).unwrap_or_default();
        let of_baselines =
            resolved.iter().filter(|(name, _)| !["matching", "hierarchical"].contains(&name.as_str()));
        let baselines: Table = of_baselines.map(|(name, value)| (name.clone(), value.clone())).collect();
        Ok(Self {
            hierarchical: HierarchicalParams::from_toml(&document("hierarchical")).map_err(params)?,
            baselines: BaselineParams::from_toml(&baselines.to_string()).map_err(params)?,
            matching: matching_from(&document("matching")).map_err(params)?,
            resolved,
        })
    }
}

/// A number of a table that has been checked to hold it.
fn number(table: &Table, name: &str) -> f64 {
    table.get(name).and_then(Value::as_float).expect("the table was read into parameters before")
}

/// The document that overrides values, for error messages.
struct OverrideSource<'a> {
    path: &'a Path,
    text: &'a str,
}

impl OverrideSource<'_> {
    /// Puts the values of `overrides` into `table`, which is found under `parents`.
    fn apply(
        &self,
        table: &mut Table,
        overrides: Table,
        parents: &mut Vec<String>,
    ) -> Result<(), ConfigError> {
        for (key, value) in overrides {
            parents.push(key);
            let key = parents.last().expect("it was just pushed");
            let path = || self.path.to_owned();
            let Some(present) = table.get_mut(key) else {
                let known = table.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
                let (line, key) = (self.line_of(parents), parents.join("."));
                return Err(ConfigError::Unknown { path: path(), line, key, known });
            };
            match (present, value) {
                (Value::Table(table), Value::Table(overrides)) => self.apply(table, overrides, parents)?,
                (present @ Value::Float(_), Value::Integer(value)) => *present = Value::Float(value as f64),
                (present, value) if present.same_type(&value) => *present = value,
                (present, value) => {
                    let (found, expected) = (value.type_str(), present.type_str());
                    let (line, key) = (self.line_of(parents), parents.join("."));
                    return Err(ConfigError::WrongType { path: path(), line, key, found, expected });
                }
            }
            parents.pop();
        }
        Ok(())
    }

    /// Line, from 1, on which the key with these parents stands.
    fn line_of(&self, keys: &[String]) -> usize {
        let document = DeTable::parse(self.text).expect("the document was parsed before");
        let mut table = document.get_ref();
        let mut offset = 0;
        for key in keys {
            let Some((key, value)) = table.get_key_value(key.as_str()) else { break };
            offset = key.span().start;
            let Some(inner) = value.get_ref().as_table() else { break };
            table = inner;
        }
        1 + self.text[..offset].matches('\n').count()
    }
}

fn matching_from(text: &str) -> Result<MatchingParams, ParamsError> {
    let table: MatchingTable = toml::from_str(text)?;
    let within = |name, value: f64, low: f64, high: f64, allowed| {
        if (low..=high).contains(&value) {
            Ok(())
        } else {
            Err(ParamsError::OutOfRange { name, value, allowed })
        }
    };
    // Above one half an annotation can agree with one detection only, and this is what makes a match mean something.
    within("matching.min_iou", table.min_iou, 0.01, 1.0, "0.01 to 1")?;
    within("matching.max_centre_distance_m", table.max_centre_distance_m, 0.01, 100.0, "0.01 to 100 m")?;
    within("matching.max_range_m", table.max_range_m, 1.0, 1000.0, "1 to 1000 m")?;
    let criterion = match table.criterion {
        CriterionTable::Points => Criterion::Points { min_iou: table.min_iou },
        CriterionTable::Centre => Criterion::Centre { max_distance_m: table.max_centre_distance_m },
    };
    let eligibility = EligibilityParams { min_points: table.min_points, max_range_m: table.max_range_m };
    Ok(MatchingParams { criterion, eligibility })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolve(text: &str) -> Result<RunConfig, ConfigError> {
        RunConfig::resolve(text, Path::new("mine.toml"))
    }

    #[test]
    fn nothing_overridden_is_the_standard() {
        let config = resolve("").unwrap();
        assert_eq!(config.hierarchical, HierarchicalParams::paper());
        assert_eq!(config.baselines, BaselineParams::shipped());
        let standard =
            MatchingParams { criterion: Criterion::POINTS, eligibility: EligibilityParams::STANDARD };
        assert_eq!(config.matching, standard);
    }

    #[test]
    fn a_value_is_overridden_alone() {
        let config = resolve("[hierarchical.grid]\ncell_size_m = 1\n[kd_tree]\ntolerance_m = 0.7").unwrap();
        assert_eq!((config.hierarchical.grid.cell_size_m, config.hierarchical.grid.xi), (1.0, 3));
        assert_eq!(config.baselines.kd_tree.tolerance_m, 0.7);
        let resolved = config.resolved["hierarchical"]["grid"]["cell_size_m"].as_float();
        assert_eq!(resolved, Some(1.0));
    }

    #[track_caller]
    fn check_refused(text: &str, message: &str) {
        let error = resolve(text).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn what_nothing_reads_is_refused_with_its_line() {
        check_refused(
            "# mine\n[kd_tree]\ntolerence_m = 1.0",
            "\"mine.toml\", line 3: unknown parameter kd_tree.tolerence_m",
        );
        check_refused(
            "[hirarchical]",
            "line 1: unknown parameter hirarchical; there are hierarchical, kd_tree, matching, pca",
        );
        check_refused(
            "[kd_tree]\ntolerance_m = \"far\"",
            "line 2: kd_tree.tolerance_m is of type string, expected float",
        );
        check_refused("[matching]\nmin_iou = 0.0", "matching.min_iou = 0 is outside of 0.01 to 1");
        check_refused("[matching]\nmin_points = -1", "\"mine.toml\": ");
        check_refused("[kd_tree", "\"mine.toml\" is not a configuration");
    }
}
