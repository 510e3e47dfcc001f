//! `scanbench selftest`: annotations fed back as detections.

use clap::Args;
use detector::{DetectedClass, Detection, Detections, OrientedBox};
use evaluation::matching::assign::{MatchingParams, assign};
use evaluation::matching::criterion::Criterion;
use evaluation::matching::eligibility::{EligibilityParams, counts_as_vehicle};
use evaluation::matching::outcome::AnnotationOutcome;
use evaluation::metrics::counts::{Counts, FalseDetections};
use reports::rows::counts::Counts as Scored;
use reports::vocabulary::task::Task;
use scans::annotation::{Annotation, LabeledScan};
use scans::dataset::class_table::ClassTable;
use scans::dataset::source::DamagePolicy;

use crate::cli::{DamageArgs, DatasetArgs, ProtocolArgs};
use crate::plumbing::failure::{Failure, NothingEvaluated};
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets_past_damage};
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::standard_streams::print_result;
use crate::verbs::selftest_protocols::check_protocols;

/// Arguments of `scanbench selftest`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  scanbench selftest ../data/kitti_tracking --scans 0..10\n  scanbench selftest streets --protocol nuscenes"
)]
pub struct SelftestArgs {
    /// The scans.
    #[command(flatten)]
    pub data: DatasetArgs,
    /// What becomes of damaged ones.
    #[command(flatten)]
    pub damage: DamageArgs,
    /// What else is tested.
    #[command(flatten)]
    pub protocol: ProtocolArgs,
}

/// The scores are not what they must be.
#[derive(Debug, thiserror::Error)]
#[error("{n_failed} of {n_checked} checks failed: the scoring is wrong")]
pub struct SelftestFailed {
    n_failed: usize,
    n_checked: usize,
}

impl From<SelftestFailed> for Failure {
    fn from(error: SelftestFailed) -> Self {
        Self::Internal(error.into())
    }
}

/// Feeds the annotations of every scan back as detections and checks, for every task and criterion, that all are
/// found, none is false and every cost is 0.
pub fn selftest(arguments: &SelftestArgs) -> Result<(), Failure> {
    let (mut n_failed, mut n_checked) = (0, 0);
    let policy = arguments.damage.policy();
    for opened in open_datasets_past_damage(&arguments.data, policy, &ClassTable::default())? {
        for checked in check_protocols(&opened, policy, &arguments.protocol.protocols)? {
            n_checked += 1;
            n_failed += usize::from(!checked.is_perfect());
            print_result(&checked)?;
        }
        for checked in check_dataset(&opened, policy)? {
            n_checked += 1;
            n_failed += usize::from(!checked.is_perfect());
            print_result(&checked)?;
        }
    }
    if n_failed > 0 {
        return Err(SelftestFailed { n_failed, n_checked }.into());
    }
    Ok(())
}

/// One data set, task and criterion.
struct Checked {
    dataset: String,
    task: Task,
    criterion: Criterion,
    counts: Counts,
    false_detections: FalseDetections,
    largest_cost: f64,
}

impl Checked {
    fn scored(&self) -> Scored {
        self.counts.scored(self.false_detections)
    }

    fn is_perfect(&self) -> bool {
        let scored = self.scored();
        let rates = [scored.recall(), scored.precision(), scored.f_rate()];
        let known = if self.false_detections == FalseDetections::Known { 3 } else { 1 };
        // Unknowable detections would be false ones if they were known.
        rates[..known].iter().all(|&rate| rate == Some(1.0))
            && self.counts.n_unknowable == 0
            && self.largest_cost == 0.0
    }
}

impl std::fmt::Display for Checked {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let scored = self.scored();
        let rate = |value: Option<f64>| value.map_or("undefined".to_owned(), |value| value.to_string());
        write!(
            formatter,
            "{:<6} {}, {} by {}: recall {}, precision {}, F-rate {} over {} annotations, largest cost {}",
            if self.is_perfect() { "ok" } else { "FAILED" },
            self.dataset,
            self.task.name(),
            self.criterion.name(),
            rate(scored.recall()),
            rate(scored.precision()),
            rate(scored.f_rate()),
            scored.no(),
            self.largest_cost,
        )
    }
}

