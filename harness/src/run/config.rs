//! The parameters of a run: those that ship, overridden by a file.

use std::path::{Path, PathBuf};

use baselines::params::{BaselineParams, PARAMS_TOML};
use detector::grid::density_curve::DensityCurve;
use detector::params::{HierarchicalParams, ParamsError};
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
    /// All of it as one document, for the manifest; without the density curve if that is the sensor's.
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
    /// The file is not text.
    #[error("{path:?} is not text: invalid UTF-8 at byte {byte_offset}")]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first bad byte, counted from 0.
        byte_offset: usize,
    },
    /// The file is not TOML.
    #[error("{path:?}, line {line}: {problem}")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
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
    #[error("{path:?}, line {line}: {key}{problem}")]
    Value {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The parameter with the tables it is in.
        key: String,
        /// What is wrong with it, as a continuation.
        problem: String,
    },
}

/// All parameters there are, with the values they have unless overridden.
fn shipped() -> Table {
    let parse = |text: &str| text.parse::<Table>().expect("the embedded files are tested");
    let mut all = parse(PARAMS_TOML);
    all.insert("matching".to_owned(), Value::Table(parse(MATCHING_TOML)));
    all.insert("hierarchical".to_owned(), Value::Table(HierarchicalParams::paper_table()));
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
        let bytes =
            std::fs::read(path).map_err(|source| ConfigError::Io { path: path.to_owned(), source })?;
        let text = String::from_utf8(bytes).map_err(|error| ConfigError::NotText {
            path: path.to_owned(),
            byte_offset: error.utf8_error().valid_up_to(),
        })?;
        Self::resolve(&text, path)
    }

    /// The same for scans of `sensor`, whose density curve takes the place of the paper's; `None` if none comes with the
    /// detector. A curve that the file gives stays.
    pub fn for_sensor(&self, sensor: &str) -> Option<Self> {
        let mut config = self.clone();
        if !self.gives_density_curve() {
            config.hierarchical.density_weighting.curve = DensityCurve::shipped(sensor)?;
        }
        Some(config)
    }

    fn gives_density_curve(&self) -> bool {
        let weighting = self.resolved["hierarchical"].get("density_weighting");
        weighting.is_some_and(|it| it.get("curve").is_some())
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
        let source = OverrideSource { path, text: overrides };
        let values = source.parse()?;
        let mut resolved = shipped();
        let gives_curve = values.get("hierarchical").and_then(|it| it.get("density_weighting")?.get("curve"));
        let gives_curve = gives_curve.is_some();
        source.apply(&mut resolved, values, &mut Vec::new())?;
        let table = |name: &str| resolved[name].as_table().cloned().unwrap_or_default();
        let (hierarchical, matching) = (table("hierarchical").to_string(), table("matching").to_string());
        let of_baselines =
            resolved.iter().filter(|(name, _)| !["matching", "hierarchical"].contains(&name.as_str()));
        let baselines: Table = of_baselines.map(|(name, value)| (name.clone(), value.clone())).collect();
        let baselines = baselines.to_string();
        if !gives_curve
            && let Some(Value::Table(weighting)) = resolved["hierarchical"].get_mut("density_weighting")
        {
            weighting.remove("curve");
        }
        Ok(Self {
            hierarchical: HierarchicalParams::from_toml(&hierarchical)
                .map_err(|error| source.value_error(&error, Some("hierarchical"), &hierarchical))?,
            baselines: BaselineParams::from_toml(&baselines)
                .map_err(|error| source.value_error(&error, None, &baselines))?,
            matching: matching_from(&matching)
                .map_err(|error| source.value_error(&error, Some("matching"), &matching))?,
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
    fn parse(&self) -> Result<Table, ConfigError> {
        self.text.parse().map_err(|error: toml::de::Error| ConfigError::Syntax {
            path: self.path.to_owned(),
            line: self.line_at(error.span().map_or(0, |span| span.start)),
            problem: error.message().to_owned(),
        })
    }

    /// Says where in this document the value stands that `error` complains about in the resolved `document`, whose
    /// parameters are those of the table `parent`, or of several tables.
    fn value_error(&self, error: &ParamsError, parent: Option<&str>, document: &str) -> ConfigError {
        let (names, problem) = match error {
            ParamsError::OutOfRange { name, value, allowed } => {
                let names = name.split('.').map(str::to_owned).collect();
                (names, format!(" = {value} is outside of {allowed}"))
            }
            ParamsError::Syntax(error) => {
                let offset = error.span().map_or(0, |span| span.start);
                let parsed = DeTable::parse(document).expect("the document was written from values");
                let names = key_at(parsed.get_ref(), offset).unwrap_or_default();
                (names, format!(": {}", error.message()))
            }
        };
        let mut keys: Vec<String> = parent.map(str::to_owned).into_iter().collect();
        keys.extend(names);
        let (line, key) = (self.line_of(&keys), keys.join("."));
        ConfigError::Value { path: self.path.to_owned(), line, key, problem }
    }

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
        self.line_at(offset)
    }

    fn line_at(&self, byte_offset: usize) -> usize {
        let before = self.text.as_bytes().iter().take(byte_offset);
        1 + before.filter(|&&byte| byte == b'\n').count()
    }
}

/// The names of the value at this place of the document of `table`, from the outermost in.
fn key_at(table: &DeTable<'_>, byte_offset: usize) -> Option<Vec<String>> {
    table.iter().find_map(|(key, value)| {
        let mut keys = vec![key.get_ref().to_string()];
        match value.get_ref().as_table() {
            Some(inner) => keys.extend(key_at(inner, byte_offset)?),
            None if value.span().contains(&byte_offset) => {}
            None => return None,
        }
        Some(keys)
    })
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
    within("min_iou", table.min_iou, 0.01, 1.0, "0.01 to 1")?;
    within("max_centre_distance_m", table.max_centre_distance_m, 0.01, 100.0, "0.01 to 100 m")?;
    within("max_range_m", table.max_range_m, 1.0, 1000.0, "1 to 1000 m")?;
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

    #[test]
    fn the_density_curve_is_that_of_the_sensor_unless_the_file_gives_one() {
        let peak = |it: &RunConfig| it.hierarchical.density_weighting.curve.peak_points_per_m2;
        let of = |sensor: &str| DensityCurve::shipped(sensor).unwrap().peak_points_per_m2;
        let config = resolve("hierarchical.density_weighting.enabled = false").unwrap();
        assert_eq!(peak(&config.for_sensor("vlp-16").unwrap()), of("vlp-16"));
        assert_eq!(config.resolved["hierarchical"]["density_weighting"].get("curve"), None);
        assert_eq!(config.for_sensor("mine.toml"), None);
        let given = DensityCurve::shipped("os1-128").unwrap().to_toml();
        let config = resolve(&given).unwrap();
        for sensor in ["vlp-16", "mine.toml"] {
            assert_eq!(peak(&config.for_sensor(sensor).unwrap()), of("os1-128"));
        }
        let resolved = &config.resolved["hierarchical"]["density_weighting"]["curve"]["sensor"];
        assert_eq!(resolved.as_str(), Some("os1-128"));
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
    }

    #[test]
    fn what_cannot_be_worked_with_is_refused_with_its_line() {
        check_refused(
            "# mine\n[matching]\nmin_iou = 0.0",
            "\"mine.toml\", line 3: matching.min_iou = 0 is outside of 0.01 to 1",
        );
        check_refused(
            "[matching]\nmin_points = -1",
            "line 2: matching.min_points: invalid value: integer `-1`",
        );
        check_refused(
            "\n[hierarchical.grid]\ncell_size_m = 1.0\nxi = 9",
            "line 4: hierarchical.grid.xi = 9 is outside of 1 to 8",
        );
        check_refused(
            "hierarchical.grid.xi = -3",
            "line 1: hierarchical.grid.xi: invalid value: integer `-3`, expected u32",
        );
        check_refused("kd_tree.foreground = \"blue\"", "line 1: kd_tree.foreground: unknown variant `blue`");
        check_refused("[pca.grid]\ncell_size_m = 0", "line 2: pca.grid.cell_size_m = 0 is outside of");
    }

    #[test]
    fn what_is_not_toml_is_refused_with_its_line() {
        check_refused("# mine\n[kd_tree", "\"mine.toml\", line 2: unclosed table");
    }

    #[test]
    fn the_chosen_criterion_keeps_the_gate_of_the_file() {
        let mut config =
            resolve("[matching]\ncriterion = \"centre\"\nmin_iou = 0.7\nmax_centre_distance_m = 1").unwrap();
        assert_eq!(config.matching.criterion, Criterion::Centre { max_distance_m: 1.0 });
        config.choose_criterion(Criterion::POINTS);
        assert_eq!(config.matching.criterion, Criterion::Points { min_iou: 0.7 });
        assert_eq!(config.resolved["matching"]["criterion"].as_str(), Some("points"));
        config.choose_criterion(Criterion::CENTRE);
        assert_eq!(config.matching.criterion, Criterion::Centre { max_distance_m: 1.0 });
        assert_eq!(config.resolved["matching"]["criterion"].as_str(), Some("centre"));
    }
}
