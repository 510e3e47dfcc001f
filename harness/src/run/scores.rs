//! The numbers of a data set, gathered scan by scan.

use std::time::Duration;

use reports::metric::{LatencyStatistic, Metric};
use reports::run_report::{MetricRow, SLICE_ALL, Subject};

use crate::annotation::LabeledScan;
use crate::dataset::DatasetDescription;
use crate::metrics::counts::{Counts, FalseDetections};
use crate::metrics::latency::Latencies;
use crate::metrics::segmentation_quality::SegmentationQuality;
use crate::run::side_by_side::DetectorScan;
use crate::task::Task;

/// Everything measured on one data set.
#[derive(Debug, Clone)]
pub struct DatasetScores {
    dataset: DatasetDescription,
    n_scans: u64,
    detectors: Vec<DetectorScores>,
}

#[derive(Debug, Clone)]
struct DetectorScores {
    name: &'static str,
    latencies: Vec<Duration>,
    // In the order of the stages.
    stages: Vec<(&'static str, Vec<Duration>)>,
    // One for each of `Task::ALL`.
    tasks: Vec<TaskScores>,
}

#[derive(Debug, Clone, Copy, Default)]
struct TaskScores {
    counts: Counts,
    segmentation: SegmentationQuality,
}

impl DatasetScores {
    /// Nothing measured yet.
    pub fn new(dataset: DatasetDescription, detectors: &[&'static str]) -> Self {
        let of_detector = |&name: &&'static str| DetectorScores {
            name,
            latencies: Vec::new(),
            stages: Vec::new(),
            tasks: vec![TaskScores::default(); Task::ALL.len()],
        };
        Self { dataset, n_scans: 0, detectors: detectors.iter().map(of_detector).collect() }
    }

    /// Adds what the detectors, in the order given to [`Self::new`], made of `scan`.
    pub fn add(&mut self, scan: &LabeledScan, results: &[DetectorScan]) {
        self.n_scans += 1;
        for (scores, result) in self.detectors.iter_mut().zip(results) {
            scores.latencies.push(result.latency);
            for stage_time in &result.output.stage_times {
                scores.add_stage_time(stage_time.stage, stage_time.duration);
            }
            for (task_scores, assignment) in scores.tasks.iter_mut().zip(&result.assignments) {
                task_scores.counts += Counts::of(assignment);
                task_scores.segmentation +=
                    SegmentationQuality::of(scan, &result.output.detections, assignment);
            }
        }
    }

    /// Scans added so far.
    pub fn n_scans(&self) -> u64 {
        self.n_scans
    }

    /// Annotations that counted so far, of any task and any detector.
    pub fn n_annotations(&self) -> u64 {
        let tasks = self.detectors.iter().flat_map(|detector| &detector.tasks);
        tasks.map(|task| task.counts.n_annotations).max().unwrap_or(0)
    }

    /// F-rate so far of detector number `detector_idx`, for each of [`Task::ALL`].
    pub fn f_rates(&self, detector_idx: usize) -> Vec<(Task, Option<f64>)> {
        let scores = &self.detectors[detector_idx];
        let f_rate = |(&task, task_scores): (&Task, &TaskScores)| {
            let known = FalseDetections::of(&self.dataset.annotated, task);
            (task, task_scores.counts.scored(known).f_rate())
        };
        Task::ALL.iter().zip(&scores.tasks).map(f_rate).collect()
    }

    /// All numbers, task by task and detector by detector.
    pub fn metric_rows(&self) -> Vec<MetricRow> {
        let mut rows = Vec::new();
        for (task_idx, &task) in Task::ALL.iter().enumerate() {
            for detector in &self.detectors {
                let subject = Subject {
                    dataset: self.dataset.id.clone(),
                    task: task.name().to_owned(),
                    detector: detector.name.to_owned(),
                    slice: SLICE_ALL.to_owned(),
                };
                let known = FalseDetections::of(&self.dataset.annotated, task);
                let mut push =
                    |metric, value, n| rows.push(MetricRow::new(subject.clone(), metric, value, n));
                self.push_counts(&detector.tasks[task_idx], known, &mut push);
                detector.push_times(&mut push);
            }
        }
        rows
    }

    fn push_counts(
        &self,
        scores: &TaskScores,
        known: FalseDetections,
        push: &mut impl FnMut(Metric, Option<f64>, u64),
    ) {
        let counts = scores.counts.scored(known);
        let segmentation = &scores.segmentation;
        let as_value = |count: u64| Some(count as f64);
        push(Metric::No, as_value(counts.no()), self.n_scans);
        push(Metric::Tp, as_value(counts.tp()), self.n_scans);
        push(Metric::Mo, as_value(counts.mo()), self.n_scans);
        push(Metric::Fo, counts.fo().and_then(as_value), self.n_scans);
        push(Metric::Precision, counts.precision(), counts.nd().unwrap_or(0));
        push(Metric::Recall, counts.recall(), counts.no());
        push(Metric::FRate, counts.f_rate(), counts.nd().map_or(0, |nd| counts.no() + nd));
        push(Metric::IgnoredAnnotations, as_value(scores.counts.n_ignored_annotations), self.n_scans);
        push(Metric::IgnoredDetections, as_value(scores.counts.n_ignored_detections), self.n_scans);
        push(Metric::UnknowableDetections, as_value(scores.counts.n_unknowable), self.n_scans);
        push(Metric::OverSegmentation, segmentation.over_segmentation(), segmentation.n_annotations);
        push(Metric::UnderSegmentation, segmentation.under_segmentation(), segmentation.n_holding);
    }
}

impl DetectorScores {
    fn add_stage_time(&mut self, stage: &'static str, duration: Duration) {
        match self.stages.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, durations)) => durations.push(duration),
            None => self.stages.push((stage, vec![duration])),
        }
    }

    fn push_times(&self, push: &mut impl FnMut(Metric, Option<f64>, u64)) {
        let latencies = Latencies::new(self.latencies.clone());
        let n = latencies.n() as u64;
        let in_ms = |duration: Duration| duration.as_secs_f64() * 1e3;
        push(Metric::FpsMean, latencies.fps_mean(), n);
        for (statistic, percent) in [
            (LatencyStatistic::Min, 0),
            (LatencyStatistic::P50, 50),
            (LatencyStatistic::P90, 90),
            (LatencyStatistic::P95, 95),
            (LatencyStatistic::P99, 99),
            (LatencyStatistic::Max, 100),
        ] {
            push(Metric::Latency(statistic), latencies.percentile(percent).map(in_ms), n);
        }
        for (stage, durations) in &self.stages {
            let durations = Latencies::new(durations.clone());
            let p50 = durations.percentile(50).map(in_ms);
            push(Metric::StageP50((*stage).to_owned()), p50, durations.n() as u64);
        }
    }
}