fn check_dataset(opened: &OpenedDataset, policy: DamagePolicy) -> Result<Vec<Checked>, Failure> {
    let description = opened.dataset.description();
    let mut checks: Vec<Checked> = Task::ALL
        .iter()
        .flat_map(|&task| Criterion::ALL.map(|criterion| (task, criterion)))
        .map(|(task, criterion)| Checked {
            dataset: description.id.clone(),
            task,
            criterion,
            counts: Counts::default(),
            false_detections: FalseDetections::of(&description.annotated, task),
            largest_cost: 0.0,
        })
        .collect();
    let progress = progress_over_scans(opened.scan_indices.len(), &description.id);
    for &scan_idx in &opened.scan_indices {
        progress.inc(1);
        let scan = match opened.dataset.read_scan(scan_idx) {
            Ok(scan) => scan,
            Err(error) => {
                let id = &opened.dataset.scan_ids()[scan_idx];
                progress.suspend(|| opened.on_damage(policy, id, error))?;
                continue;
            }
        };
        let echoed = echo(&scan);
        for check in &mut checks {
            let params =
                MatchingParams { criterion: check.criterion, eligibility: EligibilityParams::STANDARD };
            let assignment = assign(&scan, &echoed, check.task, &description.annotated, &params);
            check.counts += Counts::of(&assignment);
            for outcome in &assignment.annotations {
                if let AnnotationOutcome::Matched { cost, .. } = outcome {
                    check.largest_cost = check.largest_cost.max(*cost);
                }
            }
        }
    }
    progress.finish_and_clear();
    opened.warn_of_points_left_out();
    if checks.iter().all(|check| check.counts.n_annotations == 0) {
        let reason = format!("{:?} has no annotation that counts", description.id);
        return Err(NothingEvaluated { reason }.into());
    }
    checks.retain(|check| check.counts.n_annotations > 0);
    Ok(checks)
}

/// The annotations of `scan` that hold a point, as a perfect detector would report them.
fn echo<'a>(scan: &'a LabeledScan) -> Detections {
    let seen = scan.annotations.iter().filter(|annotation| !annotation.point_indices.is_empty());
    let detection = |annotation: &'a Annotation| {
        Detection::new(
            &annotation.point_indices,
            annotation.bounding_box.unwrap_or_else(|| box_of_points(scan, annotation)),
            if counts_as_vehicle(annotation.class) { DetectedClass::Vehicle } else { DetectedClass::Object },
            None,
        )
    };
    seen.map(detection).collect()
}

/// A box without extent where the points of `annotation` are on average, as the matching takes its centre to be.
fn box_of_points(scan: &LabeledScan, annotation: &Annotation) -> OrientedBox {
    let center_m = annotation.center_m(&scan.cloud).unwrap_or_default();
    OrientedBox { center_m, length_width_height_m: [0.0; 3], yaw_rad: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A check on five annotations that all were found, changed by `change`.
    #[track_caller]
    fn check(change: impl FnOnce(&mut Checked), expected_perfect: bool) {
        let mut checked = Checked {
            dataset: "drawn".to_owned(),
            task: Task::Objects,
            criterion: Criterion::POINTS,
            counts: Counts { n_annotations: 5, n_matched: 5, ..Counts::default() },
            false_detections: FalseDetections::Known,
            largest_cost: 0.0,
        };
        change(&mut checked);
        assert_eq!(checked.is_perfect(), expected_perfect, "{checked}");
        assert_eq!(checked.to_string().starts_with("ok "), expected_perfect, "{checked}");
    }

    #[test]
    fn all_found_and_nothing_else_at_no_cost_is_perfect() {
        check(|_| {}, true);
        check(|it| it.counts.n_ignored_annotations = 3, true);
        check(|it| it.false_detections = FalseDetections::Unknowable, true);
    }

    #[test]
    fn anything_less_is_not() {
        check(|it| it.counts.n_matched = 4, false);
        check(|it| it.counts.n_false = 1, false);
        check(|it| it.largest_cost = 1e-9, false);
        check(|it| it.counts.n_unknowable = 1, false);
        check(|it| it.counts = Counts::default(), false);
    }

    #[test]
    fn where_false_detections_are_unknowable_a_miss_is_still_one() {
        let unknowable = |n_matched, n_unknowable| {
            move |it: &mut Checked| {
                it.false_detections = FalseDetections::Unknowable;
                it.counts.n_matched = n_matched;
                it.counts.n_unknowable = n_unknowable;
            }
        };
        check(unknowable(4, 0), false);
        check(unknowable(5, 1), false);
    }
}
