//! How much worse a number may become before a gate closes: a TOML file of the repository.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::verdicts::suggestion::did_you_mean;
use crate::vocabulary::metric::{Direction, Metric, SPEED_REFERENCE};
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// What is gated, and how tightly.
#[derive(Debug, Clone, PartialEq)]
pub struct Tolerances {
    /// Rules about what is deterministic; the first that is about a number decides.
    pub quality: Vec<QualityRule>,
    /// The rule about times; without it they are not gated.
    pub speed: Option<SpeedRule>,
}

/// How much worse some metrics may become.
#[derive(Debug, Clone, PartialEq)]
pub struct QualityRule {
    /// The metrics.
    pub metrics: Vec<Metric>,
    /// Names of slices; a name that ends in `*` stands for all that begin so.
    pub slices: Vec<String>,
    /// The tasks; all, if left out.
    pub tasks: Option<Vec<Task>>,
    /// Names of detectors; all, if left out.
    pub detectors: Option<Vec<String>>,
    /// In the unit of the metric.
    pub absolute: f64,
    /// As a share of the baseline's value.
    pub relative: f64,
}

/// How much slower detectors may become, beside the reference that is timed in turns with them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedRule {
    /// What times are divided by: [`SPEED_REFERENCE`].
    pub reference: String,
    /// Of which detectors; of all if left out.
    pub detectors: Option<Vec<String>>,
    /// As a share of the baseline's ratio.
    pub relative: f64,
}

/// What a number is of that may be gated.
#[derive(Debug, Clone, Copy)]
pub struct GatedPlace<'a> {
    /// The task.
    pub task: Task,
    /// Name of the detector.
    pub detector: &'a str,
    /// The slice.
    pub slice: Slice,
}

/// The file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TolerancesRecord {
    quality: Vec<QualityRecord>,
    speed: Option<SpeedRule>,
}

/// A rule as it is written: with names, of which there may be none such.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct QualityRecord {
    metrics: Vec<String>,
    slices: Vec<String>,
    tasks: Option<Vec<String>>,
    detectors: Option<Vec<String>>,
    absolute: f64,
    relative: f64,
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
    #[error("bad tolerances {path:?}: {problem}")]
    Toml {
        /// The file.
        path: PathBuf,
        /// Where and why.
        problem: Box<toml::de::Error>,
    },
    /// It asks for what cannot be gated.
    #[error("bad tolerances {path:?}: {problems}")]
    Rules {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problems: RuleProblems,
    },
}

/// Everything that is wrong with the rules of a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", .0.join("; "))]
pub struct RuleProblems(pub Vec<String>);

impl RuleProblems {
    /// Nothing, or all of these.
    ///
    /// # Errors
    ///
    /// The problems, if there are any.
    pub fn check(problems: impl IntoIterator<Item = String>) -> Result<(), Self> {
        let problems: Vec<String> = problems.into_iter().collect();
        if problems.is_empty() { Ok(()) } else { Err(Self(problems)) }
    }
}

impl Tolerances {
    /// Reads tolerances.
    ///
    /// # Errors
    ///
    /// [`TolerancesError`] if the file cannot be read, has unknown names, names a metric that does not exist or cannot be gated,
    /// or has a tolerance that lets everything pass; with everything that is wrong.
    pub fn read(path: &Path) -> Result<Self, TolerancesError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| TolerancesError::Read { path: path.to_path_buf(), source })?;
        let record: TolerancesRecord = toml::from_str(&text)
            .map_err(|problem| TolerancesError::Toml { path: path.to_path_buf(), problem: problem.into() })?;
        let rules = |problems| TolerancesError::Rules { path: path.to_path_buf(), problems };
        RuleProblems::check(record.problems()).map_err(rules)?;
        let quality = record.quality.into_iter().map(QualityRule::from).collect();
        Ok(Self { quality, speed: record.speed })
    }

    /// Place of the rule that decides about `metric` of `place`; `None` if it is not gated.
    pub fn rule_about(&self, metric: &Metric, place: GatedPlace<'_>) -> Option<usize> {
        self.quality.iter().position(|rule| rule.metrics.contains(metric) && rule.is_about(place))
    }

    /// All metrics that some rule is about, in the order of a report.
    pub fn metrics(&self) -> Vec<Metric> {
        let mut metrics: Vec<Metric> = self.quality.iter().flat_map(|it| &it.metrics).cloned().collect();
        metrics.sort();
        metrics.dedup();
        metrics
    }
}

