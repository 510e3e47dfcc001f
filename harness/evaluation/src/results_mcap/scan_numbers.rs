//! The numbers of one scan, detector and task, as messages that can be plotted.

use std::collections::BTreeMap;

use reports::rows::counts::Counts;
use reports::rows::scan_row::ScanRow;
use reports::rows::stage_row::StageRow;
use serde::Serialize;

/// Name of the messages.
pub const SCAN_NUMBERS: &str = "scanbench.ScanNumbers";

/// Schema of the messages. Undefined numbers, such as a rate over nothing, are null.
pub const SCAN_NUMBERS_SCHEMA: &str = r#"{
  "title": "scanbench.ScanNumbers",
  "type": "object",
  "properties": {
    "dataset": {"type": "string"},
    "sequence": {"type": "string"},
    "scan": {"type": "integer"},
    "detector": {"type": "string"},
    "task": {"type": "string"},
    "n_points": {"type": "integer"},
    "latency_ms": {"type": ["number", "null"]},
    "stage_ms": {"type": "object", "additionalProperties": {"type": "number"}},
    "no": {"type": "integer", "description": "annotations that count"},
    "tp": {"type": "integer", "description": "found"},
    "mo": {"type": "integer", "description": "missed"},
    "fo": {"type": ["integer", "null"], "description": "false detections"},
    "ignored_annotations": {"type": "integer"},
    "ignored_detections": {"type": "integer"},
    "unknowable_detections": {"type": "integer"},
    "precision_so_far": {"type": ["number", "null"]},
    "recall_so_far": {"type": ["number", "null"]},
    "f_rate_so_far": {"type": ["number", "null"]}
  }
}"#;

/// The numbers of one scan, detector and task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScanNumbersMessage<'a> {
    dataset: &'a str,
    sequence: &'a str,
    scan: u32,
    detector: &'a str,
    task: &'static str,
    n_points: u64,
    latency_ms: Option<f64>,
    stage_ms: BTreeMap<&'a str, f64>,
    no: u64,
    tp: u64,
    mo: u64,
    fo: Option<u64>,
    ignored_annotations: u64,
    ignored_detections: u64,
    unknowable_detections: u64,
    precision_so_far: Option<f64>,
    recall_so_far: Option<f64>,
    f_rate_so_far: Option<f64>,
}

impl<'a> ScanNumbersMessage<'a> {
    /// The message of `row`; `so_far` are the sums up to this scan. `None` for a scan that was not evaluated.
    pub fn new(row: &'a ScanRow, stages: &'a [StageRow], so_far: Counts) -> Option<Self> {
        let numbers = row.numbers()?;
        Some(Self {
            dataset: &row.dataset,
            sequence: &row.sequence,
            scan: row.scan,
            detector: &row.detector,
            task: row.task.name(),
            n_points: numbers.n_points,
            latency_ms: numbers.latency_ms,
            stage_ms: stages.iter().map(|it| (it.stage.as_str(), it.time_ms)).collect(),
            no: numbers.counts.no(),
            tp: numbers.counts.tp(),
            mo: numbers.counts.mo(),
            fo: numbers.counts.fo(),
            ignored_annotations: numbers.n_ignored_annotations,
            ignored_detections: numbers.n_ignored_detections,
            unknowable_detections: numbers.n_unknowable_detections,
            precision_so_far: so_far.drawn(Counts::precision),
            recall_so_far: so_far.recall(),
            f_rate_so_far: so_far.drawn(Counts::f_rate),
        })
    }
}
