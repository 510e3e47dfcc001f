//! What services that keep numbers over time are given of a run.

use serde_json::Value;

use crate::numbers::blocks::Interval;
use crate::numbers::run_report::{MetricRow, RunReport};
use crate::numbers::sums::RATIOS;
use crate::vocabulary::extent::OVERALL;
use crate::vocabulary::metric::{LatencyStatistic, Metric};
use crate::vocabulary::slice::Slice;

/// Its interval, unless that is of too few blocks of scans: services would draw conclusions from it.
pub(crate) fn reliable_interval(row: &MetricRow) -> Option<Interval> {
    row.interval().filter(|it| !it.blocks.decide_nothing())
}

/// The ratios and the median time, over all data sets; of recorded and simulated ones also of each.
pub(crate) fn headline_rows(report: &RunReport) -> impl Iterator<Item = &MetricRow> {
    let is_of_all = report.overall().iter().any(|it| it.subject.dataset == OVERALL);
    let rows = report.rows().iter().filter(move |_| !is_of_all).chain(report.overall());
    let is_headline =
        |metric: &Metric| RATIOS.contains(metric) || *metric == Metric::Latency(LatencyStatistic::P50);
    rows.filter(move |it| it.subject.slice == Slice::All && is_headline(&it.metric))
}

/// JSON over several lines.
pub(crate) fn pretty(value: &Value) -> String {
    let mut json = serde_json::to_string_pretty(value).expect("keys are text and numbers finite");
    json.push('\n');
    json
}
