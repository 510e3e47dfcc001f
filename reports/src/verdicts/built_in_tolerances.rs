//! Tolerances for a baseline that has none: about exactly the numbers that it has.

use serde::Deserialize;

use crate::numbers::tally::Tally;
use crate::protocols::drawn_scans::DrawnScans;
use crate::protocols::protocol_number::{ALL_CLASSES, ProtocolMetric};
use crate::protocols::protocol_tally::ProtocolQuestion;
use crate::run_folder::run_archive::RunArchive;
use crate::uncertainty::sample::{Draw, Question};
use crate::verdicts::tolerances::{
    DriftRule, Origin, ProtocolRule, QualityRule, SpeedRule, Tolerances, is_meant,
};
use crate::vocabulary::metric::{Metric, SPEED_REFERENCE};
use crate::vocabulary::protocol::Protocol;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

const SIZES: &str = include_str!("built_in_tolerances.toml");

/// How much of each number is tolerated, and what it means.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sizes {
    pub(super) metric: Vec<MetricSize>,
    pub(super) slices: SliceSize,
    pub(super) protocols: ProtocolSize,
    pub(super) speed: SpeedSize,
}

/// Of a metric of everything.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MetricSize {
    id: String,
    pub(super) meaning: String,
    absolute: f64,
    relative: f64,
}

/// Of a metric of slices.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SliceSize {
    metric: String,
    pub(super) meaning: String,
    patterns: Vec<String>,
    absolute: f64,
    relative: f64,
}

/// Of the numbers of all classes together under a protocol of others.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProtocolSize {
    pub(super) meaning: String,
    metrics: Vec<String>,
    absolute: f64,
    relative: f64,
}

/// Of times.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpeedSize {
    pub(super) meaning: String,
    relative: f64,
}

impl Sizes {
    pub(super) fn built_in() -> Self {
        toml::from_str(SIZES).expect("the file is a part of the program and tested")
    }
}

impl MetricSize {
    pub(super) fn metric(&self) -> Metric {
        Metric::from_id(&self.id).expect("the file is a part of the program and tested")
    }
}

impl SliceSize {
    fn metric(&self) -> Metric {
        Metric::from_id(&self.metric).expect("the file is a part of the program and tested")
    }
}

impl Tolerances {
    /// The built-in tolerances for `baseline`: rules about every metric, task and detector that it has a number of, and about its times.
    pub fn built_in(baseline: &RunArchive) -> Self {
        let tally = baseline.tally();
        let numbers = Numbers { draws: tally.undrawn(), tally: &tally };
        let sizes = Sizes::built_in();
        let of_metrics = sizes.metric.iter().flat_map(|it| numbers.rules_about(it));
        let of_slices = numbers.rules_about_slices(&sizes.slices);
        let quality = of_metrics.chain(of_slices).collect();
        let speed = numbers.speed_rule(&sizes.speed);
        let protocols = protocol_rules(baseline, &sizes.protocols);
        Self {
            origin: Origin::BuiltIn,
            quality,
            protocols,
            speed,
            drift: DriftRule::Fail,
            problems: Vec::new(),
        }
    }
}

/// One rule for each protocol that the baseline was evaluated under, about those of `metrics` that it has of all classes together.
fn protocol_rules(baseline: &RunArchive, size: &ProtocolSize) -> Vec<ProtocolRule> {
    let tally = baseline.tally();
    let names = tally.datasets().iter().flat_map(|it| DrawnScans::of(&tally, it).names().to_vec());
    let scans = DrawnScans::undrawn(names.collect());
    let rule = |protocol: Protocol| {
        let of_detectors = tally
            .detectors()
            .iter()
            .filter_map(|detector| baseline.protocols.rows(ProtocolQuestion { protocol, detector }, &scans));
        let known: Vec<ProtocolMetric> = of_detectors.flat_map(|it| it.metrics()).collect();
        let has_it = |id: &&String| known.iter().any(|it| it.class == ALL_CLASSES && it.id == **id);
        let metrics: Vec<String> = size.metrics.iter().filter(has_it).cloned().collect();
        (!metrics.is_empty()).then(|| ProtocolRule {
            line: None,
            protocol,
            metrics,
            classes: vec![ALL_CLASSES.to_owned()],
            detectors: None,
            absolute: size.absolute,
            relative: size.relative,
        })
    };
    baseline.protocols.protocols().into_iter().filter_map(rule).collect()
}

