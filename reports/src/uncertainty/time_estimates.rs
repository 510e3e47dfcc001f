//! Speeds and the whole report, made of the tally of a run.

use crate::numbers::latencies::Latencies;
use crate::numbers::pools::Pool;
use crate::numbers::run_report::{MetricRow, RunReport, RunReportError, Subject};
use crate::numbers::tally::Tally;
use crate::numbers::times::{TimeKind, Times};
use crate::uncertainty::sample::Draw;
use crate::vocabulary::metric::{LatencyStatistic, Metric};

/// The statistics of a report, each with its percentile.
const STATISTICS: [(LatencyStatistic, u32); 6] = [
    (LatencyStatistic::Min, 0),
    (LatencyStatistic::P50, 50),
    (LatencyStatistic::P90, 90),
    (LatencyStatistic::P95, 95),
    (LatencyStatistic::P99, 99),
    (LatencyStatistic::Max, 100),
];

impl Tally {
    /// The report of all rows that were added: rates of each data set, then times; and both for all data sets together.
    ///
    /// `scoring_version` is that of the rules by which the detections were judged.
    ///
    /// # Errors
    ///
    /// [`RunReportError`] if two numbers say the same thing.
    pub fn report(&self, scoring_version: u32, draws: &[Draw]) -> Result<RunReport, RunReportError> {
        let mut rows = self.metric_rows_of(draws);
        rows.extend(self.time_rows());
        let mut overall = self.overall_rows(draws);
        overall.extend(self.overall_time_rows());
        RunReport::with_overall(scoring_version, rows, overall)
    }

    /// The times of each data set: data set by data set, task by task, detector by detector.
    pub fn time_rows(&self) -> Vec<MetricRow> {
        let datasets = self.datasets().iter().zip(self.times());
        datasets.flat_map(|(dataset, times)| self.times_about(dataset, times)).collect()
    }

    /// The times of all data sets of one origin put together, where there are several.
    pub fn overall_time_rows(&self) -> Vec<MetricRow> {
        let pools = self.pools().into_iter().filter(Pool::is_of_several);
        let rows = pools.flat_map(|pool| {
            let mut all = Times::default();
            let extent = pool.extent.name();
            self.datasets_in(extent).into_iter().for_each(|it| all.add(&self.times()[it]));
            self.times_about(extent, &all)
        });
        rows.collect()
    }

