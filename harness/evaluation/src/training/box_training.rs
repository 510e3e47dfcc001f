//! Training of the trees that complete the boxes of vehicles.

use std::collections::{BTreeMap, BTreeSet};

use detector::classify::forest::Forest;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::foreground;
use detector::pipeline::frame::Frame;
use detector::pipeline::stage_list::Pipeline;
use detector::road_user::{N_ROAD_USERS, RoadUser};
use detector::segment::foreground::Foreground;
use detector::whole::box_model::{BoxModel, N_GROWTHS};
use detector::whole::box_values::{IS_TURNED, N_BOX_VALUES};
use detector::whole::reported_boxes::BoxParams;
use detector::whole::whole_box::{Difference, SeenRoadUser, WholeBox, WholeBoxes};
use detector::{Detector, DetectorOutput, OrientedBox};
use forust_ml::errors::ForustError;
use reports::vocabulary::task::Task;
use scans::annotation::LabeledScan;

use crate::matching::assign::{MatchingParams, assign};
use crate::matching::outcome::AnnotationOutcome;
use crate::metrics::box_errors::BoxErrors;
use crate::scan_pass::{PassedScan, ScanPass, ScanPassError};
use crate::training::boosting::{BoostingParams, Target, boost};
use crate::training::vehicle_labels::is_road_user;
use reports::numbers::calibration::{CalibrationBin, calibration};

/// Chosen on held-out drives of the training streets.
const GROWTH: BoostingParams =
    BoostingParams { n_trees: 60, depth: 6, learning_rate: 0.15, least_leaf_weight: 20.0, drawn_share: 0.5 };
/// Parameters of the forests that decide yes or no; chosen likewise.
const DECISIONS: BoostingParams = BoostingParams { least_leaf_weight: 5.0, ..GROWTH };

/// A cluster of a vehicle is an example only if its box is turned by at most this much against the annotated box. Boxes of
/// pedestrians and cyclists are turned any way, and no other box is near.
const MOST_OFF_DEG: [f32; N_ROAD_USERS] = [12.0, 45.0, 30.0];

/// Detectors whose clusters are examples: clusters of cells and clusters of points end differently.
pub const LEARNED_FROM: [&str; 2] = ["hierarchical", "kd-tree"];

/// Number of forests that [`train_boxes`] trains for a class: those of all examples, those of each half of the drives, and
/// the one that predicts whether a box is right.
pub const N_BOX_FORESTS: usize = 3 * (N_GROWTHS + 2) + 1;
/// Fewest examples of pedestrians and of cyclists that are learned.
pub const FEWEST_EXAMPLES: usize = 100;

/// Least intersection over union in space of a right box with the annotated one, as in KITTI.
pub fn right_iou(road_user: RoadUser) -> f64 {
    match road_user {
        RoadUser::Vehicle => 0.7,
        RoadUser::Pedestrian | RoadUser::Cyclist => 0.5,
    }
}

/// A cluster that matches an annotated road user.
#[derive(Debug, Clone, PartialEq)]
pub struct RoadUserExample {
    /// Its drive.
    pub sequence: String,
    /// Its class.
    pub road_user: RoadUser,
    /// The road user as the sensor sees it.
    pub seen: SeenRoadUser,
    /// The annotated box.
    pub whole: OrientedBox,
}

/// State of a thread that passes over scans.
struct Looker {
    foreground: Pipeline<Foreground>,
    detectors: Vec<Box<dyn Detector>>,
}

/// Makes detectors whose clusters are examples; they report boxes of the seen points.
pub type NewDetectors<'a> = &'a (dyn Fn() -> Vec<Box<dyn Detector>> + Sync);

/// Boxes of the seen points, from which the trees learn.
pub const SEEN: BoxParams = BoxParams { outline: true, whole: false };

