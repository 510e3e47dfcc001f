//! `agreement.csv`: what detectors found in data sets without labels, and how far they agree.

use evaluation::metrics::agreement::Agreement;
use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use reports::rows::agreement_row::AgreementRow;
use reports::vocabulary::task::Task;

use crate::commands::failure::Failure;

/// Compares all detectors with one another, and keeps the rows of the data sets without labels.
pub struct AgreementOfDetectors<'a> {
    rows: &'a mut Vec<AgreementRow>,
    dataset: String,
    // For each task the detectors with each other one, in their order; one that is alone with itself.
    pairs: Vec<(Task, [&'static str; 2], Agreement)>,
    n_scans: u64,
    n_annotations: usize,
}

impl<'a> AgreementOfDetectors<'a> {
    /// None yet; `rows` gets them.
    pub fn new(rows: &'a mut Vec<AgreementRow>) -> Self {
        Self { rows, dataset: String::new(), pairs: Vec::new(), n_scans: 0, n_annotations: 0 }
    }
}

impl RunSink<Failure> for AgreementOfDetectors<'_> {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.dataset.clone_from(&watched.dataset.description().id);
        self.pairs.clear();
        (self.n_scans, self.n_annotations) = (0, 0);
        Ok(())
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        self.n_scans += 1;
        self.n_annotations += judged.results.scan.annotations.len();
        if self.n_annotations > 0 {
            return Ok(());
        }
        let results = judged.results.results;
        let n_points = judged.results.scan.cloud.len();
        let others = |idx: usize| (0..results.len()).filter(move |it| *it != idx || results.len() == 1);
        let pairs = Task::ALL.into_iter().flat_map(|task| {
            (0..results.len()).flat_map(move |idx| others(idx).map(move |other| (task, [idx, other])))
        });
        for (place, (task, pair)) in pairs.enumerate() {
            let pair = pair.map(|it| &results[it]);
            if place == self.pairs.len() {
                self.pairs.push((task, pair.map(|it| it.detector), Agreement::default()));
            }
            self.pairs[place].2.add(&Agreement::of(pair.map(|it| &it.output.detections), task, n_points));
        }
        Ok(())
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        if self.n_annotations == 0 {
            self.rows.extend(self.pairs.drain(..).map(|(task, [detector, other], agreement)| AgreementRow {
                dataset: self.dataset.clone(),
                task,
                detector: detector.to_owned(),
                other: other.to_owned(),
                n_scans: self.n_scans,
                n_detections: agreement.n_first,
                n_other: agreement.n_second,
                n_both: agreement.n_both,
            }));
        }
        Ok(())
    }
}
