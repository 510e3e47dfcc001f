//! `report.json`: the numbers of a run.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::files::archive::{ArchiveError, SCHEMA, read_json};
use crate::files::shown_text::printable_name;
use crate::numbers::blocks::Interval;
use crate::numbers::number_record::NumberRecord;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// The numbers of a run.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(try_from = "ReportRecord")]
pub struct RunReport {
    // Invariant: no two rows have the same subject and metric.
    scoring_version: u32,
    rows: Vec<MetricRow>,
    overall: Vec<MetricRow>,
}

/// Subject of a number: data set, task, detector and slice.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Subject {
    /// Id of the data set; in rows about several, the name of their [`Extent`](crate::vocabulary::extent::Extent).
    pub dataset: String,
    /// The task.
    pub task: Task,
    /// Name of the detector.
    pub detector: String,
    /// The part of the objects that counts.
    pub slice: Slice,
}

impl Subject {
    /// All objects of a data set, as a detector sees them in a task.
    pub fn of_all(dataset: &str, task: Task, detector: &str) -> Self {
        Self { dataset: dataset.to_owned(), task, detector: detector.to_owned(), slice: Slice::All }
    }
}

/// A number with its subject, metric, count and interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(into = "RowRecord")]
pub struct MetricRow {
    /// Subject of the number.
    pub subject: Subject,
    /// The metric, which determines the unit and the direction.
    pub metric: Metric,
    // Invariant: finite.
    value: Option<f64>,
    /// Count behind the value: for a rate the denominator, for a count the number of scans, for a time or a speed the
    /// number of timed scans.
    pub n: u64,
    interval: Option<Interval>,
}

/// Error of numbers that make no report.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct RunReportError(String);

impl MetricRow {
    /// A number. One that is not finite, such as a ratio over zero, is undefined and kept as `None`.
    pub fn new(subject: Subject, metric: Metric, value: Option<f64>, n: u64) -> Self {
        Self { subject, metric, value: value.filter(|it| it.is_finite()), n, interval: None }
    }

    /// This row with its interval, unless an end of that is not finite.
    pub fn within(self, interval: Option<Interval>) -> Self {
        Self { interval: interval.filter(|it| it.ends.iter().all(|end| end.is_finite())), ..self }
    }

    /// Interval of the number, if there is one. Its ends are finite.
    pub fn interval(&self) -> Option<Interval> {
        self.interval
    }

    /// The number; `None` where it is undefined. Never NaN or infinite.
    pub fn value(&self) -> Option<f64> {
        self.value
    }
}

impl RunReport {
    /// The report of these numbers, in this order.
    ///
    /// `scoring_version` is that of the rules by which the detections were judged: numbers of different versions must
    /// not be compared.
    ///
    /// # Errors
    ///
    /// [`RunReportError`] if two rows have the same subject and metric.
    pub fn new(scoring_version: u32, rows: Vec<MetricRow>) -> Result<Self, RunReportError> {
        Self::with_overall(scoring_version, rows, Vec::new())
    }

    /// The report of these numbers, and of those about several data sets together.
    ///
    /// # Errors
    ///
    /// [`RunReportError`] if two rows have the same subject and metric.
    pub fn with_overall(
        scoring_version: u32,
        rows: Vec<MetricRow>,
        overall: Vec<MetricRow>,
    ) -> Result<Self, RunReportError> {
        let mut seen = HashSet::new();
        for row in rows.iter().chain(&overall) {
            if !seen.insert((&row.subject, &row.metric)) {
                let Subject { dataset, task, detector, slice } = &row.subject;
                let metric = row.metric.id();
                return Err(RunReportError(format!(
                    "the report has {metric} of {detector} on {dataset}, task {task}, slice {slice}, twice"
                )));
            }
        }
        Ok(Self { scoring_version, rows, overall })
    }

    /// The version of the rules by which the detections were judged.
    pub fn scoring_version(&self) -> u32 {
        self.scoring_version
    }

