//! How much worse a number may become before a gate closes: a TOML file of the repository.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::metric::{Direction, Metric};

/// What is gated, and how tightly.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerances {
    /// Rules about what is deterministic; the first that is about a metric, a task and a slice decides.
    pub quality: Vec<QualityRule>,
    /// The rule about times; without it they are not gated.
    pub speed: Option<SpeedRule>,
}

/// How much worse some metrics may become.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QualityRule {
    /// Ids of metrics.
    pub metrics: Vec<String>,
    /// Names of slices; a name that ends in `*` stands for all that begin so.
    pub slices: Vec<String>,
    /// Names of tasks; all, if left out.
    pub tasks: Option<Vec<String>>,
    /// In the unit of the metric.
    pub absolute: f64,
    /// As a share of the baseline's value.
    pub relative: f64,
}

/// How much slower detectors may become, beside another detector of the same run.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedRule {
    /// The detector that times are divided by.
    pub reference: String,
    /// As a share of the baseline's ratio.
    pub relative: f64,
}

/// Why a file gives no tolerances.
#[derive(Debug, thiserror::Error)]
pub enum TolerancesError {
    /// It cannot be read.
    #[error("cannot read the tolerances {path:?}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// It is not the TOML it should be.
    #[error("bad tolerances {path:?}: {source}")]
    Toml {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: Box<toml::de::Error>,
    },
    /// It asks for what cannot be gated.
    #[error("bad tolerances {path:?}: {problem}")]
    Rule {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
}

impl Tolerances {
    /// Reads tolerances.
    ///
    /// # Errors
    ///
    /// [`TolerancesError`] if the file cannot be read, has unknown names, names a metric that does not exist or cannot be gated,
    /// or has a tolerance that is no number or negative.
    pub fn read(path: &Path) -> Result<Self, TolerancesError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| TolerancesError::Read { path: path.to_path_buf(), source })?;
        let tolerances: Self = toml::from_str(&text)
            .map_err(|source| TolerancesError::Toml { path: path.to_path_buf(), source: source.into() })?;
        match tolerances.problem() {
            Some(problem) => Err(TolerancesError::Rule { path: path.to_path_buf(), problem }),
            None => Ok(tolerances),
        }
    }

    fn problem(&self) -> Option<String> {
        let of_rules = self.quality.iter().flat_map(|rule| {
            let of_metrics = rule.metrics.iter().map(|id| match Metric::from_id(id) {
                None => Some(format!("there is no metric {id:?}")),
                Some(metric) if metric.is_time() => {
                    Some(format!("{id:?} is another in every run; times are gated by [speed]"))
                }
                Some(metric) if metric.direction() == Direction::Neither => {
                    Some(format!("{id:?} has no better way"))
                }
                Some(_) => None,
            });
            of_metrics.chain([rule.absolute, rule.relative].map(bad_tolerance)).flatten()
        });
        let of_speed = self.speed.iter().filter_map(|it| bad_tolerance(it.relative));
        of_rules.chain(of_speed).next()
    }

    /// How much worse `metric` may become from `before`; `None` if it is not gated.
    pub fn of(&self, metric: &Metric, task: &str, slice: &str, before: f64) -> Option<f64> {
        let id = metric.id();
        let rule = self.quality.iter().find(|rule| {
            rule.metrics.contains(&id)
                && rule.slices.iter().any(|it| is_meant(it, slice))
                && rule.tasks.as_ref().is_none_or(|tasks| tasks.iter().any(|it| it == task))
        })?;
        Some(rule.absolute.max(rule.relative * before.abs()))
    }

    /// All metrics that some rule is about, in the order of a report.
    pub fn metrics(&self) -> Vec<Metric> {
        let ids = self.quality.iter().flat_map(|it| &it.metrics);
        let mut metrics: Vec<Metric> = ids.filter_map(|id| Metric::from_id(id)).collect();
        metrics.sort();
        metrics.dedup();
        metrics
    }
}

fn is_meant(pattern: &str, slice: &str) -> bool {
    pattern.strip_suffix('*').map_or(pattern == slice, |beginning| slice.starts_with(beginning))
}

fn bad_tolerance(tolerance: f64) -> Option<String> {
    let is_good = tolerance.is_finite() && tolerance >= 0.0;
    (!is_good).then(|| format!("{tolerance} is no tolerance"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOML: &str = r#"
        [[quality]]
        metrics = ["recall"]
        slices = ["class/*"]
        tasks = ["vehicles"]
        absolute = 0.05
        relative = 0.0

        [[quality]]
        metrics = ["f_rate", "recall"]
        slices = ["all", "class/*"]
        absolute = 0.01
        relative = 0.1

        [speed]
        reference = "kd-tree"
        relative = 0.5
    "#;

    fn read(text: &str) -> Result<Tolerances, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tolerances.toml");
        std::fs::write(&path, text).unwrap();
        Tolerances::read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn the_first_rule_that_is_about_it_decides() {
        let tolerances = read(TOML).unwrap();
        let of = |metric: &Metric, task, slice| tolerances.of(metric, task, slice, 0.5);
        assert_eq!(of(&Metric::Recall, "vehicles", "class/car"), Some(0.05));
        assert_eq!(of(&Metric::Recall, "objects", "class/car"), Some(0.05), "a tenth of a half");
        assert_eq!(tolerances.of(&Metric::Recall, "objects", "class/car", 0.02), Some(0.01));
        assert_eq!(of(&Metric::Recall, "objects", "range/0-15"), None);
        assert_eq!(of(&Metric::Precision, "objects", "all"), None);
        assert_eq!(tolerances.metrics(), [Metric::Recall, Metric::FRate]);
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, expected: &str) {
        assert!(TOML.contains(from));
        let error = read(&TOML.replacen(from, to, 1)).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }

    #[test]
    fn what_cannot_be_gated_is_refused() {
        check_refused("\"f_rate\"", "\"f_rat\"", "there is no metric \"f_rat\"");
        check_refused("\"f_rate\"", "\"latency_p50_ms\"", "times are gated by [speed]");
        check_refused("\"f_rate\"", "\"no\"", "has no better way");
        check_refused("absolute = 0.05", "absolute = -0.05", "-0.05 is no tolerance");
        check_refused("absolute = 0.05", "absolut = 0.05", "unknown field `absolut`");
        check_refused("relative = 0.5", "relative = nan", "NaN is no tolerance");
    }
}