/// What a rule is called where something is wrong with it.
pub fn rule_name(rule_idx: usize) -> String {
    format!("[[quality]] {}", rule_idx + 1)
}

impl QualityRule {
    /// How much worse a number may become from `before`.
    pub fn tolerance(&self, before: f64) -> f64 {
        self.absolute.max(self.relative * before.abs())
    }

    /// Whether it is about numbers of `place`.
    pub fn is_about(&self, place: GatedPlace<'_>) -> bool {
        self.slices.iter().any(|it| is_meant(it, place.slice))
            && self.tasks.as_ref().is_none_or(|it| it.contains(&place.task))
            && self.detectors.as_ref().is_none_or(|it| it.iter().any(|it| it == place.detector))
    }

    /// Whether it names the slice and the task of `place`, so that a number is expected there.
    pub fn names(&self, place: GatedPlace<'_>) -> bool {
        let slice = place.slice.name();
        self.slices.contains(&slice) && self.tasks.as_ref().is_some_and(|it| it.contains(&place.task))
    }
}

impl From<QualityRecord> for QualityRule {
    /// Of a record without problems.
    fn from(record: QualityRecord) -> Self {
        let QualityRecord { metrics, slices, tasks, detectors, absolute, relative } = record;
        let metrics = metrics.iter().filter_map(|id| Metric::from_id(id)).collect();
        let tasks = tasks.map(|names| names.iter().filter_map(|name| Task::from_name(name)).collect());
        Self { metrics, slices, tasks, detectors, absolute, relative }
    }
}

impl TolerancesRecord {
    fn problems(&self) -> Vec<String> {
        let of_rules = self.quality.iter().enumerate().flat_map(|(rule_idx, rule)| {
            rule.problems().into_iter().map(move |problem| format!("{}: {problem}", rule_name(rule_idx)))
        });
        let of_speed = self.speed.iter().flat_map(SpeedRule::problems);
        of_rules.chain(of_speed.map(|problem| format!("[speed]: {problem}"))).collect()
    }
}

impl QualityRecord {
    fn problems(&self) -> Vec<String> {
        let mut problems: Vec<String> = self.metrics.iter().filter_map(|id| metric_problem(id)).collect();
        problems.extend(self.tasks.iter().flatten().filter_map(|name| task_problem(name)));
        let lists = [
            ("metrics", Some(&self.metrics)),
            ("slices", Some(&self.slices)),
            ("tasks", self.tasks.as_ref()),
            ("detectors", self.detectors.as_ref()),
        ];
        let empty = lists.into_iter().filter(|(_, names)| names.is_some_and(Vec::is_empty));
        problems.extend(empty.map(|(list, _)| format!("{list} is empty")));
        problems.extend(share_problem("relative", self.relative));
        problems.extend(self.absolute_problem());
        problems
    }

    /// More than the least of the metrics' limits lets everything pass.
    fn absolute_problem(&self) -> Option<String> {
        let absolute = self.absolute;
        if !absolute.is_finite() || absolute < 0.0 {
            return Some(format!("absolute = {absolute} is not a tolerance; it must be 0 or more"));
        }
        let units = self.metrics.iter().filter_map(|id| Some(Metric::from_id(id)?.unit()));
        let limits = units.filter_map(|unit| Some((unit, greatest_absolute(unit)?)));
        let (unit, limit) = limits.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (absolute > limit).then(|| {
            let unit =
                if unit == "ratio" { "of a rate, where 1 is 100 %".to_owned() } else { unit.to_owned() };
            format!("absolute = {absolute} would pass nearly everything; the most is {limit} {unit}")
        })
    }
}

