//! A file of tolerances, read to its end whatever problems it has.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::files::regular_file::read_settings_text;
use crate::verdicts::rule_problems::{RulePosition, RuleProblem, RuleTable};
use crate::verdicts::suggestion::did_you_mean;
use crate::verdicts::tolerances::{DriftRule, Lateness, Origin, Rule, StreamRule, Tolerances};
use crate::vocabulary::class::AnnotationClass;
use crate::vocabulary::criterion::CriterionKind;
use crate::vocabulary::metric::{Direction, Metric, PartialMetric, SPEED_REFERENCE};
use crate::vocabulary::protocol::Protocol;

use crate::vocabulary::task::Task;

const TOP_FIELDS: [&str; 5] = ["drift", "quality", "protocol", "streaming", "speed"];
const STREAM_FIELDS: [&str; 6] = ["criterion", "latency_ms", "tasks", "detectors", "absolute", "relative"];
const PROTOCOL_FIELDS: [&str; 6] = ["protocol", "metrics", "classes", "detectors", "absolute", "relative"];
const QUALITY_FIELDS: [&str; 6] = ["metrics", "slices", "tasks", "detectors", "absolute", "relative"];
const SPEED_FIELDS: [&str; 3] = ["reference", "detectors", "relative"];

/// Why a file gives no tolerances.
#[derive(Debug, thiserror::Error)]
pub enum TolerancesError {
    /// It cannot be read.
    #[error("cannot read the tolerances {path:?}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// It is not TOML.
    #[error("bad tolerances {path:?}: {problem}")]
    Toml {
        /// The file.
        path: PathBuf,
        /// Where and why.
        problem: Box<toml::de::Error>,
    },
}

impl Tolerances {
    /// Reads tolerances. The problems of their rules are among [`Self::problems`].
    ///
    /// # Errors
    ///
    /// [`TolerancesError`] if the file cannot be read or is not TOML.
    pub fn read(path: &Path) -> Result<Self, TolerancesError> {
        let text = read_settings_text(path)
            .map_err(|source| TolerancesError::Read { path: path.to_path_buf(), source })?;
        Self::parse(&text, Origin::File(path.to_path_buf()))
            .map_err(|problem| TolerancesError::Toml { path: path.to_path_buf(), problem: problem.into() })
    }

    /// The tolerances that `text` has.
    pub(super) fn parse(text: &str, origin: Origin) -> Result<Self, toml::de::Error> {
        let table = DeTable::parse(text)?;
        let mut top = Section::new(text, RuleTable::Top, 0, Some(table.get_ref()));
        let drift = drift_rule(&mut top);
        let of_all_steps = top.sizes_of_all_steps();
        let has_others = !of_all_steps.is_empty() || top.fields.contains_key("streaming");
        let quality = if has_others { top.take("quality") } else { top.require("quality") };
        let mut quality = top.rules("quality", quality, RuleTable::Quality, quality_rule);
        quality.extend(of_all_steps);
        let protocols = top.take("protocol");
        let protocols = top.rules("protocol", protocols, RuleTable::Protocol, protocol_rule);
        let protocols = protocols.into_iter().flatten().collect();
        let streams = top.take("streaming");
        let streams = top.rules("streaming", streams, RuleTable::Streaming, stream_rule);
        let streams = streams.into_iter().flatten().collect();
        let speed = top.take("speed").and_then(|it| {
            top.expect("a table", it, it.get_ref().as_table())?;
            Some(speed_rule(Section::of_value(text, RuleTable::Speed, it), &mut top.problems))
        });
        let problems = top.finish(&TOP_FIELDS);
        Ok(Self { origin, quality, protocols, streams, speed, drift, problems })
    }
}

/// A run whose results changed fails unless the file says otherwise.
fn drift_rule(top: &mut Section<'_>) -> DriftRule {
    let name = top.fields.contains_key("drift").then(|| {
        let known = |it: &str| {
            DriftRule::from_name(it)
                .is_none()
                .then(|| format!("drift = {it:?} means nothing; it is \"fail\" or \"warn\""))
        };
        top.text("drift", known)
    });
    name.flatten().and_then(|it| DriftRule::from_name(&it)).unwrap_or(DriftRule::Fail)
}