    /// The numbers, in the order of the report.
    pub fn rows(&self) -> &[MetricRow] {
        &self.rows
    }

    /// The numbers about all data sets of one origin together, if there are several.
    pub fn overall(&self) -> &[MetricRow] {
        &self.overall
    }

    /// The task of the first row, for numbers that are the same in every task; `None` for an empty report.
    pub fn first_task(&self) -> Option<Task> {
        self.rows.first().map(|it| it.subject.task)
    }

    /// Number of scans to which `detector` gave no answer, and of all its scans, on the data sets that `is_asked`; `None` if
    /// it answered all of them.
    pub fn failed_scans(
        &self,
        is_asked: impl Fn(&str) -> bool,
        task: Task,
        detector: &str,
    ) -> Option<[u64; 2]> {
        let of_metric = |metric: Metric| {
            self.rows.iter().filter(move |it| {
                let Subject { task: of_task, detector: of_detector, slice, .. } = &it.subject;
                (*of_task, of_detector.as_str(), *slice) == (task, detector, Slice::All)
                    && it.metric == metric
            })
        };
        let of_asked = |metric| of_metric(metric).filter(|it| is_asked(&it.subject.dataset));
        let n_failed = of_asked(Metric::FailedScans).filter_map(MetricRow::value).sum::<f64>() as u64;
        // Only data sets with such a scan have a row about them.
        let n_scans = of_asked(Metric::No).map(|it| it.n).sum();
        (n_failed > 0).then_some([n_failed, n_scans])
    }

    /// The row of `subject` and `metric`, of one data set or of several.
    pub fn row(&self, subject: &Subject, metric: &Metric) -> Option<&MetricRow> {
        self.rows.iter().chain(&self.overall).find(|it| it.subject == *subject && it.metric == *metric)
    }

    /// The content of `report.json`: one row a line, so that two reports can be compared line by line.
    ///
    /// Numbers are written with as many digits as it takes to read the same number back.
    pub fn to_json(&self) -> String {
        let scoring_version = self.scoring_version;
        let mut json =
            format!("{{\n  \"schema\": {SCHEMA},\n  \"scoring_version\": {scoring_version},\n  \"rows\": [");
        push_rows(&mut json, &self.rows);
        json.push_str("\n  ],\n  \"overall\": [");
        push_rows(&mut json, &self.overall);
        json.push_str("\n  ]\n}\n");
        json
    }

    /// Reads and checks a `report.json`.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if the file cannot be read, has another schema, misses a field or has an unknown one, or if a
    /// row contradicts its metric or another row.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        read_json(path)
    }
}

