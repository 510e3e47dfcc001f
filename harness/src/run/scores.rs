//! F-rates so far, and the times, of a data set, gathered scan by scan.

use std::time::Duration;

use reports::numbers::run_report::{MetricRow, Subject};
use reports::vocabulary::extent::OVERALL;
use reports::vocabulary::metric::{LatencyStatistic, Metric};
use reports::vocabulary::task::Task;

use crate::dataset::DatasetDescription;
use crate::metrics::counts::{Counts, FalseDetections};
use crate::metrics::latency::Latencies;
use crate::run::side_by_side::DetectorScan;

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
    tasks: Vec<Counts>,
}

impl DatasetScores {
    /// Nothing measured yet.
    pub fn new(dataset: DatasetDescription, detectors: &[&'static str]) -> Self {
        let of_detector = |&name: &&'static str| DetectorScores {
            name,
            latencies: Vec::new(),
            stages: Vec::new(),
            tasks: vec![Counts::default(); Task::ALL.len()],
        };
        Self { dataset, n_scans: 0, detectors: detectors.iter().map(of_detector).collect() }
    }

    /// Adds what the detectors, in the order given to [`Self::new`], made of a scan.
    pub fn add(&mut self, results: &[DetectorScan]) {
        self.n_scans += 1;
        for (scores, result) in self.detectors.iter_mut().zip(results) {
            scores.latencies.push(result.times.first);
            for stage_time in &result.output.stage_times {
                scores.add_stage_time(stage_time.stage, stage_time.duration);
            }
            for (counts, assignment) in scores.tasks.iter_mut().zip(&result.assignments) {
                *counts += Counts::of(assignment);
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
        tasks.map(|counts| counts.n_annotations).max().unwrap_or(0)
    }

    /// F-rate so far of detector number `detector_idx`, for each of [`Task::ALL`].
    pub fn f_rates(&self, detector_idx: usize) -> Vec<(Task, Option<f64>)> {
        let scores = &self.detectors[detector_idx];
        let f_rate = |(&task, counts): (&Task, &Counts)| {
            let known = FalseDetections::of(&self.dataset.annotated, task);
            (task, counts.scored(known).f_rate())
        };
        Task::ALL.iter().zip(&scores.tasks).map(f_rate).collect()
    }

    /// The times, task by task and detector by detector.
    pub fn time_rows(&self) -> Vec<MetricRow> {
        time_rows(&self.dataset.id, &self.detectors)
    }
}

/// The times of all data sets together; none if there is only one.
pub fn overall_time_rows(datasets: &[DatasetScores]) -> Vec<MetricRow> {
    let [first, rest @ ..] = datasets else { return Vec::new() };
    if rest.is_empty() {
        return Vec::new();
    }
    let mut detectors = first.detectors.clone();
    for dataset in rest {
        for (all, detector) in detectors.iter_mut().zip(&dataset.detectors) {
            all.latencies.extend(&detector.latencies);
            for (stage, durations) in &detector.stages {
                for &duration in durations {
                    all.add_stage_time(stage, duration);
                }
            }
        }
    }
    time_rows(OVERALL, &detectors)
}

fn time_rows(dataset: &str, detectors: &[DetectorScores]) -> Vec<MetricRow> {
    let mut rows = Vec::new();
    for task in Task::ALL {
        for detector in detectors {
            let subject = Subject::of_all(dataset, task, detector.name);
            detector.push_times(&mut |metric, value, n| {
                rows.push(MetricRow::new(subject.clone(), metric, value, n));
            });
        }
    }
    rows
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
        push(Metric::FpsP50, latencies.fps_p50(), n);
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
