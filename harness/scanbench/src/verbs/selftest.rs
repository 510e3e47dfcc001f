//! `scanbench selftest`: annotations fed back as detections.

use clap::Args;
use detector::{DetectedClass, Detection, Detections, OrientedBox};
use evaluation::matching::assign::{MatchingParams, assign};
use evaluation::matching::criterion::Criterion;
use evaluation::matching::eligibility::{EligibilityParams, counts_as_vehicle};
use evaluation::metrics::counts::{Counts, FalseDetections};
use reports::vocabulary::task::Task;
use scans::annotation::{Annotation, LabeledScan};
use scans::dataset::source::DamagePolicy;

use crate::cli::{DamageArgs, DatasetArgs, ProtocolArgs};
use crate::plumbing::config::classes_of_project;
use crate::plumbing::failure::{Failure, NothingEvaluated};
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets_past_damage};
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::standard_streams::print_result;
use crate::verbs::selftest_checked::{Checked, largest_cost};
use crate::verbs::selftest_doors::Doors;
use crate::verbs::selftest_protocols::check_protocols;

/// Arguments of `scanbench selftest`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  scanbench selftest ../data/kitti_tracking --scans 0..10\n  scanbench selftest streets --protocol nuscenes\n\nThe labels come as detections within the program, and then with their classes through a process and\nfiles of each format that the data have. A protocol is `unsure` if it does not take every label both\nways: then the best numbers cannot be reached."
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
/// found, none is false and every cost is 0; then the same of what comes through each door for detections, with classes.
pub fn selftest(arguments: &SelftestArgs) -> Result<(), Failure> {
    let (mut n_failed, mut n_checked) = (0, 0);
    let policy = arguments.damage.policy();
    for opened in open_datasets_past_damage(&arguments.data, policy, &classes_of_project()?)? {
        let mut doors = Doors::open(&opened)?;
        for checked in check_protocols(&opened, policy, &arguments.protocol.protocols, doors.as_mut())? {
            n_checked += 1;
            n_failed += usize::from(!checked.is_perfect());
            print_result(&checked)?;
        }
        for checked in check_dataset(&opened, policy, doors)? {
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

fn check_dataset(
    opened: &OpenedDataset,
    policy: DamagePolicy,
    mut doors: Option<Doors>,
) -> Result<Vec<Checked>, Failure> {
    let description = opened.dataset.description();
    let mut checks: Vec<Checked> = Task::ALL
        .iter()
        .flat_map(|&task| Criterion::ALL.map(|criterion| (task, criterion)))
        .map(|(task, criterion)| Checked {
            dataset: description.id.clone(),
            task,
            criterion,
            through: None,
            counts: Counts::default(),
            false_detections: FalseDetections::of(&description.annotated, task),
            most_cost: 0.0,
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
            check.largest_cost = check.largest_cost.max(largest_cost(&assignment));
        }
        if let Some(doors) = &mut doors {
            doors.judge(opened, &scan)?;
        }
    }
    progress.finish_and_clear();
    opened.warn_of_points_left_out();
    if checks.iter().all(|check| check.counts.n_annotations == 0) {
        let reason = format!("{:?} has no annotation that counts", description.id);
        return Err(NothingEvaluated { reason }.into());
    }
    checks.retain(|check| check.counts.n_annotations > 0);
    checks.extend(doors.iter().flat_map(|it| it.checked(opened)));
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