fn push_rows(json: &mut String, rows: &[MetricRow]) {
    for (row_idx, row) in rows.iter().enumerate() {
        let separator = if row_idx == 0 { "" } else { "," };
        let row = serde_json::to_string(row).expect("a row has text keys and finite numbers");
        write!(json, "{separator}\n    {row}").expect("a string takes all that is written");
    }
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct ReportRecord {
    #[serde(rename = "schema")]
    _schema: u32,
    scoring_version: u32,
    rows: Vec<RowRecord>,
    overall: Vec<RowRecord>,
}

impl TryFrom<ReportRecord> for RunReport {
    type Error = RunReportError;

    fn try_from(record: ReportRecord) -> Result<Self, RunReportError> {
        let rows = |records: Vec<RowRecord>| {
            let rows = records.into_iter().enumerate().map(|(row_idx, row)| {
                MetricRow::try_from(row)
                    .map_err(|problem| RunReportError(format!("row {row_idx}: {problem}")))
            });
            rows.collect::<Result<Vec<_>, _>>()
        };
        Self::with_overall(record.scoring_version, rows(record.rows)?, rows(record.overall)?)
    }
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct RowRecord {
    #[serde(deserialize_with = "printable_name")]
    dataset: String,
    task: Task,
    #[serde(deserialize_with = "printable_name")]
    detector: String,
    slice: Slice,
    metric: String,
    #[serde(flatten)]
    number: NumberRecord,
}

impl From<MetricRow> for RowRecord {
    fn from(row: MetricRow) -> Self {
        let Subject { dataset, task, detector, slice } = row.subject;
        Self {
            dataset,
            task,
            detector,
            slice,
            metric: row.metric.id(),
            number: NumberRecord::new(row.value, row.metric.unit(), row.metric.direction(), row.n)
                .within(row.interval, row.metric.caveat(row.n)),
        }
    }
}

impl TryFrom<RowRecord> for MetricRow {
    type Error = String;

    fn try_from(record: RowRecord) -> Result<Self, String> {
        let RowRecord { dataset, task, detector, slice, metric: id, number } = record;
        let metric = Metric::from_id(&id).ok_or_else(|| format!("unknown metric {id:?}"))?;
        let (expected, found) = (metric.unit(), &number.unit);
        if found != expected {
            return Err(format!("{id} has the unit {expected:?}, not {found:?}"));
        }
        let (expected, found) = (metric.direction().higher_is_better(), number.higher_is_better);
        if found != expected {
            return Err(format!("higher_is_better of {id} is {expected:?}, not {found:?}"));
        }
        let interval = number.interval()?;
        let subject = Subject { dataset, task, detector, slice };
        Ok(Self::new(subject, metric, number.value, number.n).within(interval))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind};
    use crate::vocabulary::extent::OVERALL;
    use crate::vocabulary::metric::LatencyStatistic;

    fn row(metric: Metric, value: Option<f64>, n: u64) -> MetricRow {
        MetricRow::new(Subject::of_all("main_road", Task::Objects, "kd-tree"), metric, value, n)
    }

    fn three_rows() -> RunReport {
        let rows = vec![
            row(Metric::No, Some(31.0), 2),
            row(Metric::FRate, Some(0.1 + 0.2), 62),
            row(Metric::StageP50("grid".to_owned()), Some(f64::NAN), 0),
        ];
        RunReport::new(1, rows).unwrap()
    }

    fn read_back(json: &str) -> Result<RunReport, ArchiveError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        std::fs::write(&path, json).unwrap();
        RunReport::read(&path)
    }

    #[test]
    fn scans_without_an_answer_are_among_those_of_all_data_sets() {
        let of = |dataset: &str, metric, value, n| {
            MetricRow::new(Subject::of_all(dataset, Task::Objects, "mine"), metric, Some(value), n)
        };
        let rows = vec![
            of("street", Metric::No, 80.0, 20),
            of("street", Metric::FailedScans, 3.0, 20),
            of("drive", Metric::No, 40.0, 10),
        ];
        let report = RunReport::new(1, rows).unwrap();
        let failed = |is_asked: fn(&str) -> bool| report.failed_scans(is_asked, Task::Objects, "mine");
        assert_eq!(failed(|_| true), Some([3, 30]));
        assert_eq!(failed(|it| it == "street"), Some([3, 20]));
        assert_eq!(failed(|it| it == "drive"), None);
        assert_eq!(report.failed_scans(|_| true, Task::Vehicles, "mine"), None);
    }

    #[test]
    fn a_row_is_a_line() {
        insta::assert_snapshot!(three_rows().to_json(), @r#"
        {
          "schema": 1,
          "scoring_version": 1,
          "rows": [
            {"dataset":"main_road","task":"objects","detector":"kd-tree","slice":"all","metric":"no","value":31.0,"unit":"count","higher_is_better":null,"n":2},
            {"dataset":"main_road","task":"objects","detector":"kd-tree","slice":"all","metric":"f_rate","value":0.30000000000000004,"unit":"ratio","higher_is_better":true,"n":62},
            {"dataset":"main_road","task":"objects","detector":"kd-tree","slice":"all","metric":"stage_p50_ms/grid","value":null,"unit":"ms","higher_is_better":false,"n":0}
          ],
          "overall": [
          ]
        }
        "#);
    }

    #[test]
    fn a_report_reads_back_as_it_was() {
        assert_eq!(read_back(&three_rows().to_json()).unwrap(), three_rows());
        let empty = RunReport::new(7, Vec::new()).unwrap();
        assert_eq!(read_back(&empty.to_json()).unwrap(), empty);
    }

    #[test]
    fn intervals_and_overall_numbers_read_back_as_they_were() {
        let interval =
            Interval { ends: [0.1 + 0.2, 0.5], blocks: BlockCount::of_dataset(7, BlockKind::Seconds) };
        let sure = row(Metric::Recall, Some(0.4), 9).within(Some(interval));
        let mut overall = row(Metric::Latency(LatencyStatistic::P95), Some(4.0), 58);
        OVERALL.clone_into(&mut overall.subject.dataset);
        let report = RunReport::with_overall(1, vec![sure], vec![overall.clone()]).unwrap();
        let json = report.to_json();
        let sureness = r#""interval_95":[0.30000000000000004,0.5],"n_blocks":7,"degrees_of_freedom":6,"blocks":"seconds""#;
        assert!(json.contains(sureness), "{json}");
        assert!(json.contains(r#""caveat":"interval from only 7 blocks of scans""#), "{json}");
        let of_other_blocks = json.replace("\"seconds\"", "\"minutes\"");
        let error = read_back(&of_other_blocks).unwrap_err();
        assert!(
            matches!(&error, ArchiveError::Json { source, .. } if source.to_string().contains("minutes"))
        );
        assert!(json.contains(r#""caveat":"p95 of fewer than 59 scans""#), "{json}");
        assert_eq!(read_back(&json).unwrap(), report);
        assert_eq!(report.row(&overall.subject, &overall.metric), Some(&overall));
        let endless = Interval { ends: [f64::NAN, 0.5], ..interval };
        assert_eq!(row(Metric::Recall, Some(0.4), 9).within(Some(endless)).interval(), None);
    }

    #[test]
    fn what_is_not_finite_is_undefined() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(row(Metric::Recall, Some(value), 0).value(), None);
        }
    }

    /// The report with `from` replaced by `to` is refused, and the reason contains `expected`.
    #[track_caller]
    fn check_refused(from: &str, to: &str, expected: &str) {
        let json = three_rows().to_json();
        assert!(json.contains(from), "{json}");
        let error = read_back(&json.replacen(from, to, 1)).unwrap_err();
        let reason = match &error {
            ArchiveError::Json { source, .. } => source.to_string(),
            other => other.to_string(),
        };
        assert!(reason.contains(expected), "{reason}");
    }

    #[test]
    fn what_contradicts_itself_is_refused_with_the_reason() {
        check_refused("\"schema\": 1", "\"schema\": 2", "has schema 2, but this program reads schema 1");
        check_refused("f_rate", "g_rate", "row 1: unknown metric \"g_rate\"");
        check_refused("\"count\"", "\"ms\"", "no has the unit \"count\", not \"ms\"");
        check_refused(
            "\"higher_is_better\":true",
            "\"higher_is_better\":false",
            "higher_is_better of f_rate is Some(true), not Some(false)",
        );
        check_refused("\"value\":31.0,", "", "missing field `value`");
        check_refused("\"value\":31.0", "\"value\":31.0,\"note\":\"\"", "unknown field `note`");
        check_refused("\n  ]\n}", "", "EOF");
    }

    #[test]
    fn two_rows_about_the_same_are_refused() {
        let twice = vec![row(Metric::No, Some(1.0), 1), row(Metric::No, Some(2.0), 1)];
        let error = RunReport::new(1, twice).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the report has no of kd-tree on main_road, task objects, slice all, twice"
        );
    }
}
