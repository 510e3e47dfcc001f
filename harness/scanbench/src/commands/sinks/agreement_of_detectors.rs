//! `agreement.csv`: what detectors found in data sets without labels, and how far they agree.

use evaluation::metrics::agreement::Agreement;
use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use reports::rows::agreement_row::{AgreementRow, add_agreement};
use reports::vocabulary::task::Task;

use crate::commands::failure::Failure;

/// Compares all detectors with one another, and keeps the rows of the data sets without labels.
pub struct AgreementOfDetectors<'a> {
    rows: &'a mut Vec<AgreementRow>,
    of_dataset: Vec<AgreementRow>,
    n_annotations: usize,
}

impl<'a> AgreementOfDetectors<'a> {
    /// None yet; `rows` gets them.
    pub fn new(rows: &'a mut Vec<AgreementRow>) -> Self {
        Self { rows, of_dataset: Vec::new(), n_annotations: 0 }
    }
}

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

impl RunSink<Failure> for AgreementOfDetectors<'_> {
    fn begin_dataset(&mut self, _: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.of_dataset.clear();
        self.n_annotations = 0;
        Ok(())
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        self.n_annotations += judged.results.scan.annotations.len();
        if self.n_annotations == 0 {
            add_agreement(&mut self.of_dataset, agreement_of(judged));
        }
        Ok(())
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        if self.n_annotations == 0 {
            self.rows.append(&mut self.of_dataset);
        }
        Ok(())
    }
}
