//! From one scan's annotations and detections to what became of each.

use detector::Detections;
use scans::annotation::{Annotation, LabeledScan, PointRegion};
use scans::dataset::AnnotatedClasses;
use scans::task::Task;

use crate::matching::criterion::Criterion;
use crate::matching::eligibility::{
    EligibilityParams, asks_for, exclusion, is_beyond_range, is_mostly_ignored,
};
use crate::matching::hungarian::{AdmissiblePair, match_pairs};
use crate::matching::outcome::{
    AnnotationOutcome, Assignment, DetectionOutcome, FalseReason, IgnoredAnnotation, IgnoredDetection,
    MissReason,
};
use crate::matching::point_overlap::PointOverlap;

/// How scans are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchingParams {
    /// When a pair may be matched.
    pub criterion: Criterion,
    /// What counts.
    pub eligibility: EligibilityParams,
}

/// Matches `detections` with the annotations of `scan` for `task`, and says of each what became of it and why.
///
/// `annotated` tells whether a detection that matches nothing is known to be false. Every point of a detection must
/// be a point of the scan.
///
/// Paper: HG section 5; ignored regions as in the KITTI evaluation.
pub fn assign(
    scan: &LabeledScan,
    detections: &Detections,
    task: Task,
    annotated: &AnnotatedClasses,
    params: &MatchingParams,
) -> Assignment {
    let overlap = PointOverlap::count(scan, detections);
    let exclusions: Vec<Option<AnnotationOutcome>> =
        scan.annotations.iter().map(|it| why_excluded(scan, it, task, params)).collect();
    let admissible = params.criterion.admissible_pairs(scan, detections, &overlap);
    let is_asked = |pair: &&AdmissiblePair| asks_for(task, detections.get(pair.detection_idx).class);
    let counts = |pair: &&AdmissiblePair| exclusions[pair.annotation_idx].is_none();
    let competing: Vec<AdmissiblePair> = admissible.iter().filter(counts).filter(is_asked).copied().collect();
    let matched = match_pairs(&competing);
    let scene = Scene { scan, detections, task, overlap, exclusions, admissible, matched };
    Assignment {
        task,
        annotations: (0..scan.annotations.len()).map(|idx| scene.annotation_outcome(idx)).collect(),
        detections: scene.detection_outcomes(annotated, &params.eligibility),
    }
}

fn why_excluded(
    scan: &LabeledScan,
    annotation: &Annotation,
    task: Task,
    params: &MatchingParams,
) -> Option<AnnotationOutcome> {
    let is_unboxed = params.criterion.needs_boxes() && annotation.bounding_box.is_none();
    exclusion(scan, annotation, task, &params.eligibility)
        .or_else(|| is_unboxed.then_some(AnnotationOutcome::Ignored(IgnoredAnnotation::NoBox)))
}

/// Everything known once the pairs are chosen.
struct Scene<'a> {
    scan: &'a LabeledScan,
    detections: &'a Detections,
    task: Task,
    overlap: PointOverlap,
    exclusions: Vec<Option<AnnotationOutcome>>,
    admissible: Vec<AdmissiblePair>,
    matched: Vec<AdmissiblePair>,
}