/// The rule of a table; `None` if it names no protocol. Wrong fields are left out of it, and all are among `problems`.
fn protocol_rule(mut section: Section<'_>, problems: &mut Vec<RuleProblem>) -> Option<Rule> {
    section.refuse_missing(&["metrics", "classes"]);
    let protocol = section.text("protocol", |it| unknown("protocol", it, &Protocol::ALL.map(Protocol::name)));
    let rule = Rule {
        line: Some(section.line),
        metrics: section.names("metrics", |_| None).unwrap_or_default(),
        parts: section.names("classes", |_| None).unwrap_or_default(),
        detectors: section.names("detectors", |_| None),
        absolute: section.size("absolute", |size| absolute_problem(size, &[])),
        relative: section.size("relative", |size| share_problem("relative", size)),
        tasks: None,
    };
    problems.extend(section.finish(&PROTOCOL_FIELDS));
    let protocol = Protocol::from_name(&protocol?)?;
    Some(Rule { tasks: Some(vec![protocol.name().to_owned()]), ..rule })
}

/// The rule of a table; `None` if it names no criterion. Wrong fields are left out of it, and all are among `problems`.
fn stream_rule(mut section: Section<'_>, problems: &mut Vec<RuleProblem>) -> Option<StreamRule> {
    let by_boxes: Vec<&str> = CriterionKind::ALL
        .into_iter()
        .filter(|it| *it != CriterionKind::Points)
        .map(CriterionKind::name)
        .collect();
    let criterion = section.text("criterion", |it| unknown("criterion by boxes", it, &by_boxes));
    let lateness = if section.fields.contains_key("latency_ms") {
        Lateness::Fixed(section.size("latency_ms", latency_problem))
    } else {
        Lateness::Measured
    };
    let absolute = section.size("absolute", |size| absolute_problem(size, &[Metric::FRate]));
    let rule = Rule {
        line: Some(section.line),
        tasks: section.names("tasks", unknown_task),
        detectors: section.names("detectors", |_| None),
        relative: section.size("relative", |size| share_problem("relative", size)),
        ..Rule::of_streams(absolute)
    };
    problems.extend(section.finish(&STREAM_FIELDS));
    let criterion = CriterionKind::from_name(&criterion?)?;
    Some(StreamRule { rule, criterion, lateness })
}

fn latency_problem(latency_ms: f64) -> Option<String> {
    let is_time = (0.0..=60_000.0).contains(&latency_ms);
    (!is_time).then(|| format!("latency_ms = {latency_ms} is no time from 0 to 60000 ms"))
}

/// The rule of a table. Wrong fields are left out of it, and are among `problems`.
fn quality_rule(mut section: Section<'_>, problems: &mut Vec<RuleProblem>) -> Rule {
    section.refuse_missing(&["metrics", "slices"]);
    let metrics = section.names("metrics", metric_problem).unwrap_or_default();
    let measured: Vec<Metric> = metrics.iter().filter_map(|it| Metric::from_id(it)).collect();
    let rule = Rule {
        line: Some(section.line),
        metrics,
        parts: section.names("slices", |_| None).unwrap_or_default(),
        tasks: section.names("tasks", unknown_task),
        detectors: section.names("detectors", |_| None),
        absolute: section.size("absolute", |size| absolute_problem(size, &measured)),
        relative: section.size("relative", |size| share_problem("relative", size)),
    };
    problems.extend(section.finish(&QUALITY_FIELDS));
    rule
}

/// The problem of a task that is none: tasks of classes have the names of these.
fn unknown_task(name: &str) -> Option<String> {
    if AnnotationClass::met(name).is_some() {
        None
    } else {
        unknown("task", name, &Task::ALL.map(Task::name))
    }
}