impl SpeedRule {
    fn problems(&self) -> Vec<String> {
        let reference = &self.reference;
        let unknown = (reference != SPEED_REFERENCE)
            .then(|| format!("the reference for times is {SPEED_REFERENCE:?}, not {reference:?}"));
        let nobody = self.detectors.as_ref().is_some_and(Vec::is_empty);
        let empty = nobody.then(|| "detectors is empty".to_owned());
        unknown.into_iter().chain(empty).chain(share_problem("relative", self.relative)).collect()
    }

    /// Whether the times of `detector` are held to this.
    pub fn is_about(&self, detector: &str) -> bool {
        self.detectors.as_ref().is_none_or(|it| it.iter().any(|name| name == detector))
    }
}

/// Whether `pattern` stands for `slice`: it is its name, or a beginning of it and a `*`.
pub fn is_meant(pattern: &str, slice: Slice) -> bool {
    let name = slice.name();
    pattern.strip_suffix('*').map_or(pattern == name, |beginning| name.starts_with(beginning))
}

fn task_problem(name: &str) -> Option<String> {
    let known = Task::ALL.map(|it| it.name().to_owned());
    Task::from_name(name)
        .is_none()
        .then(|| format!("there is no task {name:?}{}", did_you_mean(name, known.iter())))
}

fn metric_problem(id: &str) -> Option<String> {
    let Some(metric) = Metric::from_id(id) else {
        let known = Metric::gated().map(|it| it.id()).collect::<Vec<_>>();
        return Some(format!("there is no metric {id:?}{}", did_you_mean(id, known.iter())));
    };
    if metric.is_time() {
        Some(format!("{id:?} changes with every run; check times with [speed]"))
    } else if metric.direction() == Direction::Neither {
        Some(format!("{id:?} has no direction that is better"))
    } else if matches!(metric, Metric::AveragePrecision(_)) {
        Some(format!("{id:?} has no interval, so a loss may be chance; use f_rate, precision and recall"))
    } else {
        None
    }
}

/// A tolerance that is a share of a number has to be less than all of it.
fn share_problem(name: &str, share: f64) -> Option<String> {
    if !share.is_finite() || share < 0.0 {
        Some(format!("{name} = {share} is not a tolerance; it must be 0 or more"))
    } else if share >= 1.0 {
        let percent = 100.0 * share;
        Some(format!("{name} = {share} tolerates {percent} %; it must be less than 1, which is 100 %"))
    } else {
        None
    }
}

