//! A small run in a folder, for the tests of the page.

use std::path::Path;

use tempfile::TempDir;

use crate::files::csv_rows::{CsvRow, to_csv_bytes};
use crate::numbers::run_report::{MetricRow, RunReport, Subject};
use crate::rows::counts::Counts;
use crate::rows::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, MatchOutcome, MotionFacts};
use crate::rows::match_row::MatchRow;
use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
use crate::run_folder::manifest::{DatasetEntry, Manifest};
use crate::run_folder::run_directory::{MATCHES_CSV, PRECISION_RECALL_CSV, REPORT_JSON, SCANS_CSV};
use crate::run_folder::run_target::MANIFEST_JSON;
use crate::tables::sample;
use crate::vocabulary::class::{AnnotationClass, DetectionClass};
use crate::vocabulary::criterion::CriterionKind;
use crate::vocabulary::metric::{LatencyStatistic, Metric};
use crate::vocabulary::reason::{FalseReason, MissReason};
use crate::vocabulary::task::Task;

/// Content of the run.
pub(super) struct SampleRun<'a> {
    pub(super) datasets: &'a [&'a str],
    /// The first one finds all but one of ten objects on every scan, each next one finds one fewer.
    pub(super) detectors: &'a [&'a str],
    pub(super) tasks: &'a [Task],
    /// Class of the annotations.
    pub(super) class: AnnotationClass,
    /// Number of scans, each in a second of its own.
    pub(super) n_blocks: u32,
    /// Number of the first scans to which the last detector gave no answer.
    pub(super) n_failed: u32,
    /// Share of its time in which each detector has a processor.
    pub(super) processor_share: f64,
    /// Distance of the false detection ahead of the sensor, in metres.
    pub(super) false_m: f32,
}

/// Three detectors on a simulated street.
pub(super) const USUAL: SampleRun<'_> = SampleRun {
    datasets: &["main_road"],
    detectors: &["hierarchical", "kd-tree", "pca"],
    tasks: &Task::ALL,
    class: AnnotationClass::Car,
    n_blocks: 12,
    n_failed: 0,
    processor_share: 1.0,
    false_m: 60.0,
};

const N_OBJECTS: u64 = 10;

/// Whether false objects can be known, as in all simulated data sets. KITTI is recorded.
fn knows_false(dataset: &str) -> bool {
    !dataset.starts_with("kitti")
}