    fn times_about(&self, dataset: &str, times: &Times) -> Vec<MetricRow> {
        let mut rows = Vec::new();
        for &task in self.tasks().iter().filter(|it| it.class().is_none()) {
            for (detector_idx, detector) in self.detectors().iter().enumerate() {
                let subject = Subject::of_all(dataset, task, detector);
                let mut push = |metric, value, n: usize| {
                    rows.push(MetricRow::new(subject.clone(), metric, value, n as u64));
                };
                let of_kind = |kind| Latencies::new(times.scans_ms(kind, task, detector_idx).to_vec());
                let of_scans = of_kind(TimeKind::Latency);
                push(Metric::FpsMean, of_scans.fps_mean(), of_scans.n());
                push(Metric::FpsP50, of_scans.fps_p50(), of_scans.n());
                for (statistic, percent) in STATISTICS {
                    push(Metric::Latency(statistic), of_scans.percentile_ms(percent), of_scans.n());
                }
                let (cpu, overhead) = (of_kind(TimeKind::Cpu), of_kind(TimeKind::Overhead));
                if cpu.n() > 0 {
                    push(Metric::CpuMean, cpu.fps_mean().map(|per_s| 1e3 / per_s), cpu.n());
                }
                if overhead.n() > 0 {
                    push(Metric::OverheadP50, overhead.percentile_ms(50), overhead.n());
                }
                let [n_scans, n_failed] = times.failures(task, detector_idx);
                if n_failed > 0 {
                    push(Metric::FailedScans, Some(n_failed as f64), n_scans as usize);
                }
                for (stage, times_ms) in times.stages_ms(detector_idx) {
                    let of_stage = Latencies::new(times_ms.clone());
                    push(Metric::StageP50(stage.clone()), of_stage.percentile_ms(50), of_stage.n());
                }
            }
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::counts::Counts;
    use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
    use crate::rows::stage_row::StageRow;
    use crate::vocabulary::extent::OVERALL;
    use crate::vocabulary::task::Task;

    fn scan_row(dataset: &str, scan: u32, latency_ms: Option<f64>) -> ScanRow {
        let ([dataset, sequence, detector], task) =
            ([dataset, "0000", "pca"].map(str::to_owned), Task::Vehicles);
        let numbers = ScanNumbers {
            latency_ms,
            least_latency_ms: latency_ms,
            ..ScanNumbers::of_counts(Counts::new(4, 3, Some(2)).unwrap())
        };
        let (time_s, outcome) = (Some(f64::from(scan)), ScanOutcome::Evaluated(numbers));
        ScanRow { dataset, sequence, scan, time_s, detector, task, outcome }
    }

    fn stage_row(dataset: &str, scan: u32, stage: &str, time_ms: f64) -> StageRow {
        let [dataset, sequence, detector, stage] = [dataset, "0000", "pca", stage].map(str::to_owned);
        StageRow { dataset, sequence, scan, detector, stage, time_ms }
    }

    fn value(rows: &[MetricRow], dataset: &str, metric: &Metric) -> Option<(f64, u64)> {
        let row = rows.iter().find(|it| it.subject.dataset == dataset && it.metric == *metric)?;
        Some((row.value()?, row.n))
    }

    #[test]
    fn times_are_of_the_scans_that_were_timed_and_those_of_all_are_put_together() {
        let mut tally = Tally::default();
        for (dataset, times_ms) in [("north", [Some(10.0), Some(30.0), None]), ("south", [Some(20.0); 3])] {
            for (scan, latency_ms) in (0..).zip(times_ms) {
                tally.add_scan(&scan_row(dataset, scan, latency_ms));
                tally.add_stage(&stage_row(dataset, scan, "svm", 1.0 + f64::from(scan)));
                tally.add_stage(&stage_row(dataset, scan, "grid", 5.0));
            }
        }
        let report = tally.report(1, &tally.draw()).unwrap();
        let median = Metric::Latency(LatencyStatistic::P50);
        assert_eq!(value(report.rows(), "north", &Metric::FpsMean), Some((50.0, 2)));
        assert_eq!(value(report.rows(), "north", &median), Some((10.0, 2)));
        assert_eq!(value(report.rows(), "south", &Metric::FpsP50), Some((50.0, 3)));
        assert_eq!(value(report.overall(), OVERALL, &median), Some((20.0, 5)));
        let stages = report.overall().iter().filter_map(|it| match &it.metric {
            Metric::StageP50(stage) => Some((stage.as_str(), it.value()?, it.n)),
            _ => None,
        });
        // In the order of the work, not of the alphabet.
        assert_eq!(stages.collect::<Vec<_>>(), [("svm", 2.0, 6), ("grid", 5.0, 6)]);
    }

    #[test]
    fn what_was_not_timed_has_a_row_without_a_number() {
        let mut tally = Tally::default();
        tally.add_scan(&scan_row("north", 0, None));
        let rows = tally.time_rows();
        assert_eq!(rows.len(), 2 + STATISTICS.len());
        assert!(rows.iter().all(|it| it.value().is_none() && it.n == 0));
        assert!(tally.overall_time_rows().is_empty());
    }

    #[test]
    fn counts_so_far_are_those_of_the_scans_so_far() {
        let mut tally = Tally::default();
        assert_eq!(tally.counts("north", Task::Vehicles, "pca"), None);
        for n_scans in 1..4 {
            tally.add_scan(&scan_row("north", n_scans, None));
            let n = u64::from(n_scans);
            let expected = Counts::new(4 * n, 3 * n, Some(2 * n));
            assert_eq!(tally.counts("north", Task::Vehicles, "pca"), expected);
        }
        let mut unknowable = scan_row("north", 9, None);
        if let ScanOutcome::Evaluated(numbers) = &mut unknowable.outcome {
            numbers.counts = Counts::new(1, 1, None).unwrap();
        }
        tally.add_scan(&unknowable);
        assert_eq!(tally.counts("north", Task::Vehicles, "pca"), Counts::new(13, 10, None));
    }
}
