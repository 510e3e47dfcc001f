//! The numbers of a run for Bencher, which keeps them over time.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::numbers::run_report::RunReport;
use crate::tables::formats::format::Format;
use crate::tables::service_rows::{headline_rows, pretty, reliable_interval};

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
        pretty(&serde_json::to_value(benchmarks).expect("names are text"))
    }
}