/// The clusters in the scans of `pass` that match an annotated road user with a box, scan by scan. `new_detectors` makes the
/// detectors of each thread; the ground is found with `params`.
///
/// # Errors
///
/// As [`ScanPass::over`] says.
pub fn collect_road_users(
    pass: ScanPass<'_>,
    new_detectors: NewDetectors<'_>,
    params: &HierarchicalParams,
    matching: &MatchingParams,
) -> Result<Vec<RoadUserExample>, ScanPassError> {
    let description = pass.dataset.description();
    let new_looker = || Looker {
        foreground: foreground(&params.front_end(), description.sensor_height_m),
        detectors: new_detectors(),
    };
    let look = |looker: &mut Looker, PassedScan { scan, .. }: PassedScan<'_>| {
        looker.foreground.detect(&scan.cloud, &mut DetectorOutput::default());
        let mut found = Vec::new();
        for detector in &mut looker.detectors {
            let mut output = DetectorOutput::default();
            detector.detect(&scan.cloud, &mut output);
            let detections = &output.detections;
            let assignment = assign(scan, detections, Task::Objects, &description.annotated, matching);
            found.extend(assignment.annotations.iter().enumerate().filter_map(
                |(annotation_idx, outcome)| {
                    let AnnotationOutcome::Matched { detection_idx, .. } = *outcome else { return None };
                    example(scan, &output, &looker.foreground.frame, annotation_idx, detection_idx)
                },
            ));
        }
        found
    };
    Ok(pass.over(new_looker, look)?.into_iter().flatten().collect())
}

/// `None` if the annotation is no road user, or has no box.
fn example(
    scan: &LabeledScan,
    output: &DetectorOutput,
    frame: &Frame<Foreground>,
    annotation_idx: usize,
    detection_idx: usize,
) -> Option<RoadUserExample> {
    let annotation = &scan.annotations[annotation_idx];
    let whole = annotation.bounding_box?;
    let is_so = |it: &RoadUser| is_road_user(annotation.class, *it) == Some(true);
    let road_user = RoadUser::ALL.into_iter().find(is_so)?;
    let detection = output.detections.get(detection_idx);
    let positions_m: Vec<[f32; 3]> =
        detection.point_indices.iter().map(|&it| scan.cloud.position_m(it as usize)).collect();
    let ground_m = frame.ground_below_m(&detection.bounding_box);
    let seen = SeenRoadUser::new(detection.bounding_box, ground_m, &positions_m);
    Some(RoadUserExample { sequence: scan.id.sequence.clone(), road_user, seen, whole })
}

