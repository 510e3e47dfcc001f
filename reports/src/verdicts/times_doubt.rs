//! Doubts about the times of a run: a busy machine, and single scans that took long.

use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::run_report::{RunReport, Subject};
use crate::run_folder::manifest::{DetectorEntry, Manifest};
use crate::vocabulary::metric::{LatencyStatistic, Metric};

/// A built-in detector waits for nothing but processors: a smaller share of its time on them means a busy machine.
const BUSY: f64 = 0.9;
/// A scan that takes so many times the median is an outlier.
const OUTLIER: f64 = 5.0;

/// A number of a detector on a data set, above zero.
fn value(report: &RunReport, dataset: &str, detector: &str, metric: &Metric) -> Option<f64> {
    let subject = Subject::of_all(dataset, report.first_task()?, detector);
    report.row(&subject, metric)?.value().filter(|it| *it > 0.0)
}

/// The share of its time that `detector` had a processor on `dataset`, if a busy machine kept it waiting, which makes its
/// times unreliable.
pub fn share_on_busy_machine(report: &RunReport, dataset: &str, detector: &DetectorEntry) -> Option<f64> {
    let value = |metric| value(report, dataset, &detector.name, &metric);
    let share = value(Metric::CpuMean)? * value(Metric::FpsMean)? / 1e3;
    (detector.foreign.is_none() && share < BUSY).then_some(share)
}

/// The strongest doubt of each kind about the times, in sentences; empty if there is none.
pub fn times_doubts(manifest: &Manifest, report: &RunReport) -> Vec<String> {
    let mut least_share: Option<(f64, String)> = None;
    let mut longest: Option<(f64, String)> = None;
    for dataset in &manifest.datasets {
        for detector in &manifest.detectors {
            let value = |metric| value(report, &dataset.id, &detector.name, &metric);
            let about = || format!("{} on {}", detector.name, dataset.id);
            if let Some(share) = share_on_busy_machine(report, &dataset.id, detector)
                && least_share.as_ref().is_none_or(|it| share < it.0)
            {
                least_share = Some((share, about()));
            }
            let [median, most] =
                [LatencyStatistic::P50, LatencyStatistic::Max].map(|it| value(Metric::Latency(it)));
            if let Some(times) = median.zip(most).map(|(median, most)| most / median)
                && times > longest.as_ref().map_or(OUTLIER, |it| it.0)
            {
                longest = Some((times, about()));
            }
        }
    }
    let busy = least_share.map(|(share, about)| {
        let percent = fixed_decimals(100.0 * share, 0);
        format!(
            "Times are unreliable: the machine was busy. {about} had a processor for {percent} % of its time."
        )
    });
    let outlier = longest.map(|(times, about)| {
        let times = fixed_decimals(times, 1);
        format!("Times have outliers: the slowest scan of {about} took {times} times the median.")
    });
    busy.into_iter().chain(outlier).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::run_report::MetricRow;
    use crate::tables::sample;
    use crate::vocabulary::task::Task;

    /// Doubts about a detector with this mean time on processors and this longest time, whose mean and median are 100 ms.
    fn doubts(cpu_ms: f64, longest_ms: f64) -> Vec<String> {
        let mut manifest = sample::manifest();
        manifest.datasets.truncate(1);
        manifest.detectors.truncate(1);
        let subject =
            || Subject::of_all(&manifest.datasets[0].id, Task::Objects, &manifest.detectors[0].name);
        let numbers = [
            (Metric::FpsMean, 10.0),
            (Metric::CpuMean, cpu_ms),
            (Metric::Latency(LatencyStatistic::P50), 100.0),
            (Metric::Latency(LatencyStatistic::Max), longest_ms),
        ];
        let rows = numbers.map(|(metric, value)| MetricRow::new(subject(), metric, Some(value), 20));
        times_doubts(&manifest, &RunReport::new(1, rows.to_vec()).unwrap())
    }

    #[test]
    fn a_busy_machine_and_outliers_are_said() {
        assert_eq!(doubts(99.0, 300.0), [""; 0]);
        let said = doubts(62.0, 830.0).join(" ");
        assert!(said.contains("had a processor for 62 % of its time"), "{said}");
        assert!(said.contains("took 8.3 times the median"), "{said}");
    }
}
