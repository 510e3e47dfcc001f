//! The numbers of a run for github-action-benchmark, which keeps them over time.

use serde_json::{Value, json};

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::run_report::RunReport;
use crate::tables::formats::format::Format;
use crate::tables::service_rows::{headline_rows, pretty, reliable_interval};
use crate::vocabulary::metric::Direction;

/// The numbers as github-action-benchmark takes them under `customSmallerIsBetter`.
///
/// Rates of which more is better are turned round: 1 − F-rate. Times are for the machine of the run and say nothing elsewhere.
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
        pretty(&Value::Array(entries.collect()))
    }
}
