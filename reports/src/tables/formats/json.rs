//! `gate.json`: a verdict for programs.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::files::archive::{SCHEMA, pretty_json};
use crate::run_folder::run_archive::ClaimName;
use crate::tables::formats::format::Format;
use crate::verdicts::change::{Change, ChangeKind};
use crate::verdicts::changed_claims::ChangedClaim;
use crate::verdicts::gated_metrics::GatedMetric;
use crate::verdicts::paired_difference::PairedDifference;
use crate::verdicts::verdict::Verdict;
use crate::vocabulary::claim_verdict::ClaimVerdict;
use crate::vocabulary::metric::SPEED_REFERENCE;

#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub(crate) struct VerdictRecord<'a> {
    schema: u32,
    conclusion: &'static str,
    dataset: &'a str,
    n_blocks: u64,
    degrees_of_freedom: u64,
    blocks: &'static str,
    few_blocks: bool,
    /// Numbers that changed, which may look worse by chance.
    n_at_risk: usize,
    /// How many of them are called worse by chance at most, on average.
    most_false_alarms: f64,
    metrics: Vec<MetricRecord<'a>>,
    speeds: Vec<SpeedRecord<'a>>,
    /// Why times were not compared, where a rule is about them.
    speed_not_compared: Option<&'a str>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    doubts: &'a [String],
    configuration_changes: &'a [String],
    /// Claims of the papers of which something else comes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    claims: Vec<ClaimRecord<'a>>,
    /// What became of numbers since an earlier run of the history, a line each.
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    since: &'a [String],
    /// Whether results that changed fail or warn.
    drift_rule: &'static str,
    /// Changed results of each kind that occurs, each detector and task counted, the worst kind first.
    n_changes: BTreeMap<ChangeKind, usize>,
    drift: Vec<DriftRecord<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
struct ClaimRecord<'a> {
    paper: &'a str,
    place: &'a str,
    says: &'a str,
    before: ClaimVerdict,
    after: ClaimVerdict,
    is_worse: bool,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
struct MetricRecord<'a> {
    /// Where it is not that of the verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    dataset: Option<&'a str>,
    task: &'a str,
    detector: &'a str,
    slice: &'a str,
    metric: String,
    unit: &'static str,
    higher_is_better: Option<bool>,
    before: Option<f64>,
    after: Option<f64>,
    difference: Option<f64>,
    difference_interval_95: Option<[f64; 2]>,
    least_effect: Option<f64>,
    missing_in: Option<&'static str>,
    tolerance: f64,
    finding: &'static str,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
struct SpeedRecord<'a> {
    /// Where it is not that of the verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    dataset: Option<&'a str>,
    detector: &'a str,
    reference: &'a str,
    time_ratio_before: Option<f64>,
    time_ratio_after: Option<f64>,
    slowdown: Option<f64>,
    slowdown_interval_95: Option<[f64; 2]>,
    missing_in: Option<&'static str>,
    tolerance: f64,
    finding: &'static str,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
struct DriftRecord<'a> {
    dataset: &'a str,
    sequence: &'a str,
    scan: u32,
    detector: &'a str,
    task: &'a str,
    /// The worst first.
    changes: Vec<ChangeRecord<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
struct ChangeRecord<'a> {
    kind: ChangeKind,
    what: &'a str,
    n_objects: usize,
}

/// JSON with all numbers and all that changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Json;

impl Format<Verdict> for Json {
    fn file_name(&self, stem: &str) -> String {
        format!("{stem}.json")
    }

    fn text(&self, verdict: &Verdict) -> String {
        let record = VerdictRecord {
            schema: SCHEMA,
            conclusion: verdict.conclusion().name(),
            dataset: &verdict.dataset,
            n_blocks: verdict.blocks.n_blocks,
            degrees_of_freedom: verdict.blocks.degrees_of_freedom,
            blocks: verdict.blocks.kind.name(),
            few_blocks: verdict.blocks.decide_nothing(),
            n_at_risk: verdict.n_at_risk(),
            most_false_alarms: verdict.most_false_alarms(),
            metrics: verdict.metrics.iter().map(metric_record).collect(),
            speeds: verdict.speeds.iter().map(speed_record).collect(),
            speed_not_compared: verdict.speed_not_compared.as_deref(),
            doubts: &verdict.doubts,
            configuration_changes: &verdict.configuration_changes,
            claims: verdict.claims.iter().map(claim_record).collect(),
            since: verdict.since.as_ref().map_or(&[], |it| &it.lines),
            drift_rule: verdict.tolerances.drift.name(),
            n_changes: verdict.n_changes(),
            drift: verdict
                .drift
                .iter()
                .map(|it| DriftRecord {
                    dataset: &it.subject.dataset,
                    sequence: &it.subject.sequence,
                    scan: it.subject.scan,
                    detector: &it.subject.detector,
                    task: &it.subject.task,
                    changes: it.changes.iter().map(change_record).collect(),
                })
                .collect(),
        };
        pretty_json(&record)
    }
}

fn change_record(change: &Change) -> ChangeRecord<'_> {
    ChangeRecord { kind: change.kind, what: &change.text, n_objects: change.n_objects }
}

fn claim_record(changed: &ChangedClaim) -> ClaimRecord<'_> {
    let ClaimName { paper, place, says } = &changed.claim;
    ClaimRecord {
        paper,
        place,
        says,
        before: changed.before,
        after: changed.after,
        is_worse: changed.is_worse(),
    }
}

fn metric_record(gated: &GatedMetric) -> MetricRecord<'_> {
    let difference = gated.difference.as_ref().ok();
    MetricRecord {
        dataset: gated.on.as_deref(),
        task: &gated.task,
        detector: &gated.detector,
        slice: &gated.slice,
        metric: gated.metric.id(),
        unit: gated.metric.unit(),
        higher_is_better: gated.metric.direction().higher_is_better(),
        before: difference.map(|it| it.before),
        after: difference.map(|it| it.after),
        difference: difference.map(PairedDifference::difference),
        difference_interval_95: difference.and_then(|it| it.interval).map(|it| it.ends),
        least_effect: difference.and_then(|it| it.least_effect),
        missing_in: gated.difference.as_ref().err().map(|it| it.name()),
        tolerance: gated.tolerance,
        finding: gated.finding.name(),
    }
}

fn speed_record(speed: &GatedMetric) -> SpeedRecord<'_> {
    let slowdown = speed.difference.as_ref().ok();
    SpeedRecord {
        dataset: speed.on.as_deref(),
        detector: &speed.detector,
        reference: SPEED_REFERENCE,
        time_ratio_before: slowdown.map(|it| it.before),
        time_ratio_after: slowdown.map(|it| it.after),
        slowdown: slowdown.map(PairedDifference::difference),
        slowdown_interval_95: slowdown.and_then(|it| it.interval).map(|it| it.ends),
        missing_in: speed.difference.as_ref().err().map(|it| it.name()),
        tolerance: speed.tolerance,
        finding: speed.finding.name(),
    }
}