fn speed_rule(mut section: Section<'_>, problems: &mut Vec<RuleProblem>) -> Rule {
    section.text("reference", |it| {
        (it != SPEED_REFERENCE).then(|| format!("the reference for times is {SPEED_REFERENCE:?}, not {it:?}"))
    });
    let (line, detectors) = (Some(section.line), section.names("detectors", |_| None));
    let relative = section.size("relative", |size| share_problem("relative", size));
    problems.extend(section.finish(&SPEED_FIELDS));
    Rule { line, detectors, ..Rule::of_times(relative) }
}

/// A table of the file, whose fields are taken out one by one.
struct Section<'a> {
    text: &'a str,
    table: RuleTable,
    line: usize,
    // Those that were not taken yet, each with its line.
    fields: BTreeMap<&'a str, (usize, &'a Spanned<DeValue<'a>>)>,
    problems: Vec<RuleProblem>,
}

impl<'a> Section<'a> {
    fn new(text: &'a str, table: RuleTable, start: usize, fields: Option<&'a DeTable<'a>>) -> Self {
        let fields = fields.into_iter().flatten().map(|(name, value)| {
            let line = line_of(text, name.span().start);
            (name.get_ref().as_ref(), (line, value))
        });
        Self { text, table, line: line_of(text, start), fields: fields.collect(), problems: Vec::new() }
    }

    /// The section of a value that is a table.
    fn of_value(text: &'a str, table: RuleTable, value: &'a Spanned<DeValue<'a>>) -> Self {
        Self::new(text, table, value.span().start, value.get_ref().as_table())
    }

    fn complain(&mut self, line: usize, what: String) {
        let position = RulePosition { line: Some(line), table: self.table };
        self.problems.push(RuleProblem { position, what });
    }

    /// The rules of a list of tables called `name`, each made by `rule`.
    fn rules<Rule>(
        &mut self,
        name: &str,
        tables: Option<&'a Spanned<DeValue<'a>>>,
        position: fn(usize) -> RuleTable,
        rule: fn(Self, &mut Vec<RuleProblem>) -> Rule,
    ) -> Vec<Rule> {
        let Some(tables) = tables else { return Vec::new() };
        let items = tables.get_ref().as_array();
        let items = items.filter(|it| it.iter().all(|item| item.get_ref().is_table()));
        let tables = self.expect(&format!("a list of tables, each below [[{name}]]"), tables, items);
        let tables = tables.into_iter().flatten().enumerate();
        let rules = tables.map(|(rule_idx, table)| {
            rule(Section::of_value(self.text, position(rule_idx), table), &mut self.problems)
        });
        rules.collect()
    }

    /// Rules for partly seen objects: how much worse each number may be at any step, if the file says so.
    fn sizes_of_all_steps(&mut self) -> Vec<Rule> {
        let metrics = PartialMetric::ALL.map(|it| Metric::Partial(it).id());
        if !metrics.iter().any(|it| self.fields.contains_key(it.as_str())) {
            return Vec::new();
        }
        let rule = |id: String| {
            let problem = |size| {
                let is_share = (0.0..=1.0).contains(&size);
                (!is_share).then(|| format!("{id} = {size} is not within 0 to 1"))
            };
            Rule::of_all_parts(&id, self.size(&id, problem))
        };
        metrics.map(rule).to_vec()
    }

    fn take(&mut self, name: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.fields.remove(name).map(|(_, value)| value)
    }

    fn require(&mut self, name: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.refuse_missing(&[name]);
        self.take(name)
    }

    fn refuse_missing(&mut self, names: &[&str]) {
        for name in names.iter().filter(|it| !self.fields.contains_key(**it)).collect::<Vec<_>>() {
            self.complain(self.line, format!("there is no `{name}`"));
        }
    }

    /// The value that was `found`; if there is none, notes that `value` is not the `expected`.
    fn expect<T>(&mut self, expected: &str, value: &Spanned<DeValue<'_>>, found: Option<T>) -> Option<T> {
        if found.is_none() {
            let (line, written) = (line_of(self.text, value.span().start), &self.text[value.span()]);
            self.complain(line, format!("{written} is not {expected}"));
        }
        found
    }

