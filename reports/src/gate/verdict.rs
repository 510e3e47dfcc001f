//! Whether a run is as good as the one that was accepted.

use crate::bootstrap::{Distribution, Resamples};
use crate::estimates::{Question, Sample};
use crate::gate::comparability::{NotComparable, check_comparable};
use crate::gate::drift::{ScanDrift, drift};
use crate::gate::paired_difference::{PairedDifference, paired_difference};
use crate::gate::tolerances::{SpeedRule, Tolerances};
use crate::metric::Metric;
use crate::run_archive::RunArchive;
use crate::run_report::{Interval, OVERALL};
use crate::slice::Slice;
use crate::tally::Tally;

/// What came of a gate.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Everything that is gated, task by task, detector by detector, slice by slice.
    pub metrics: Vec<GatedMetric>,
    /// How fast detectors are beside the reference.
    pub speeds: Vec<GatedSpeed>,
    /// Scans on which a detector is judged otherwise than before.
    pub drift: Vec<ScanDrift>,
}

/// A number that is gated.
#[derive(Debug, Clone, PartialEq)]
pub struct GatedMetric {
    /// Name of the task.
    pub task: String,
    /// Name of the detector.
    pub detector: String,
    /// Name of the slice.
    pub slice: String,
    /// What was measured.
    pub metric: Metric,
    /// Before and after; `None` if it is undefined in the run but not in the baseline.
    pub difference: Option<PairedDifference>,
    /// How much worse it may become.
    pub tolerance: f64,
    /// What that means.
    pub finding: Finding,
}

/// How long a detector takes, divided by how long the reference takes on the same scans: the geometric mean over scans.
#[derive(Debug, Clone, PartialEq)]
pub struct GatedSpeed {
    /// Name of the detector.
    pub detector: String,
    /// Name of the reference.
    pub reference: String,
    /// The ratio in the baseline.
    pub before: f64,
    /// The ratio in the run.
    pub after: f64,
    /// How sure it is how much slower it has become, as a share: 0.1 is a tenth slower.
    pub slowdown_interval: Option<Interval>,
    /// How much slower it may become, as a share.
    pub tolerance: f64,
    /// What that means.
    pub finding: Finding,
}

/// What a difference means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Finding {
    /// Surely worse than tolerated.
    Regression,
    /// There is no number any more, so nothing can be said.
    Incomparable,
    /// Worse than tolerated, but it may be chance.
    Inconclusive,
    /// Not worse than tolerated.
    Pass,
}

/// What a verdict comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Conclusion {
    /// Something is surely worse.
    Regression,
    /// Something that was measured before is not measured now.
    Incomparable,
    /// Nothing is surely worse, but something is judged otherwise.
    Drift,
    /// Everything is as it was.
    Same,
}

impl Finding {
    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Regression => "regression",
            Self::Incomparable => "incomparable",
            Self::Inconclusive => "inconclusive",
            Self::Pass => "pass",
        }
    }

    /// What `worsening` means, of which `low` is the lower end of the interval.
    fn of(worsening: f64, low: Option<f64>, tolerance: f64) -> Self {
        if low.is_some_and(|it| it > tolerance) {
            Self::Regression
        } else if worsening > tolerance {
            Self::Inconclusive
        } else {
            Self::Pass
        }
    }
}

impl Conclusion {
    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Regression => "regression",
            Self::Incomparable => "incomparable",
            Self::Drift => "drift",
            Self::Same => "same",
        }
    }
}

impl Verdict {
    /// What it comes to.
    pub fn conclusion(&self) -> Conclusion {
        let findings = || {
            let of_metrics = self.metrics.iter().map(|it| it.finding);
            of_metrics.chain(self.speeds.iter().map(|it| it.finding))
        };
        if findings().any(|it| it == Finding::Regression) {
            Conclusion::Regression
        } else if findings().any(|it| it == Finding::Incomparable) {
            Conclusion::Incomparable
        } else if !self.drift.is_empty() {
            Conclusion::Drift
        } else {
            Conclusion::Same
        }
    }

    /// Number of gated numbers with this finding.
    pub fn n(&self, finding: Finding) -> usize {
        let of_metrics = self.metrics.iter().filter(|it| it.finding == finding).count();
        of_metrics + self.speeds.iter().filter(|it| it.finding == finding).count()
    }
}

/// Judges `run` by `baseline`.
///
/// # Errors
///
/// [`NotComparable`] if it cannot be done.
pub fn judge(
    baseline: &RunArchive,
    run: &RunArchive,
    tolerances: &Tolerances,
) -> Result<Verdict, NotComparable> {
    check_comparable(baseline, run)?;
    let sides = Sides { before: baseline.tally(), after: run.tally() };
    let draws = sides.before.draw();
    let speed = tolerances.speed.as_ref();
    Ok(Verdict {
        metrics: sides.gated_metrics(tolerances, &draws),
        speeds: match speed {
            Some(rule) => sides.gated_speeds(rule, &draws)?,
            None => Vec::new(),
        },
        drift: drift(baseline, run),
    })
}

struct Sides {
    before: Tally,
    after: Tally,
}