/// Why no trees can be trained.
#[derive(Debug, thiserror::Error)]
pub enum BoxTrainingError {
    /// All vehicles have the same value of a target.
    #[error("no two of the {n} vehicles differ in {what}")]
    Alike {
        /// Number of vehicles with the target.
        n: usize,
        /// The target.
        what: &'static str,
    },
    /// All vehicles are of one drive; whether boxes are right is learned from boxes that models of other drives give.
    #[error("all {n} vehicles are of one drive; whether boxes are right is learned from two or more")]
    OneDrive {
        /// Number of vehicles.
        n: usize,
    },
    /// The trainer failed.
    #[error(transparent)]
    Boosting(#[from] ForustError),
}

/// Trains all forests. Returns them, and the number of `examples` that they learned from: those whose box of the seen points
/// is turned by at most 12 degrees against the annotated box. The forest that predicts whether a box is right learns from
/// all examples, each with the box that forests of other drives give it.
///
/// `on_forest` is called after each of [`N_BOX_FORESTS`].
///
/// # Errors
///
/// [`BoxTrainingError`] if no example is left, if all are of one drive, or if all have the same answer to one of the
/// questions: whether the box is turned, which end is the front, whether the box is right.
pub fn train_boxes(
    all: &[&RoadUserExample],
    on_forest: &dyn Fn(),
) -> Result<(BoxModel, usize), BoxTrainingError> {
    let (model, n_taught) = train_growth(all, on_forest)?;
    let examples = all;
    let drives: BTreeSet<&str> = examples.iter().map(|it| it.sequence.as_str()).collect();
    if drives.len() < 2 {
        return Err(BoxTrainingError::OneDrive { n: examples.len() });
    }
    let half_of: BTreeMap<&str, usize> = drives.into_iter().zip([0, 1].into_iter().cycle()).collect();
    let mut values = Vec::with_capacity(examples.len());
    let mut are_right = Vec::with_capacity(examples.len());
    for half in 0..2 {
        let is_here = |it: &&RoadUserExample| half_of[it.sequence.as_str()] == half;
        let (here, elsewhere): (Vec<_>, Vec<_>) = all.iter().copied().partition(is_here);
        let (of_others, _) = train_growth(&elsewhere, on_forest)?;
        let here_class = here.first().map_or(RoadUser::Vehicle, |it| it.road_user);
        let mut vehicles: Vec<SeenRoadUser> = here.iter().map(|it| it.seen).collect();
        let mut boxes = WholeBoxes::default();
        let found = boxes.find(&of_others, &mut vehicles);
        let is_right = |(found, it): (&WholeBox, &&RoadUserExample)| {
            f64::from(u8::from(BoxErrors::of(&found.bounding_box, &it.whole).iou_3d >= right_iou(here_class)))
        };
        are_right.extend(found.iter().zip(&here).map(is_right));
        values.extend(vehicles.iter().map(|it| it.values));
    }
    let right = decision(&values, &are_right, "whether their boxes are right")?;
    on_forest();
    Ok((BoxModel { right, ..model }, n_taught))
}

/// Trains the forest that predicts whether a target is 1 and not 0. `what` names the targets in errors.
fn decision(
    values: &[[f32; N_BOX_VALUES]],
    targets: &[f64],
    what: &'static str,
) -> Result<Forest<N_BOX_VALUES>, BoxTrainingError> {
    if targets.windows(2).all(|it| it[0] == it[1]) {
        return Err(BoxTrainingError::Alike { n: targets.len(), what });
    }
    let alike = vec![1.0; targets.len()];
    Ok(boost(&values.iter().collect::<Vec<_>>(), (targets, &alike), Target::Yes, &DECISIONS)?)
}

/// Trains all forests but the one that predicts whether a box is right; its placeholder calls no box right. Also returns the
/// number of examples that they learned from.
fn train_growth(
    examples: &[&RoadUserExample],
    on_forest: &dyn Fn(),
) -> Result<(BoxModel, usize), BoxTrainingError> {
    let differences = examples.iter().map(|it| (it, Difference::between(&it.seen, &it.whole)));
    let kept = differences.filter(|it| it.1.off_rad <= MOST_OFF_DEG[it.0.road_user as usize].to_radians());
    let (mut unturned, mut turned, mut differences) = (Vec::new(), Vec::new(), Vec::new());
    for (example, difference) in kept {
        let mut values: [f32; N_BOX_VALUES] = example.seen.values;
        unturned.push(values);
        values[IS_TURNED] = f32::from(u8::from(difference.is_turned));
        turned.push(values);
        differences.push(difference);
    }
    let trained = |values: &[_], what: &'static str, is_so: fn(&Difference) -> bool| {
        let targets: Vec<f64> = differences.iter().map(|it| f64::from(u8::from(is_so(it)))).collect();
        let forest = decision(values, &targets, what)?;
        on_forest();
        Ok::<_, BoxTrainingError>(forest)
    };
    let growth = |index: usize| -> Result<_, BoxTrainingError> {
        let targets: Vec<f64> = differences.iter().map(|it| f64::from(it.growth_m[index])).collect();
        let alike = vec![1.0; targets.len()];
        let forest = boost(&turned.iter().collect::<Vec<_>>(), (&targets, &alike), Target::Number, &GROWTH)?;
        on_forest();
        Ok(forest)
    };
    let model = BoxModel {
        turned: trained(&unturned, "whether they are longer across what is seen", |it| it.is_turned)?,
        growth_m: [growth(0)?, growth(1)?, growth(2)?, growth(3)?, growth(4)?],
        away: trained(&turned, "which end is the front", |it| it.is_away)?,
        right: Forest::new(Vec::new(), f32::MIN).expect("a sum alone is a forest"),
    };
    Ok((model, differences.len()))
}

/// How good boxes are: shares of all boxes, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoxShares {
    /// Share with long sides turned by at most 5 and at most 10 degrees.
    pub yaw: [f64; 2],
    /// Share with an intersection over union of at least 0.5 and at least 0.7, seen from above.
    pub bev: [f64; 2],
    /// Share with an intersection over union of at least 0.5 and at least 0.7, in space.
    pub space: [f64; 2],
    /// Share with the front on the right side.
    pub heading: f64,
}

impl BoxShares {
    /// Shares of `boxes`, each with the annotated one.
    pub fn of(boxes: &[(OrientedBox, OrientedBox)]) -> Self {
        let errors: Vec<BoxErrors> =
            boxes.iter().map(|(fitted, whole)| BoxErrors::of(fitted, whole)).collect();
        let share = |is_so: &dyn Fn(&BoxErrors) -> bool| {
            errors.iter().filter(|it| is_so(it)).count() as f64 / errors.len().max(1) as f64
        };
        Self {
            yaw: [5.0, 10.0].map(|most_deg| share(&|it| it.yaw_rad.to_degrees() <= most_deg)),
            bev: [0.5, 0.7].map(|least| share(&|it| it.bev_iou >= least)),
            space: [0.5, 0.7].map(|least| share(&|it| it.iou_3d >= least)),
            heading: share(&|it| it.is_front_right),
        }
    }
}

