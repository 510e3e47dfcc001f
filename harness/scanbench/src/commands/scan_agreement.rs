//! How far detectors agree on a scan.

use evaluation::metrics::agreement::Agreement;
use evaluation::run::sink::JudgedScan;
use reports::rows::agreement_row::AgreementRow;
use reports::vocabulary::task::Task;

/// How far detectors agree on a scan: for each task each detector with each other one, in their order; one that is alone with
/// itself.
pub fn agreement_of(judged: &JudgedScan<'_>) -> Vec<AgreementRow> {
    let results = judged.results.results;
    let n_points = judged.results.scan.cloud.len();
    let others = |idx: usize| (0..results.len()).filter(move |it| *it != idx || results.len() == 1);
    let pairs = Task::ALL.into_iter().flat_map(|task| {
        (0..results.len()).flat_map(move |idx| others(idx).map(move |other| (task, [idx, other])))
    });
    let row = |(task, pair): (Task, [usize; 2])| {
        let [detector, other] = pair.map(|it| &results[it]);
        let agreement =
            Agreement::of([&detector.output.detections, &other.output.detections], task, n_points);
        AgreementRow {
            dataset: judged.dataset().id.clone(),
            task,
            detector: detector.detector.to_owned(),
            other: other.detector.to_owned(),
            n_scans: 1,
            n_detections: agreement.n_first,
            n_other: agreement.n_second,
            n_both: agreement.n_both,
        }
    };
    pairs.map(row).collect()
}
