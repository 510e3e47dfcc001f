//! Facts about a run that its manifest gets in the end: labels, damaged scans, doubts, processors, recordings.

use reports::run_folder::manifest::{Manifest, SkippedScan};
use reports::run_folder::shard_record::{ProcessorRows, ShardRecord, ShardRecording};

use super::run_event::{RunEvent, ScanEvent};

/// Sums of the events of a run or a shard that its manifest reports.
#[derive(Debug, Default)]
pub struct RunSummary {
    // By index of the data set, up to the last that has events.
    datasets: Vec<DatasetSummary>,
    processors: Vec<ProcessorRows>,
    recordings: Vec<ShardRecording>,
    // Names of detectors with why their boxes are suspect.
    doubts: Vec<(String, String)>,
}

#[derive(Debug, Default)]
struct DatasetSummary {
    n_labels: u64,
    n_labeled_scans: u64,
    n_points_left_out: u64,
    skipped: Vec<SkippedScan>,
}

impl RunSummary {
    pub fn add(&mut self, event: &RunEvent) {
        match event {
            RunEvent::Began { cpu_model } => {
                if self.processors.last().is_none_or(|it| it.cpu_model != *cpu_model) {
                    self.processors.push(ProcessorRows { cpu_model: cpu_model.clone(), n_scan_rows: 0 });
                }
            }
            RunEvent::Scan(scan) => self.add_scan(scan),
            RunEvent::Skipped { dataset_idx, scan, reason } => {
                let skipped = &mut self.dataset(*dataset_idx).skipped;
                // An interrupted run may have met it twice.
                if skipped.iter().all(|it| it.scan != *scan) {
                    skipped.push(SkippedScan { scan: scan.clone(), reason: reason.clone() });
                }
            }
            RunEvent::Doubt { detector, doubt } => self.doubts.push((detector.clone(), doubt.clone())),
            RunEvent::Recorded(recording) => self.recordings.push(recording.clone()),
        }
    }

    fn add_scan(&mut self, scan: &ScanEvent) {
        if let Some(processor) = self.processors.last_mut() {
            processor.n_scan_rows += scan.scans.len() as u64;
        }
        let dataset = self.dataset(scan.dataset_idx);
        dataset.n_labels += scan.n_labels;
        dataset.n_labeled_scans += u64::from(scan.is_labeled);
        dataset.n_points_left_out += scan.n_points_left_out;
    }

    fn dataset(&mut self, index: usize) -> &mut DatasetSummary {
        if self.datasets.len() <= index {
            self.datasets.resize_with(index + 1, DatasetSummary::default);
        }
        &mut self.datasets[index]
    }

    /// The processors that scans were judged on, with the number of rows of each.
    pub fn processors(&self) -> &[ProcessorRows] {
        &self.processors
    }

    /// Writes the sums into `manifest`, whose shard becomes `record`.
    pub fn write_to(self, manifest: &mut Manifest, mut record: ShardRecord) {
        for (dataset_idx, dataset) in self.datasets.into_iter().enumerate() {
            record.parts[dataset_idx].n_labels = dataset.n_labels;
            record.parts[dataset_idx].n_labeled_scans = dataset.n_labeled_scans;
            let entry = &mut manifest.datasets[dataset_idx];
            entry.n_points_left_out = dataset.n_points_left_out;
            entry.skipped_scans.extend(dataset.skipped);
        }
        for (detector, doubt) in self.doubts {
            let entry = manifest.detectors.iter_mut().find(|it| it.name == detector);
            // A run that was interrupted may have looked twice.
            if let Some(entry) = entry.filter(|it| !it.doubts.contains(&doubt)) {
                entry.doubts.push(doubt);
            }
        }
        record.processors = self.processors;
        record.recordings = self.recordings;
        manifest.shard = Some(record);
    }
}
