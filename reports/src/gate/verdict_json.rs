//! `gate.json`: a verdict for programs.

use serde::Serialize;

use crate::archive::SCHEMA;
use crate::gate::paired_difference::PairedDifference;
use crate::gate::verdict::{GatedMetric, GatedSpeed, Verdict};

#[derive(Serialize)]
struct VerdictRecord<'a> {
    schema: u32,
    conclusion: &'static str,
    metrics: Vec<MetricRecord<'a>>,
    speeds: Vec<SpeedRecord<'a>>,
    drift: Vec<DriftRecord<'a>>,
}

#[derive(Serialize)]
struct MetricRecord<'a> {
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
    n_blocks: Option<u64>,
    tolerance: f64,
    finding: &'static str,
}

#[derive(Serialize)]
struct SpeedRecord<'a> {
    detector: &'a str,
    reference: &'a str,
    time_ratio_before: f64,
    time_ratio_after: f64,
    slowdown: f64,
    slowdown_interval_95: Option<[f64; 2]>,
    tolerance: f64,
    finding: &'static str,
}

#[derive(Serialize)]
struct DriftRecord<'a> {
    dataset: &'a str,
    sequence: &'a str,
    scan: u32,
    detector: &'a str,
    task: &'a str,
    changes: &'a [String],
}

/// The content of `gate.json`.
pub fn to_json(verdict: &Verdict) -> String {
    let record = VerdictRecord {
        schema: SCHEMA,
        conclusion: verdict.conclusion().name(),
        metrics: verdict.metrics.iter().map(metric_record).collect(),
        speeds: verdict.speeds.iter().map(speed_record).collect(),
        drift: verdict
            .drift
            .iter()
            .map(|it| DriftRecord {
                dataset: &it.place.dataset,
                sequence: &it.place.sequence,
                scan: it.place.scan,
                detector: &it.place.detector,
                task: &it.place.task,
                changes: &it.changes,
            })
            .collect(),
    };
    let mut json = serde_json::to_string_pretty(&record).expect("a verdict has text keys and finite numbers");
    json.push('\n');
    json
}

fn metric_record(gated: &GatedMetric) -> MetricRecord<'_> {
    let difference = gated.difference.as_ref();
    let interval = difference.and_then(|it| it.interval);
    MetricRecord {
        task: &gated.task,
        detector: &gated.detector,
        slice: &gated.slice,
        metric: gated.metric.id(),
        unit: gated.metric.unit(),
        higher_is_better: gated.metric.direction().higher_is_better(),
        before: difference.map(|it| it.before),
        after: difference.map(|it| it.after),
        difference: difference.map(PairedDifference::difference),
        difference_interval_95: interval.map(|it| it.ends),
        least_effect: difference.and_then(|it| it.least_effect),
        n_blocks: interval.map(|it| it.n_blocks),
        tolerance: gated.tolerance,
        finding: gated.finding.name(),
    }
}

fn speed_record(speed: &GatedSpeed) -> SpeedRecord<'_> {
    SpeedRecord {
        detector: &speed.detector,
        reference: &speed.reference,
        time_ratio_before: speed.before,
        time_ratio_after: speed.after,
        slowdown: speed.after / speed.before - 1.0,
        slowdown_interval_95: speed.slowdown_interval.map(|it| it.ends),
        tolerance: speed.tolerance,
        finding: speed.finding.name(),
    }
}