/// The numbers of a run, without their intervals.
struct Numbers<'a> {
    tally: &'a Tally,
    draws: Vec<Draw>,
}

impl Numbers<'_> {
    fn has(&self, metric: &Metric, task: Task, detector: &str, slice: Slice) -> bool {
        let pools = self.tally.pools();
        pools.iter().any(|pool| {
            let question = Question { dataset: pool.extent.name(), task, detector, slice };
            self.tally.sample(&question, &self.draws).is_some_and(|it| it.value(metric).is_some())
        })
    }

    /// The detectors that have `metric` in `task`, of a slice that `pattern` stands for.
    fn detectors(&self, metric: &Metric, task: Task, pattern: &str) -> Vec<String> {
        let has_it = |detector: &&String| {
            let slices = self.tally.slices(task, detector);
            slices.into_iter().any(|it| is_meant(pattern, it) && self.has(metric, task, detector, it))
        };
        self.tally.detectors().iter().filter(has_it).cloned().collect()
    }

    /// One rule for all tasks that the same detectors have it in.
    fn rules_about(&self, size: &MetricSize) -> Vec<QualityRule> {
        let metric = size.metric();
        let of_tasks = self.tally.tasks().iter().map(|&task| (task, self.detectors(&metric, task, "all")));
        let of_tasks: Vec<_> = of_tasks.filter(|(_, detectors)| !detectors.is_empty()).collect();
        let alike = of_tasks.chunk_by(|a, b| a.1 == b.1);
        let rules = alike.map(|tasks| QualityRule {
            line: None,
            metrics: vec![metric.clone()],
            slices: vec![Slice::All.name()],
            tasks: Some(tasks.iter().map(|(task, _)| *task).collect()),
            detectors: Some(tasks[0].1.clone()),
            absolute: size.absolute,
            relative: size.relative,
        });
        rules.collect()
    }

    /// One rule for all tasks that have slices of the same kinds by the same detectors.
    fn rules_about_slices(&self, size: &SliceSize) -> Vec<QualityRule> {
        let metric = size.metric();
        let of_task = |task: Task| {
            let of_pattern = |it: &String| (it.clone(), self.detectors(&metric, task, it));
            let kinds = size.patterns.iter().map(of_pattern).filter(|(_, detectors)| !detectors.is_empty());
            (task, kinds.collect::<Vec<_>>())
        };
        let of_tasks: Vec<_> = self.tally.tasks().iter().map(|it| of_task(*it)).collect();
        let alike = of_tasks.chunk_by(|a, b| a.1 == b.1);
        let rules = alike.flat_map(|tasks| {
            tasks[0].1.chunk_by(|a, b| a.1 == b.1).map(|kinds| QualityRule {
                line: None,
                metrics: vec![metric.clone()],
                slices: kinds.iter().map(|(pattern, _)| pattern.clone()).collect(),
                tasks: Some(tasks.iter().map(|(task, _)| *task).collect()),
                detectors: Some(kinds[0].1.clone()),
                absolute: size.absolute,
                relative: size.relative,
            })
        });
        rules.collect()
    }

    /// Of the detectors that were timed; nothing if none was.
    fn speed_rule(&self, size: &SpeedSize) -> Option<SpeedRule> {
        // Every task has the same times.
        let task = *self.tally.tasks().first()?;
        let timed = self.detectors(&Metric::TimeRatio, task, "all");
        (!timed.is_empty()).then(|| SpeedRule {
            line: None,
            reference: SPEED_REFERENCE.to_owned(),
            detectors: Some(timed),
            relative: size.relative,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::sums::RATIOS;

    #[test]
    fn every_ratio_has_a_size() {
        let sizes = Sizes::built_in();
        let mut known: Vec<Metric> = sizes.metric.iter().map(MetricSize::metric).collect();
        known.sort();
        let mut ratios = RATIOS.to_vec();
        ratios.sort();
        assert_eq!(known, ratios);
        assert!(RATIOS.contains(&sizes.slices.metric()));
    }
}