impl SampleRun<'_> {
    /// Writes the files that a page is made of.
    pub(super) fn write(&self) -> TempDir {
        let folder = tempfile::tempdir().unwrap();
        let manifest = self.manifest();
        let mut tally = manifest.tally();
        let (scans, matches) = (self.scans(), self.matches());
        for row in &scans {
            tally.add_scan(row);
        }
        for row in &matches {
            tally.add_match(row);
        }
        write_rows(&folder.path().join(SCANS_CSV), &scans);
        write_rows(&folder.path().join(MATCHES_CSV), &matches);
        write_rows(&folder.path().join(PRECISION_RECALL_CSV), &tally.precision_recall_rows());
        let of_datasets = self.datasets.iter().flat_map(|it| self.times(it));
        let rows = tally.metric_rows().into_iter().chain(of_datasets).collect();
        let mut overall = tally.overall_rows(&tally.draw());
        for pool in manifest.pools().iter().filter(|it| it.is_of_several()) {
            overall.extend(self.times(pool.extent.name()));
        }
        let report = RunReport::with_overall(1, rows, overall).unwrap();
        std::fs::write(folder.path().join(REPORT_JSON), report.to_json()).unwrap();
        std::fs::write(folder.path().join(MANIFEST_JSON), manifest.to_json()).unwrap();
        folder
    }

    fn manifest(&self) -> Manifest {
        let mut manifest = sample::manifest();
        let entries = manifest.datasets;
        let named = |id: &&str| {
            let entry = entries[usize::from(!knows_false(id))].clone();
            DatasetEntry { id: (*id).to_owned(), ..entry }
        };
        manifest.datasets = self.datasets.iter().map(named).collect();
        manifest.detectors = self.detectors.iter().map(|it| sample::detector(it)).collect();
        manifest.argv = ["scanbench", "run", "it's <here>"].map(str::to_owned).to_vec();
        manifest
    }

    /// The rows that `row` makes of every data set, detector with its index, task and scan.
    fn each<Row>(&self, row: impl Fn(&str, (usize, &str), Task, u32) -> Vec<Row>) -> Vec<Row> {
        let mut rows = Vec::new();
        for dataset in self.datasets {
            for scan in 0..self.n_blocks {
                for (detector_idx, detector) in self.detectors.iter().enumerate() {
                    for &task in self.tasks {
                        rows.extend(row(dataset, (detector_idx, detector), task, 10 * scan));
                    }
                }
            }
        }
        rows
    }

    fn n_missed(detector_idx: usize) -> u64 {
        1 + detector_idx as u64
    }

    fn scans(&self) -> Vec<ScanRow> {
        self.each(|dataset, (detector_idx, detector), task, scan| {
            let fo = (knows_false(dataset) || task == Task::Vehicles).then_some(1);
            let tp = N_OBJECTS - Self::n_missed(detector_idx);
            let has_failed = detector_idx + 1 == self.detectors.len() && scan < 10 * self.n_failed;
            let numbers = ScanNumbers {
                failure: has_failed.then(|| "it closed its pipe".to_owned()),
                latency_ms: Some(10_f64.powi(detector_idx as i32) * (1.0 + f64::from(scan) / 100.0)),
                least_latency_ms: Some(10_f64.powi(detector_idx as i32)),
                reference_ms: Some(0.25),
                ..ScanNumbers::of_counts(Counts::new(N_OBJECTS, tp, fo).unwrap())
            };
            let [dataset, sequence, detector] = [dataset, "drive", detector].map(str::to_owned);
            vec![ScanRow {
                dataset,
                sequence,
                scan,
                time_s: Some(f64::from(scan) / 10.0),
                detector,
                task,
                outcome: ScanOutcome::Evaluated(numbers),
            }]
        })
    }

    fn matches(&self) -> Vec<MatchRow> {
        self.each(|dataset, (detector_idx, detector), task, scan| {
            let n_found = N_OBJECTS - Self::n_missed(detector_idx);
            let of_annotations = (0..N_OBJECTS).map(|id| {
                let (track, bounding_box) = (Some(id as u32), Some(box_at(id)));
                let without_position = AnnotationFacts::without_position(self.class, 100 + id);
                let annotation = AnnotationFacts { id, track, bounding_box, ..without_position };
                if id < n_found {
                    MatchOutcome::Matched { annotation, detection: detection(id), cost: 0.1 }
                } else {
                    MatchOutcome::Missed { annotation, reason: MissReason::NothingThere }
                }
            });
            let mut false_one = detection(N_OBJECTS);
            false_one.bounding_box.center_m = [self.false_m, 3.0, 0.0];
            let beyond = if knows_false(dataset) || task == Task::Vehicles {
                MatchOutcome::False { detection: false_one, reason: FalseReason::NothingThere }
            } else {
                MatchOutcome::Unknowable { detection: false_one, agreement: None }
            };
            let row = |outcome| {
                let [dataset, sequence, detector] = [dataset, "drive", detector].map(str::to_owned);
                let criterion = CriterionKind::Points;
                MatchRow { dataset, sequence, scan, detector, task, criterion, outcome }
            };
            of_annotations.chain([beyond]).map(row).collect()
        })
    }

    /// Times of all detectors in all tasks on `dataset`.
    fn times(&self, dataset: &str) -> Vec<MetricRow> {
        let mut rows = Vec::new();
        for (detector_idx, detector) in self.detectors.iter().enumerate() {
            for &task in self.tasks {
                let median_ms = 4.0 * 10_f64.powi(detector_idx as i32);
                let subject = Subject::of_all(dataset, task, detector);
                let row = |metric, value| {
                    MetricRow::new(subject.clone(), metric, Some(value), u64::from(self.n_blocks))
                };
                if self.n_failed > 0 && detector_idx + 1 == self.detectors.len() {
                    rows.push(row(Metric::FailedScans, f64::from(self.n_failed)));
                }
                rows.push(row(Metric::FpsMean, 1000.0 / median_ms));
                rows.push(row(Metric::CpuMean, self.processor_share * median_ms));
                rows.push(row(Metric::Latency(LatencyStatistic::P50), median_ms));
                rows.push(row(Metric::StageP50("dense_level".to_owned()), median_ms));
            }
        }
        rows
    }
}

fn box_at(id: u64) -> BoxFacts {
    let center_m = [6.0 * id as f32, 3.0, 0.0];
    BoxFacts { center_m, length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.1 }
}

fn detection(id: u64) -> DetectionFacts {
    let class = DetectionClass::Vehicle;
    DetectionFacts {
        id,
        class,
        score: Some(1.0 - id as f32 / 20.0),
        n_points: 90,
        bounding_box: box_at(id),
        motion: MotionFacts::default(),
    }
}

fn write_rows<Row: CsvRow>(path: &Path, rows: &[Row]) {
    std::fs::write(path, to_csv_bytes(rows).unwrap()).unwrap();
}