/// How good the model is at telling which end is the front.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SureFronts {
    /// Share of the vehicles for which it is sure, 0 to 1.
    pub share: f64,
    /// Share of these with the front on the right side; `None` if there are none.
    pub right: Option<f64>,
}

/// How good the boxes of a model are.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxJudgement {
    /// Boxes of the seen points.
    pub seen: BoxShares,
    /// Boxes of whole vehicles.
    pub whole: BoxShares,
    /// Their fronts.
    pub sure_fronts: SureFronts,
    /// Expected probability that a box is right, and the share that is.
    pub right_boxes: Vec<CalibrationBin>,
}

impl BoxJudgement {
    /// Judges `model` on vehicles that it has not learned from.
    pub fn of(model: &BoxModel, judged: &[&RoadUserExample]) -> Self {
        let seen: Vec<_> = judged.iter().map(|it| (it.seen.seen, it.whole)).collect();
        let mut vehicles: Vec<SeenRoadUser> = judged.iter().map(|it| it.seen).collect();
        let mut boxes = WholeBoxes::default();
        let found = boxes.find(model, &mut vehicles);
        let whole: Vec<_> =
            found.iter().map(|it| it.bounding_box).zip(judged.iter().map(|it| it.whole)).collect();
        let errors = whole.iter().map(|(fitted, whole)| BoxErrors::of(fitted, whole));
        let (mut n_sure, mut n_sure_right, mut expected) = (0, 0, Vec::new());
        for ((found, errors), it) in found.iter().zip(errors).zip(judged) {
            n_sure += usize::from(found.seen.is_front_sure);
            n_sure_right += usize::from(found.seen.is_front_sure && errors.is_front_right);
            let probability = 1.0 / (1.0 + f64::from(-found.right_log_odds).exp());
            expected.push((probability, f64::from(u8::from(errors.iou_3d >= right_iou(it.road_user)))));
        }
        let share = |n: usize, of: usize| (of > 0).then(|| n as f64 / of as f64);
        Self {
            seen: BoxShares::of(&seen),
            whole: BoxShares::of(&whole),
            sure_fronts: SureFronts {
                share: share(n_sure, found.len()).unwrap_or_default(),
                right: share(n_sure_right, n_sure),
            },
            right_boxes: calibration(expected.into_iter()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vehicle(yaw_rad: f32, length_m: f32) -> RoadUserExample {
        let seen =
            OrientedBox { center_m: [9.0, 3.0, -1.0], length_width_height_m: [2.0, 0.8, 1.2], yaw_rad: 0.1 };
        let whole = OrientedBox { length_width_height_m: [length_m, 1.8, 1.5], yaw_rad, ..seen };
        RoadUserExample {
            sequence: "a".to_owned(),
            road_user: RoadUser::Vehicle,
            seen: SeenRoadUser::new(seen, -1.7, &[[9.0, 3.0, -1.0]]),
            whole,
        }
    }

    #[test]
    fn what_is_always_the_same_cannot_be_learned() {
        let refused = |examples: &[RoadUserExample]| {
            train_boxes(&examples.iter().collect::<Vec<_>>(), &|| ()).unwrap_err().to_string()
        };
        assert!(refused(&[]).contains("no two of the 0 vehicles"));
        // Too far off to learn from.
        assert!(refused(&[vehicle(0.1 + 0.5, 4.0)]).contains("no two of the 0 vehicles"));
        let alike = [vehicle(0.1, 4.0), vehicle(0.12, 4.4)];
        assert_eq!(
            refused(&alike),
            "no two of the 2 vehicles differ in whether they are longer across what is seen"
        );
    }

    #[test]
    fn from_one_drive_nobody_can_learn_what_is_right() {
        let turned = std::f32::consts::FRAC_PI_2;
        let examples = [vehicle(0.1, 4.0), vehicle(0.1 + turned, 4.4), vehicle(0.1 + 2.0 * turned, 4.2)];
        let error = train_boxes(&examples.iter().collect::<Vec<_>>(), &|| ()).unwrap_err();
        assert!(matches!(error, BoxTrainingError::OneDrive { n: 3 }), "{error}");
    }

    #[test]
    fn shares_are_those_of_the_boxes() {
        let [right, turned] = [0.1, 0.1 + std::f32::consts::PI].map(|it| vehicle(it, 4.0).whole);
        let shares = BoxShares::of(&[(right, right), (turned, right)]);
        let all = [1.0; 2];
        assert_eq!(shares, BoxShares { yaw: all, bev: all, space: all, heading: 0.5 });
        assert_eq!(BoxShares::of(&[]), BoxShares::default());
    }
}