impl Sides {
    fn gated_metrics(&self, tolerances: &Tolerances, draws: &[Resamples]) -> Vec<GatedMetric> {
        let metrics = tolerances.metrics();
        let mut gated = Vec::new();
        for task in self.before.tasks() {
            for detector in self.before.detectors() {
                for slice in &self.before.slices(task, detector) {
                    let question = Question { dataset: OVERALL, task, detector, slice };
                    let name = slice.name();
                    let is_gated = |it: &&Metric| tolerances.of(it, task, &name, 0.0).is_some();
                    let wanted: Vec<&Metric> = metrics.iter().filter(is_gated).collect();
                    if wanted.is_empty() {
                        continue;
                    }
                    let Some(before) = self.before.sample(&question, draws) else { continue };
                    let after = self.after.sample(&question, draws);
                    gated.extend(wanted.into_iter().filter_map(|metric| {
                        gated_metric(&question, metric, &before, after.as_ref(), tolerances)
                    }));
                }
            }
        }
        gated
    }

    fn gated_speeds(&self, rule: &SpeedRule, draws: &[Resamples]) -> Result<Vec<GatedSpeed>, NotComparable> {
        let Some(task) = self.before.tasks().first() else { return Ok(Vec::new()) };
        let slice = Slice::All;
        let sample = |tally: &Tally, detector: &str| {
            tally.sample(&Question { dataset: OVERALL, task, detector, slice: &slice }, draws)
        };
        let is_there = |it: &Tally| it.detectors().contains(&rule.reference);
        if !is_there(&self.before) || !is_there(&self.after) {
            let reason = format!("{}, by which times are measured, was not run", rule.reference);
            return Err(NotComparable { reasons: vec![reason] });
        }
        let rivals = self.before.detectors().iter().filter(|it| **it != rule.reference);
        let speeds = rivals.filter_map(|detector| {
            let [before, after] = [&self.before, &self.after]
                .map(|tally| Some([sample(tally, detector)?, sample(tally, &rule.reference)?]));
            gated_speed(detector, rule, &before?, &after?)
        });
        Ok(speeds.collect())
    }
}

/// `None` if there is nothing to compare with.
fn gated_metric(
    question: &Question<'_>,
    metric: &Metric,
    before: &Sample,
    after: Option<&Sample>,
    tolerances: &Tolerances,
) -> Option<GatedMetric> {
    let value_before = before.value(metric)?;
    let slice = question.slice.name();
    let tolerance = tolerances.of(metric, question.task, &slice, value_before)?;
    let difference = after.and_then(|it| paired_difference(before, it, metric));
    let finding = difference.as_ref().map_or(Finding::Incomparable, |it| {
        Finding::of(it.worsening(), it.worsening_interval().map(|[low, _]| low), tolerance)
    });
    let [task, detector] = [question.task, question.detector].map(str::to_owned);
    Some(GatedMetric { task, detector, slice, metric: metric.clone(), difference, tolerance, finding })
}

