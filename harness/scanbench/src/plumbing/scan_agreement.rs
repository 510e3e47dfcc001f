//! How far detectors agree on a scan.

use std::collections::BTreeSet;

use evaluation::metrics::agreement::{asked_for, shared};
use evaluation::run::sink::JudgedScan;
use reports::rows::agreement_row::AgreementRow;
use reports::vocabulary::task::Task;

/// How far detectors agree on a scan: for each task a row for each detector with each other one, in their order. A detector
/// that is alone has a row with itself.
pub fn agreement_of(judged: &JudgedScan<'_>) -> Vec<AgreementRow> {
    let n_detectors = judged.results.results.len();
    let all = Task::ALL.into_iter().flat_map(|task| (0..n_detectors).map(move |idx| (task, idx)));
    all.flat_map(|(task, idx)| rows_of(judged, task, idx)).collect()
}

/// Rows of the detector at `idx` with each other one.
fn rows_of(judged: &JudgedScan<'_>, task: Task, idx: usize) -> Vec<AgreementRow> {
    let results = judged.results.results;
    let n_points = judged.results.scan.cloud.len();
    let detections = |idx: usize| &results[idx].output.detections;
    let others = (0..results.len()).filter(|it| *it != idx || results.len() == 1);
    let with_others: Vec<(usize, Vec<usize>)> =
        others.map(|it| (it, shared([detections(idx), detections(it)], task, n_points))).collect();
    let n_detections = asked_for(detections(idx), task).len();
    let seen_by_others: BTreeSet<usize> =
        with_others.iter().flat_map(|(_, both)| both.iter().copied()).collect();
    let row = |(other, both): (usize, Vec<usize>)| AgreementRow {
        dataset: judged.dataset().id.clone(),
        task,
        detector: results[idx].detector.to_owned(),
        other: results[other].detector.to_owned(),
        n_scans: 1,
        n_detections: n_detections as u64,
        n_other: asked_for(detections(other), task).len() as u64,
        n_both: both.len() as u64,
        n_alone: (n_detections - seen_by_others.len()) as u64,
    };
    with_others.into_iter().map(row).collect()
}