/// The most that may be tolerated of a metric in `unit`: half of what a rate, or an angle between boxes, can be; 2 m, where the
/// criterion *centre* no longer takes two boxes for one object's; a nat, a choice of nearly three. Counts have no limit.
fn greatest_absolute(unit: &str) -> Option<f64> {
    match unit {
        "ratio" => Some(0.5),
        "m" => Some(2.0),
        "deg" => Some(45.0),
        "nats" => Some(1.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOML: &str = r#"
        [[quality]]
        metrics = ["recall"]
        slices = ["class/*"]
        tasks = ["vehicles"]
        detectors = ["pca", "kd-tree"]
        absolute = 0.05
        relative = 0.0

        [[quality]]
        metrics = ["f_rate", "recall"]
        slices = ["all", "class/*"]
        absolute = 0.01
        relative = 0.1

        [speed]
        reference = "grid-write"
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
        let about = |metric: &Metric, task, detector, slice: &str| {
            let slice = Slice::from_name(slice).unwrap();
            tolerances.rule_about(metric, GatedPlace { task, detector, slice })
        };
        assert_eq!(about(&Metric::Recall, Task::Vehicles, "pca", "class/car"), Some(0));
        assert_eq!(about(&Metric::Recall, Task::Objects, "pca", "class/car"), Some(1));
        assert_eq!(about(&Metric::Recall, Task::Vehicles, "hierarchical", "class/car"), Some(1));
        assert_eq!(about(&Metric::Recall, Task::Objects, "pca", "range/0-15"), None);
        assert_eq!(about(&Metric::Precision, Task::Objects, "pca", "all"), None);
        assert_eq!(tolerances.metrics(), [Metric::Recall, Metric::FRate]);
        assert_eq!([0.5, 0.02].map(|before| tolerances.quality[1].tolerance(before)), [0.05, 0.01]);
    }

    #[test]
    fn a_number_is_expected_where_slice_and_task_are_named() {
        let tolerances = read(&TOML.replacen("class/*", "class/car", 1)).unwrap();
        let place =
            |slice, task| GatedPlace { task, detector: "pca", slice: Slice::from_name(slice).unwrap() };
        let names = |rule: usize, slice, task| tolerances.quality[rule].names(place(slice, task));
        assert!(names(0, "class/car", Task::Vehicles) && !names(0, "class/van", Task::Vehicles));
        assert!(!names(1, "all", Task::Vehicles) && !names(1, "class/car", Task::Vehicles));
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, expected: &str) {
        assert!(TOML.contains(from));
        let error = read(&TOML.replacen(from, to, 1)).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }

    #[test]
    fn what_cannot_be_gated_is_refused() {
        check_refused(
            "\"f_rate\"",
            "\"f_rat\"",
            "[[quality]] 2: there is no metric \"f_rat\"; did you mean \"f_rate\"?",
        );
        check_refused("\"f_rate\"", "\"latency_p50_ms\"", "changes with every run; check times with [speed]");
        check_refused(
            "\"f_rate\"",
            "\"time_over_reference\"",
            "changes with every run; check times with [speed]",
        );
        check_refused("\"f_rate\"", "\"no\"", "has no direction that is better");
        check_refused("\"f_rate\"", "\"ap_r40\"", "has no interval");
        check_refused(
            "[\"vehicles\"]",
            "[\"vehicle\"]",
            "[[quality]] 1: there is no task \"vehicle\"; did you mean \"vehicles\"?",
        );
        check_refused("absolute = 0.05", "absolut = 0.05", "unknown field `absolut`");
        check_refused("[\"class/*\"]", "[]", "[[quality]] 1: slices is empty");
        check_refused("[\"pca\", \"kd-tree\"]", "[]", "[[quality]] 1: detectors is empty");
        check_refused(
            "grid-write",
            "kd-tree",
            "[speed]: the reference for times is \"grid-write\", not \"kd-tree\"",
        );
    }

    #[test]
    fn tolerances_that_let_everything_pass_are_refused() {
        for absurd in ["-0.05", "nan", "inf"] {
            check_refused("absolute = 0.05", &format!("absolute = {absurd}"), "is not a tolerance");
            check_refused("relative = 0.1", &format!("relative = {absurd}"), "is not a tolerance");
            check_refused("relative = 0.5", &format!("relative = {absurd}"), "is not a tolerance");
        }
        check_refused(
            "relative = 0.1",
            "relative = 5.0",
            "relative = 5 tolerates 500 %; it must be less than 1",
        );
        check_refused("relative = 0.5", "relative = 1.0", "[speed]: relative = 1 tolerates 100 %");
        check_refused("relative = 0.5", "relative = 0.5\ndetectors = []", "[speed]: detectors is empty");
        check_refused("absolute = 0.05", "absolute = 0.51", "the most is 0.5 of a rate, where 1 is 100 %");
        let of_boxes = |absolute: f64| {
            let text = TOML.replacen("[\"recall\"]", "[\"box_center_error_m\", \"box_yaw_error_deg\"]", 1);
            read(&text.replacen("absolute = 0.05", &format!("absolute = {absolute}"), 1))
        };
        assert!(of_boxes(2.0).is_ok());
        assert!(of_boxes(2.1).unwrap_err().contains("the most is 2 m"));
    }

    #[test]
    fn all_that_is_wrong_is_said_at_once() {
        let text = TOML.replace("\"recall\"", "\"recal\"").replace("relative = 0.5", "relative = 2.0");
        let error = read(&text).unwrap_err();
        for problem in [
            "[[quality]] 1: there is no metric \"recal\"",
            "[[quality]] 2: there is no metric \"recal\"",
            "200 %",
        ] {
            assert!(error.contains(problem), "{error}");
        }
    }
}