/// A detector and the reference, before and after; `None` if one of them was not timed.
fn gated_speed(
    detector: &str,
    rule: &SpeedRule,
    before: &[Sample; 2],
    after: &[Sample; 2],
) -> Option<GatedSpeed> {
    let log_ratio = |[own, reference]: &[Sample; 2]| {
        Some(own.total.mean_log_latency()? - reference.total.mean_log_latency()?)
    };
    let (log_before, log_after) = (log_ratio(before)?, log_ratio(after)?);
    let n_resamples = before[0].resampled.len();
    let slowdowns = (0..n_resamples).map(|resample_idx| {
        let log_of = |sample: &Sample| sample.resampled[resample_idx].mean_log_latency();
        let of_side = |[own, reference]: &[Sample; 2]| Some(log_of(own)? - log_of(reference)?);
        Some((of_side(after)? - of_side(before)?).exp() - 1.0)
    });
    let slowdown_interval = Distribution::new(slowdowns, before[0].n_blocks).map(|it| it.interval());
    let slowdown = (log_after - log_before).exp() - 1.0;
    let low = slowdown_interval.map(|it| it.ends[0]);
    Some(GatedSpeed {
        detector: detector.to_owned(),
        reference: rule.reference.clone(),
        before: log_before.exp(),
        after: log_after.exp(),
        slowdown_interval,
        tolerance: rule.relative,
        finding: Finding::of(slowdown, low, rule.relative),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Counts;
    use crate::gate::tolerances::QualityRule;
    use crate::run_report::{RunReport, SLICE_ALL};
    use crate::scan_row::{ScanNumbers, ScanOutcome, ScanRow, SegmentationNumbers};
    use crate::table::sample;

    const N_SCANS: u32 = 30;

    /// Thirty scans a second apart, each with ten annotations, of which `tp_of` says how many the detector `pca` finds; the
    /// detector `kd-tree` takes 100 ms and `pca` as long as `ms_of` says.
    fn archive(tp_of: impl Fn(u32) -> u64, ms_of: impl Fn(u32) -> f64) -> RunArchive {
        let row = |scan: u32, detector: &str, tp: u64, latency_ms: f64| {
            let [dataset, sequence, detector, task] =
                ["main_road", "0000", detector, "objects"].map(str::to_owned);
            let numbers = ScanNumbers {
                n_points: 1000,
                latency_ms: Some(latency_ms),
                counts: Counts::new(10, tp, Some(2)).unwrap(),
                n_ignored_annotations: 0,
                n_ignored_detections: 0,
                n_unknowable_detections: 0,
                segmentation: SegmentationNumbers::default(),
                n_dropped_too_small: 0,
                n_dropped_too_large: 0,
            };
            ScanRow { dataset, sequence, scan, detector, task, outcome: ScanOutcome::Evaluated(numbers) }
        };
        let scans = (0..N_SCANS).flat_map(|step| {
            [row(10 * step, "kd-tree", 5, 100.0), row(10 * step, "pca", tp_of(step), ms_of(step))]
        });
        RunArchive {
            manifest: sample::manifest(),
            report: RunReport::new(1, Vec::new()).unwrap(),
            scans: scans.collect(),
            matches: Vec::new(),
        }
    }

    fn tolerances() -> Tolerances {
        let rule = QualityRule {
            metrics: vec!["recall".to_owned()],
            slices: vec![SLICE_ALL.to_owned()],
            tasks: None,
            absolute: 0.02,
            relative: 0.0,
        };
        let speed = SpeedRule { reference: "kd-tree".to_owned(), relative: 0.25 };
        Tolerances { quality: vec![rule], speed: Some(speed) }
    }

    /// Recall is 0.7 or 0.5, turn by turn, in the baseline, and time 10 ms.
    fn judged(tp_of: impl Fn(u32) -> u64, ms_of: impl Fn(u32) -> f64) -> Verdict {
        let baseline = archive(|step| 7 - 2 * u64::from(step % 2 == 1), |_| 10.0);
        judge(&baseline, &archive(tp_of, ms_of), &tolerances()).unwrap()
    }

    #[track_caller]
    fn check_quality(tp_of: impl Fn(u32) -> u64, expected: Finding) {
        let verdict = judged(tp_of, |_| 10.0);
        let [_, pca] = verdict.metrics.as_slice() else { panic!("{verdict:?}") };
        assert_eq!((pca.detector.as_str(), pca.finding), ("pca", expected), "{pca:?}");
        assert!(verdict.drift.len() <= N_SCANS as usize && verdict.speeds[0].finding == Finding::Pass);
    }

    #[test]
    fn one_object_less_in_every_scan_is_surely_worse() {
        check_quality(|step| 6 - 2 * u64::from(step % 2 == 1), Finding::Regression);
    }

    #[test]
    fn much_worse_in_two_scans_and_as_before_in_all_others_may_be_chance() {
        check_quality(
            |step| if step < 2 { 0 } else { 7 - 2 * u64::from(step % 2 == 1) },
            Finding::Inconclusive,
        );
    }

    #[test]
    fn a_little_worse_is_tolerated_and_better_is_no_worse() {
        check_quality(|step| if step == 0 { 6 } else { 7 - 2 * u64::from(step % 2 == 1) }, Finding::Pass);
        check_quality(|_| 10, Finding::Pass);
        assert_eq!(judged(|_| 10, |_| 10.0).conclusion(), Conclusion::Drift);
    }

    #[track_caller]
    fn check_speed(ms_of: impl Fn(u32) -> f64, expected: Finding, expected_slowdown: f64) {
        let verdict = judged(|step| 7 - 2 * u64::from(step % 2 == 1), ms_of);
        let speed = &verdict.speeds[0];
        assert_eq!(speed.finding, expected, "{speed:?}");
        assert!((speed.after / speed.before - 1.0 - expected_slowdown).abs() < 1e-9, "{speed:?}");
        assert!(verdict.drift.is_empty(), "times are no drift");
    }

    #[test]
    fn twice_the_time_is_a_regression_and_one_slow_scan_is_not() {
        check_speed(|_| 10.0, Finding::Pass, 0.0);
        check_speed(|_| 20.0, Finding::Regression, 1.0);
        check_speed(|_| 5.0, Finding::Pass, -0.5);
        // One scan of thirty takes 2^30 times as long: the geometric mean doubles.
        let once = |step| if step == 0 { 10.0 * 2_f64.powi(30) } else { 10.0 };
        check_speed(once, Finding::Inconclusive, 1.0);
    }

    #[test]
    fn a_number_that_is_there_no_more_is_not_comparable() {
        let mut run = archive(|_| 5, |_| 10.0);
        run.scans.retain(|it| it.detector == "kd-tree");
        let error = judge(&archive(|_| 5, |_| 10.0), &run, &tolerances()).unwrap_err();
        assert!(error.to_string().contains("pca was not run"), "{error}");
        let mut rule = tolerances();
        rule.speed = Some(SpeedRule { reference: "simple-grid".to_owned(), relative: 0.1 });
        let error = judge(&archive(|_| 5, |_| 10.0), &archive(|_| 5, |_| 10.0), &rule).unwrap_err();
        assert!(error.to_string().contains("simple-grid, by which times are measured"), "{error}");
    }
}