    /// A list of names without a `problem`; `None` if there is no list.
    fn names(&mut self, name: &str, problem: impl Fn(&str) -> Option<String>) -> Option<Vec<String>> {
        let value = self.take(name)?;
        let line = line_of(self.text, value.span().start);
        let items = value.get_ref().as_array().map(|it| it.iter().map(|item| item.get_ref().as_str()));
        let Some(names) = items.and_then(Iterator::collect::<Option<Vec<&str>>>) else {
            self.complain(line, format!("{name} = {} is not a list of names", &self.text[value.span()]));
            return None;
        };
        if names.is_empty() {
            self.complain(line, format!("{name} is empty"));
        }
        for what in names.iter().filter_map(|it| problem(it)) {
            self.complain(line, what);
        }
        Some(names.iter().filter(|it| problem(it).is_none()).map(|it| (*it).to_owned()).collect())
    }

    fn text(&mut self, name: &str, problem: impl Fn(&str) -> Option<String>) -> Option<String> {
        let value = self.require(name)?;
        let line = line_of(self.text, value.span().start);
        let text = value.get_ref().as_str();
        let what = match text {
            Some(text) => problem(text),
            None => Some(format!("{name} = {} is not a text", &self.text[value.span()])),
        };
        if let Some(what) = what {
            self.complain(line, what);
        }
        text.map(str::to_owned)
    }

    /// A number without a `problem`; 0 if there is none.
    fn size(&mut self, name: &str, problem: impl Fn(f64) -> Option<String>) -> f64 {
        let Some(value) = self.require(name) else { return 0.0 };
        let line = line_of(self.text, value.span().start);
        let what = match number(value.get_ref()) {
            Some(size) => match problem(size) {
                None => return size,
                Some(what) => what,
            },
            None => format!("{name} = {} is not a number", &self.text[value.span()]),
        };
        self.complain(line, what);
        0.0
    }

    /// All problems, with the fields that are left over: only the `known` ones mean something.
    fn finish(mut self, known: &[&str]) -> Vec<RuleProblem> {
        let known: Vec<String> = known.iter().map(|it| (*it).to_owned()).collect();
        for (name, (line, _)) in std::mem::take(&mut self.fields) {
            self.complain(line, format!("unknown field `{name}`{}", did_you_mean(name, known.iter())));
        }
        self.problems
    }
}

/// The line of the byte at `position`, from 1 on.
fn line_of(text: &str, position: usize) -> usize {
    text[..position].matches('\n').count() + 1
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|it| it as f64)
        }
        _ => None,
    }
}

/// The problem that there is no such `what`, if `name` is not known.
fn unknown(what: &str, name: &str, known: &[&str]) -> Option<String> {
    let names: Vec<String> = known.iter().map(|it| (*it).to_owned()).collect();
    (!known.contains(&name))
        .then(|| format!("there is no {what} {name:?}{}", did_you_mean(name, names.iter())))
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

/// The problem of an absolute tolerance: more than the least of the metrics' limits lets everything pass.
fn absolute_problem(absolute: f64, metrics: &[Metric]) -> Option<String> {
    if !absolute.is_finite() || absolute < 0.0 {
        return Some(format!("absolute = {absolute} is not a tolerance; it must be 0 or more"));
    }
    let limits = metrics.iter().filter_map(|it| Some((it.unit(), greatest_absolute(it.unit())?)));
    let (unit, limit) = limits.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (absolute > limit).then(|| {
        let unit = if unit == "ratio" { "of a rate, where 1 is 100 %".to_owned() } else { unit.to_owned() };
        format!("absolute = {absolute} would pass nearly everything; the most is {limit} {unit}")
    })
}

/// The problem of a tolerance that is a share of a number: it has to be less than all of it.
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

/// The most that may be tolerated of a metric in `unit`: half of what a rate, or an angle between boxes, can be; 2 m, where
/// the criterion *centre* no longer takes two boxes for one object's; a nat, a choice of nearly three. Counts have no limit.
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
mod tests;