impl Scene<'_> {
    fn annotation_outcome(&self, annotation_idx: usize) -> AnnotationOutcome {
        if let Some(excluded) = self.exclusions[annotation_idx] {
            return excluded;
        }
        match self.matched.iter().find(|pair| pair.annotation_idx == annotation_idx) {
            Some(pair) => AnnotationOutcome::Matched { detection_idx: pair.detection_idx, cost: pair.cost },
            None => AnnotationOutcome::Missed(self.miss_reason(annotation_idx)),
        }
    }

    fn miss_reason(&self, annotation_idx: usize) -> MissReason {
        let mut candidates = self.admissible.iter().filter(|pair| pair.annotation_idx == annotation_idx);
        if let Some(pair) = candidates.next() {
            let mut all = std::iter::once(pair).chain(candidates);
            let is_asked = all.any(|pair| asks_for(self.task, self.detections.get(pair.detection_idx).class));
            return if is_asked { MissReason::TakenByAnother } else { MissReason::WrongClass };
        }
        let n_points = self.n_annotation_points(annotation_idx);
        let shared = self.overlap.of_annotation(annotation_idx);
        let n_found: usize = shared.iter().map(|&(_, n_shared)| n_shared).sum();
        let most = shared.iter().map(|&(_, n_shared)| n_shared).max();
        match most {
            None => MissReason::NothingThere,
            Some(most) if 2 * most > n_points => MissReason::MergedWithOthers,
            Some(_) if shared.len() > 1 && 2 * n_found > n_points => MissReason::Split,
            Some(_) => MissReason::PartlyFound,
        }
    }

    fn detection_outcomes(
        &self,
        annotated: &AnnotatedClasses,
        params: &EligibilityParams,
    ) -> Vec<DetectionOutcome> {
        let mut is_on_ignored = vec![false; self.scan.cloud.len()];
        for (annotation, excluded) in self.scan.annotations.iter().zip(&self.exclusions) {
            if matches!(excluded, Some(AnnotationOutcome::Ignored(_))) {
                for &point_idx in &annotation.point_indices {
                    is_on_ignored[point_idx as usize] = true;
                }
            }
        }
        let outcome = |detection_idx: usize| {
            let detection = self.detections.get(detection_idx);
            if !asks_for(self.task, detection.class) {
                return DetectionOutcome::NotAsked;
            }
            if let Some(pair) = self.matched.iter().find(|pair| pair.detection_idx == detection_idx) {
                return DetectionOutcome::Matched { annotation_idx: pair.annotation_idx, cost: pair.cost };
            }
            if is_mostly_ignored(self.scan, &detection, &is_on_ignored, params) {
                return DetectionOutcome::Ignored(self.ignore_reason(detection_idx, params));
            }
            if annotated.covers(self.task) {
                DetectionOutcome::False(self.false_reason(detection_idx))
            } else {
                DetectionOutcome::Unknowable
            }
        };
        (0..self.detections.len()).map(outcome).collect()
    }

    fn ignore_reason(&self, detection_idx: usize, params: &EligibilityParams) -> IgnoredDetection {
        let point_indices = self.detections.get(detection_idx).point_indices;
        let is_half = |n_points: usize| 2 * n_points >= point_indices.len();
        let on_ignored = self.overlap.of_detection(detection_idx).filter(|&(annotation_idx, _)| {
            matches!(self.exclusions[annotation_idx], Some(AnnotationOutcome::Ignored(_)))
        });
        let is_outside =
            |&&point_idx: &&u32| self.scan.point_regions[point_idx as usize] == PointRegion::Outside;
        let is_far = |&&point_idx: &&u32| is_beyond_range(self.scan, point_idx, params);
        if is_half(on_ignored.map(|(_, n_shared)| n_shared).sum()) {
            IgnoredDetection::OnIgnoredAnnotation
        } else if is_half(point_indices.iter().filter(is_outside).count()) {
            IgnoredDetection::OutsideLabeledRegion
        } else if is_half(point_indices.iter().filter(is_far).count()) {
            IgnoredDetection::BeyondRange
        } else {
            IgnoredDetection::OnIgnoredPoints
        }
    }

    fn false_reason(&self, detection_idx: usize) -> FalseReason {
        let n_points = self.detections.get(detection_idx).point_indices.len();
        let is_background = |annotation_idx: usize| {
            matches!(self.exclusions[annotation_idx], Some(AnnotationOutcome::NotAsked))
        };
        let mut n_swallowed = 0;
        let mut is_fragment = false;
        let mut is_wrong_class = false;
        for (annotation_idx, n_shared) in self.overlap.of_detection(detection_idx) {
            if is_background(annotation_idx) {
                is_wrong_class |= 2 * n_shared > n_points;
                continue;
            }
            n_swallowed += usize::from(2 * n_shared > self.n_annotation_points(annotation_idx));
            is_fragment |= 2 * n_shared > n_points;
        }
        match n_swallowed {
            _ if is_wrong_class => FalseReason::WrongClass,
            2.. => FalseReason::JoinsSeveral,
            _ if is_fragment => FalseReason::Fragment,
            1 => FalseReason::TooLarge,
            _ => FalseReason::NothingThere,
        }
    }

    fn n_annotation_points(&self, annotation_idx: usize) -> usize {
        self.scan.annotations[annotation_idx].point_indices.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::{DetectedClass, Detection, OrientedBox, PointCloud};
    use scans::annotation::{AnnotationClass, ScanId};
    use std::ops::Range;

    use AnnotationClass::{Car, Pedestrian, Tram};
    use DetectedClass::{Object, Vehicle};

    const EVERYTHING: AnnotatedClasses = AnnotatedClasses::EveryObject;
    const STANDARD: MatchingParams =
        MatchingParams { criterion: Criterion::POINTS, eligibility: EligibilityParams::STANDARD };
    const UNIT: OrientedBox =
        OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };

    /// 200 points along x, 10 cm apart; annotations and detections are ranges of them.
    struct Street {
        scan: LabeledScan,
        detections: Detections,
    }

    fn street(
        annotations: &[(AnnotationClass, Range<u32>)],
        detections: &[(DetectedClass, Range<u32>)],
    ) -> Street {
        let cloud: PointCloud = (0..200).map(|step| [step as f32 * 0.1, 0.0, 0.0]).collect();
        let center = |range: &Range<u32>| {
            let center_m = [(range.start + range.end - 1) as f32 * 0.05, 0.0, 0.0];
            OrientedBox { center_m, ..UNIT }
        };
        let annotation = |(class, range): &(AnnotationClass, Range<u32>)| Annotation {
            class: *class,
            bounding_box: Some(center(range)),
            point_indices: range.clone().collect(),
            track: None,
            occlusion: None,
            truncation: None,
        };
        let mut all = Detections::default();
        for (class, range) in detections {
            let point_indices: Vec<u32> = range.clone().collect();
            let bounding_box = center(range);
            all.push(Detection { point_indices: &point_indices, bounding_box, class: *class, score: None });
        }
        let point_regions = vec![PointRegion::Labeled; cloud.len()];
        let id = ScanId { sequence: "drawn".into(), index: 0 };
        let annotations = annotations.iter().map(annotation).collect();
        Street { scan: LabeledScan { id, cloud, annotations, point_regions }, detections: all }
    }

    impl Street {
        fn outside_from(mut self, first_idx: usize) -> Self {
            self.scan.point_regions[first_idx..].fill(PointRegion::Outside);
            self
        }

        fn unscorable_from(mut self, first_idx: usize) -> Self {
            self.scan.point_regions[first_idx..].fill(PointRegion::Unscorable);
            self
        }

        fn judge(&self, task: Task, annotated: &AnnotatedClasses) -> (Vec<String>, Vec<String>) {
            self.judge_by(task, annotated, STANDARD)
        }

        fn judge_by(
            &self,
            task: Task,
            annotated: &AnnotatedClasses,
            params: MatchingParams,
        ) -> (Vec<String>, Vec<String>) {
            let it = assign(&self.scan, &self.detections, task, annotated, &params);
            let annotations = it.annotations.iter().map(|outcome| match outcome {
                AnnotationOutcome::NotAsked => "not asked".to_owned(),
                AnnotationOutcome::Ignored(reason) => format!("ignored: {}", reason.name()),
                AnnotationOutcome::Matched { detection_idx, cost } => format!("{detection_idx} at {cost:.2}"),
                AnnotationOutcome::Missed(reason) => format!("missed: {}", reason.name()),
            });
            let detections = it.detections.iter().map(|outcome| match outcome {
                DetectionOutcome::NotAsked => "not asked".to_owned(),
                DetectionOutcome::Ignored(reason) => format!("ignored: {}", reason.name()),
                DetectionOutcome::Matched { annotation_idx, cost } => {
                    format!("{annotation_idx} at {cost:.2}")
                }
                DetectionOutcome::False(reason) => format!("false: {}", reason.name()),
                DetectionOutcome::Unknowable => "unknowable".to_owned(),
            });
            (annotations.collect(), detections.collect())
        }
    }

    #[track_caller]
    fn check(street: &Street, task: Task, annotations: &[&str], detections: &[&str]) {
        let (found_annotations, found_detections) = street.judge(task, &EVERYTHING);
        assert_eq!(found_annotations, annotations, "annotations");
        assert_eq!(found_detections, detections, "detections");
    }

    #[test]
    fn half_of_the_union_is_enough_and_less_is_not() {
        let half = street(&[(Car, 0..40)], &[(Vehicle, 20..40)]);
        check(&half, Task::Objects, &["0 at 0.50"], &["0 at 0.50"]);
        let less = street(&[(Car, 0..40)], &[(Vehicle, 21..40)]);
        check(&less, Task::Objects, &["missed: partly found"], &["false: fragment"]);
    }

    #[test]
    fn what_is_merged_split_or_absent_is_said_so() {
        let even = street(&[(Car, 0..40), (Car, 40..80)], &[(Vehicle, 0..80)]);
        check(&even, Task::Objects, &["0 at 0.50", "missed: taken by another"], &["0 at 0.50"]);
        let swallowed = street(&[(Car, 0..40), (Car, 40..80)], &[(Vehicle, 0..90)]);
        check(
            &swallowed,
            Task::Objects,
            &["missed: merged with others", "missed: merged with others"],
            &["false: joins several"],
        );
        let split = street(&[(Car, 0..60)], &[(Vehicle, 0..25), (Vehicle, 25..50)]);
        check(&split, Task::Objects, &["missed: split"], &["false: fragment", "false: fragment"]);
        let absent = street(&[(Car, 0..40)], &[(Vehicle, 100..120)]);
        check(&absent, Task::Objects, &["missed: nothing there"], &["false: nothing there"]);
    }

    #[test]
    fn poor_far_and_ambiguous_annotations_are_neither_found_nor_missed() {
        let poor = street(&[(Car, 0..19)], &[(Vehicle, 0..19)]);
        check(&poor, Task::Objects, &["ignored: too few points"], &["ignored: on ignored annotation"]);
        let tram = street(&[(Tram, 0..50)], &[(Vehicle, 0..50), (Vehicle, 60..90)]);
        check(
            &tram,
            Task::Vehicles,
            &["ignored: ambiguous class"],
            &["ignored: on ignored annotation", "false: nothing there"],
        );
        check(&tram, Task::Objects, &["0 at 0.00"], &["0 at 0.00", "false: nothing there"]);
    }

    #[test]
    fn beyond_the_labelled_region_nothing_is_right_or_wrong() {
        let outside = street(&[(Car, 90..130)], &[(Vehicle, 80..110), (Vehicle, 150..180)]).outside_from(95);
        check(
            &outside,
            Task::Vehicles,
            &["ignored: outside labelled region"],
            &["ignored: on ignored annotation", "ignored: outside labelled region"],
        );
    }

    #[test]
    fn unscorable_and_far_points_say_so() {
        let unscorable = street(&[], &[(Vehicle, 80..110)]).unscorable_from(95);
        check(&unscorable, Task::Vehicles, &[], &["ignored: on ignored points"]);
        let far = street(&[], &[(Vehicle, 90..120), (Vehicle, 80..110)]);
        let within_10_m = EligibilityParams { max_range_m: 10.0, ..EligibilityParams::STANDARD };
        let params = MatchingParams { eligibility: within_10_m, ..STANDARD };
        let (_, detections) = far.judge_by(Task::Vehicles, &EVERYTHING, params);
        assert_eq!(detections, ["ignored: beyond range", "false: nothing there"]);
    }

    #[test]
    fn an_overlap_of_exactly_the_least_is_enough() {
        for (min_iou, n_points) in [(0.1, 4), (0.3, 12), (0.7, 28), (1.0, 40)] {
            let criterion = Criterion::Points { min_iou };
            let part = street(&[(Car, 0..40)], &[(Vehicle, 0..n_points)]);
            let (annotations, _) =
                part.judge_by(Task::Objects, &EVERYTHING, MatchingParams { criterion, ..STANDARD });
            assert_eq!(annotations, [format!("0 at {:.2}", 1.0 - min_iou)], "IoU {min_iou}");
        }
    }

    #[test]
    fn a_vehicle_where_a_person_stands_is_of_the_wrong_class() {
        let person = street(&[(Pedestrian, 0..40), (Car, 50..90)], &[(Vehicle, 0..40), (Object, 50..90)]);
        check(
            &person,
            Task::Vehicles,
            &["not asked", "missed: wrong class"],
            &["false: wrong class", "not asked"],
        );
    }

    #[test]
    fn false_objects_are_unknowable_where_not_every_class_is_labelled() {
        let two = street(&[(Car, 0..40)], &[(Vehicle, 0..40), (Vehicle, 60..90)]);
        let cars_only = AnnotatedClasses::Only(vec![Car]);
        assert_eq!(two.judge(Task::Objects, &cars_only).1, ["0 at 0.00", "unknowable"]);
        assert_eq!(two.judge(Task::Vehicles, &cars_only).1, ["0 at 0.00", "false: nothing there"]);
    }

    #[test]
    fn centres_within_two_metres_match_whatever_the_points() {
        let shifted = street(&[(Car, 0..40)], &[(Vehicle, 30..40), (Vehicle, 100..140)]);
        let params =
            MatchingParams { criterion: Criterion::CENTRE, eligibility: EligibilityParams::STANDARD };
        let it = assign(&shifted.scan, &shifted.detections, Task::Vehicles, &EVERYTHING, &params);
        assert!(matches!(it.annotations[0], AnnotationOutcome::Matched { detection_idx: 0, .. }));
        assert_eq!(it.detections[1], DetectionOutcome::False(FalseReason::NothingThere));
    }

    /// Unit boxes in a row, 0.1 m from one point to the next.
    #[test]
    fn boxes_match_by_how_far_they_overlap() {
        let mut two = street(
            &[(Car, 0..40), (Car, 100..140)],
            &[(Vehicle, 3..43), (Vehicle, 104..144), (Vehicle, 60..90)],
        );
        // 0.3 m apart they share 0.7 of 1.3, and 0.4 m apart 0.6 of 1.4.
        for criterion in [Criterion::BEV_IOU, Criterion::IOU_3D] {
            let params = MatchingParams { criterion, eligibility: EligibilityParams::STANDARD };
            let (annotations, detections) = two.judge_by(Task::Vehicles, &EVERYTHING, params);
            assert_eq!(annotations, ["0 at 0.46", "missed: merged with others"]);
            assert_eq!(detections, ["0 at 0.46", "false: fragment", "false: nothing there"]);
        }
        two.scan.annotations[0].bounding_box = None;
        let params =
            MatchingParams { criterion: Criterion::BEV_IOU, eligibility: EligibilityParams::STANDARD };
        let (annotations, detections) = two.judge_by(Task::Vehicles, &EVERYTHING, params);
        assert_eq!(annotations[0], "ignored: no box");
        assert_eq!(detections[0], "ignored: on ignored annotation");
    }
}
