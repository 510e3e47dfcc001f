//! The numbers of a run for services that keep them over time.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::files::archive::pretty_json;
use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::blocks::Interval;
use crate::numbers::run_report::{MetricRow, RunReport};
use crate::tables::formats::format::Format;
use crate::vocabulary::extent::OVERALL;
use crate::vocabulary::metric::{Direction, LatencyStatistic, Metric};
use crate::vocabulary::slice::Slice;

/// The numbers in Bencher's metric format: a benchmark for each task and detector, a measure for each metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BencherMetrics;

impl Format<RunReport> for BencherMetrics {
    /// The service's name for it, whatever the stem.
    fn file_name(&self, _stem: &str) -> String {
        "bencher.json".to_owned()
    }

    fn text(&self, report: &RunReport) -> String {
        let mut benchmarks: BTreeMap<String, BTreeMap<String, Value>> = BTreeMap::new();
        for row in headline_rows(report) {
            let Some(value) = row.value() else { continue };
            let mut measure = json!({ "value": value });
            if let Some(interval) = reliable_interval(row) {
                measure["lower_value"] = interval.ends[0].into();
                measure["upper_value"] = interval.ends[1].into();
            }
            let name = format!("{}/{}", row.subject.task, row.subject.detector);
            benchmarks.entry(name).or_default().insert(row.metric.id(), measure);
        }
        pretty_json(&serde_json::to_value(benchmarks).expect("names are text"))
    }
}

/// The numbers as github-action-benchmark takes them under `customSmallerIsBetter`.
///
/// Rates of which more is better are turned round: 1 − F-rate. Times are for the machine of the run and say nothing
/// elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CustomSmallerIsBetter;

impl Format<RunReport> for CustomSmallerIsBetter {
    /// The service's name for it, whatever the stem.
    fn file_name(&self, _stem: &str) -> String {
        "custom-smaller-is-better.json".to_owned()
    }

    fn text(&self, report: &RunReport) -> String {
        let entries = headline_rows(report).filter_map(|row| {
            let value = row.value()?;
            let is_turned = row.metric.direction() == Direction::HigherIsBetter;
            let name = if is_turned { format!("1 - {}", row.metric.id()) } else { row.metric.id() };
            let mut entry = json!({
                "name": format!("{}/{}/{name}", row.subject.task, row.subject.detector),
                "unit": row.metric.unit(),
                "value": if is_turned { 1.0 - value } else { value },
                "extra": format!("made of {}", row.n),
            });
            if let Some(interval) = reliable_interval(row) {
                let half_width = (interval.ends[1] - interval.ends[0]) / 2.0;
                entry["range"] = Value::String(format!("± {}", fixed_decimals(half_width, 4)));
            }
            Some(entry)
        });
        pretty_json(&Value::Array(entries.collect()))
    }
}

/// Its interval, unless that is of too few blocks of scans: services would draw conclusions from it.
fn reliable_interval(row: &MetricRow) -> Option<Interval> {
    row.interval().filter(|it| !it.blocks.decide_nothing())
}

/// The ratios and the median time, over all data sets; of recorded and simulated ones also of each.
fn headline_rows(report: &RunReport) -> impl Iterator<Item = &MetricRow> {
    let is_of_all = report.overall().iter().any(|it| it.subject.dataset == OVERALL);
    let rows = report.rows().iter().filter(move |_| !is_of_all).chain(report.overall());
    let is_headline =
        |metric: &Metric| metric.is_ratio() || *metric == Metric::Latency(LatencyStatistic::P50);
    rows.filter(move |it| it.subject.slice == Slice::All && is_headline(&it.metric))
}
