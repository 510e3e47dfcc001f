//! Outcome of each annotation and each detection of one scan.

use detector::Detections;
use reports::vocabulary::reason::{FalseReason, IgnoredDetection, MissReason};
use reports::vocabulary::task::Task;
use scans::annotation::LabeledScan;
use scans::dataset::AnnotatedClasses;

use crate::matching::criterion::Criterion;
use crate::matching::detection_order::detection_ranks;
use crate::matching::eligibility::{EligibilityParams, asks_for, exclusions};
use crate::matching::hungarian::AdmissiblePair;
use crate::matching::ignored_detections::UnjudgedPositions;
use crate::matching::judged_slice::judge_only;
use crate::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome, FoundTall};
use crate::matching::pairing::Pairing;
use crate::matching::point_overlap::PointOverlap;

/// How scans are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchingParams {
    /// When a pair may be matched.
    pub criterion: Criterion,
    /// Which annotations count.
    pub eligibility: EligibilityParams,
}

/// Matches `detections` with the annotations of `scan` for `task`, and gives the outcome of each, with its reason.
///
/// `annotated` decides whether a detection that matches nothing is known to be false. Every point of a detection must
/// be a point of the scan; it may be one of several detections. The order of the detections does not matter: between
/// equally good pairs `detection_ranks` decide. Unmatched detections may find ignored annotations by the same criterion, tall
/// ones first; both are then ignored.
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
    let exclusions = exclusions(scan, task, params.criterion, &params.eligibility);
    let admissible = params.criterion.admissible_pairs(scan, detections, &overlap);
    let ranks = detection_ranks(detections);
    let is_asked: Vec<bool> = detections.iter().map(|it| asks_for(task, &it)).collect();
    let Pairing { matched, found_tall, found_ignored } =
        Pairing::choose(&admissible, &ranks, &is_asked, &exclusions);
    let scene = Scene { scan, detections, task, is_asked, overlap, exclusions, admissible };
    let assignment = Assignment {
        task,
        criterion: params.criterion.kind(),
        annotations: scene.annotation_outcomes(&matched),
        detections: scene.detection_outcomes(
            &matched,
            &[&found_tall[..], &found_ignored].concat(),
            annotated,
            &params.eligibility,
        ),
        found_tall: found_tall.into_iter().map(found_tall_of).collect(),
    };
    match params.eligibility.only {
        Some(slice) => judge_only(slice, scan, detections, assignment),
        None => assignment,
    }
}

fn found_tall_of(AdmissiblePair { annotation_idx, detection_idx, cost }: AdmissiblePair) -> FoundTall {
    FoundTall { annotation_idx, detection_idx, cost }
}

/// Everything that determines the outcomes once the pairs are chosen.
struct Scene<'a> {
    scan: &'a LabeledScan,
    detections: &'a Detections,
    task: Task,
    // For every detection whether the task asks for its class.
    is_asked: Vec<bool>,
    overlap: PointOverlap,
    exclusions: Vec<Option<AnnotationOutcome>>,
    // By annotation.
    admissible: Vec<AdmissiblePair>,
}

impl Scene<'_> {
    fn annotation_outcomes(&self, matched: &[AdmissiblePair]) -> Vec<AnnotationOutcome> {
        let mut found = vec![None; self.scan.annotations.len()];
        for pair in matched {
            let outcome = AnnotationOutcome::Matched { detection_idx: pair.detection_idx, cost: pair.cost };
            found[pair.annotation_idx] = Some(outcome);
        }
        let outcome = |(annotation_idx, found): (usize, Option<AnnotationOutcome>)| {
            let judged = self.exclusions[annotation_idx].or(found);
            judged.unwrap_or_else(|| AnnotationOutcome::Missed(self.miss_reason(annotation_idx)))
        };
        found.into_iter().enumerate().map(outcome).collect()
    }

    fn miss_reason(&self, annotation_idx: usize) -> MissReason {
        let begin = self.admissible.partition_point(|pair| pair.annotation_idx < annotation_idx);
        let mut candidates = self.admissible[begin..]
            .iter()
            .take_while(|pair| pair.annotation_idx == annotation_idx)
            .peekable();
        if candidates.peek().is_some() {
            let is_asked = candidates.any(|pair| self.is_asked[pair.detection_idx]);
            return if is_asked { MissReason::TakenByAnother } else { MissReason::WrongClass };
        }
        let n_points = self.n_annotation_points(annotation_idx);
        let shared = self.overlap.of_annotation(annotation_idx);
        // Of equal shares, one with more of other objects, so that the order of detections changes nothing.
        let most =
            shared.iter().map(|&(idx, n_shared)| (n_shared, self.has_mostly_others(idx, n_shared))).max();
        match most {
            None => MissReason::NothingThere,
            Some((most, true)) if 2 * most > n_points => MissReason::MergedWithOthers,
            Some((most, false)) if 2 * most > n_points => MissReason::MergedWithBackground,
            Some(_) if shared.len() > 1 && 2 * self.overlap.n_detected(annotation_idx) > n_points => {
                MissReason::Split
            }
            Some(_) => MissReason::PartlyFound,
        }
    }

    /// Whether more than half of a detection, without the `n_shared` points of an annotation, belongs to other annotations.
    fn has_mostly_others(&self, detection_idx: usize, n_shared: usize) -> bool {
        let of_annotations = self.overlap.of_detection(detection_idx).iter();
        let n_annotated: usize = of_annotations.map(|&(_, n_shared)| n_shared).sum();
        let n_points = self.detections.get(detection_idx).point_indices.len();
        // An annotation may share points with another.
        2 * n_annotated.saturating_sub(n_shared) > n_points.saturating_sub(n_shared)
    }

    fn detection_outcomes(
        &self,
        matched: &[AdmissiblePair],
        found_ignored: &[AdmissiblePair],
        annotated: &AnnotatedClasses,
        params: &EligibilityParams,
    ) -> Vec<DetectionOutcome> {
        let mut found = vec![None; self.detections.len()];
        for pair in matched {
            let outcome = DetectionOutcome::Matched { annotation_idx: pair.annotation_idx, cost: pair.cost };
            found[pair.detection_idx] = Some(outcome);
        }
        for pair in found_ignored {
            let outcome = DetectionOutcome::Ignored(IgnoredDetection::OnIgnoredAnnotation);
            found[pair.detection_idx] = Some(outcome);
        }
        let unjudged = UnjudgedPositions::of(self.scan, &self.exclusions, params);
        let outcome = |(detection_idx, found): (usize, Option<DetectionOutcome>)| {
            if !self.is_asked[detection_idx] {
                return DetectionOutcome::NotAsked;
            }
            let why_ignored = || unjudged.why_ignored(&self.detections.get(detection_idx));
            found.or_else(|| why_ignored().map(DetectionOutcome::Ignored)).unwrap_or_else(|| {
                if annotated.covers(self.task) {
                    DetectionOutcome::False(self.false_reason(detection_idx))
                } else {
                    DetectionOutcome::Unknowable(None)
                }
            })
        };
        found.into_iter().enumerate().map(outcome).collect()
    }

    fn false_reason(&self, detection_idx: usize) -> FalseReason {
        let n_points = self.detections.get(detection_idx).point_indices.len();
        let is_background = |annotation_idx: usize| {
            matches!(self.exclusions[annotation_idx], Some(AnnotationOutcome::NotAsked))
        };
        let mut n_swallowed = 0;
        let mut is_fragment = false;
        let mut is_wrong_class = false;
        for &(annotation_idx, n_shared) in self.overlap.of_detection(detection_idx) {
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
mod properties;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::drawn_labels::{
        UNIT, annotations_in_row, detections_in_row, labeled, row, standard,
    };
    use detector::{DetectedClass, Detection, OrientedBox};
    use reports::vocabulary::class::AnnotationClass;
    use scans::annotation::{LabeledArea, PointRegion};
    use std::ops::Range;

    use AnnotationClass::{Car, Pedestrian, Tram, Tree};
    use DetectedClass::{Object, Vehicle};

    const EVERYTHING: AnnotatedClasses = AnnotatedClasses::EveryObject;
    const STANDARD: MatchingParams = standard(Criterion::POINTS);

    /// 200 points along x, 10 cm apart; annotations and detections are ranges of them.
    struct Street {
        scan: LabeledScan,
        detections: Detections,
    }

    fn street(
        annotations: &[(AnnotationClass, Range<u32>)],
        detections: &[(DetectedClass, Range<u32>)],
    ) -> Street {
        let mut scan = labeled(row(200), annotations_in_row(annotations));
        scan.labeled_area = LabeledArea::AsPoints;
        Street { scan, detections: detections_in_row(detections, None) }
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
                DetectionOutcome::Unknowable(_) => "unknowable".to_owned(),
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
    fn each_ignored_annotation_may_be_found_by_one_detection_whatever_else_is_in_its_box() {
        // A car of too few points; the detections have more of the tree behind it.
        let street = street(&[(Car, 0..10), (Tree, 10..60)], &[(Vehicle, 0..25), (Vehicle, 0..30)]);
        let params = standard(Criterion::Centre { max_distance_m: 1.2 });
        let (annotations, detections) = street.judge_by(Task::Objects, &EVERYTHING, params);
        assert_eq!(annotations[0], "ignored: too few points");
        assert_eq!(detections[0], "ignored: on ignored annotation");
        assert!(detections[1].starts_with("false"), "{detections:?}");
        let (_, vehicles) = street.judge_by(Task::Vehicles, &EVERYTHING, params);
        assert_eq!(vehicles[0], "ignored: on ignored annotation");
        let (_, by_points) = street.judge(Task::Objects, &EVERYTHING);
        assert!(by_points.iter().all(|it| it.starts_with("false")), "{by_points:?}");
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
    fn what_the_labelled_region_cuts_counts_and_a_detection_beside_it_does_not() {
        let cut = |detections: &[(DetectedClass, Range<u32>)]| {
            street(&[(Car, 90..130)], detections).outside_from(95)
        };
        let found = cut(&[(Vehicle, 90..125), (Vehicle, 150..180)]);
        check(&found, Task::Vehicles, &["0 at 0.12"], &["0 at 0.12", "ignored: outside labelled region"]);
        let missed = cut(&[(Vehicle, 80..110)]);
        check(&missed, Task::Vehicles, &["missed: partly found"], &["ignored: outside labelled region"]);
        let inside = cut(&[(Vehicle, 79..110)]);
        check(&inside, Task::Vehicles, &["missed: partly found"], &["false: fragment"]);
    }

    #[test]
    fn half_unscorable_is_ignored_and_less_is_not() {
        let half = street(&[(Car, 0..40)], &[]).unscorable_from(20);
        check(&half, Task::Vehicles, &["ignored: unscorable"], &[]);
        let less = street(&[(Car, 0..40)], &[]).unscorable_from(21);
        check(&less, Task::Vehicles, &["missed: nothing there"], &[]);
    }

    impl Street {
        /// Adds a detection without a point, of a unit box this far ahead.
        fn with_empty(mut self, x_m: f32) -> Self {
            let bounding_box = OrientedBox { center_m: [x_m, 0.0, 50.0], ..UNIT };
            self.detections.push(Detection::new(&[], bounding_box, Vehicle, None));
            self
        }
    }

    #[test]
    fn a_detection_without_points_is_judged_by_where_it_stands() {
        let of_one = |street: Street| street.judge(Task::Vehicles, &EVERYTHING).1;
        assert_eq!(of_one(street(&[], &[]).with_empty(5.0)), ["false: nothing there"]);
        assert_eq!(of_one(street(&[], &[]).with_empty(81.0)), ["ignored: beyond range"]);
        assert_eq!(
            of_one(street(&[], &[]).with_empty(5.0).outside_from(0)),
            ["ignored: outside labelled region"]
        );
        // A tram stands at 2.45 m, half a metre to either side.
        let tram = || street(&[(Tram, 0..50)], &[]);
        assert_eq!(of_one(tram().with_empty(2.9)), ["ignored: on ignored annotation"]);
        assert_eq!(of_one(tram().with_empty(3.0)), ["false: nothing there"]);
        let people = AnnotatedClasses::Only(vec![Pedestrian]);
        assert_eq!(street(&[], &[]).with_empty(5.0).judge(Task::Vehicles, &people).1, ["unknowable"]);
    }

    #[test]
    fn a_detection_without_points_may_match_by_its_box_and_never_by_points() {
        // The car's box is around 1.95 m.
        let empty = || street(&[(Car, 0..40)], &[]).with_empty(2.0);
        let by = |criterion| {
            let params = MatchingParams { criterion, ..STANDARD };
            empty().judge_by(Task::Vehicles, &EVERYTHING, params)
        };
        assert_eq!(by(Criterion::POINTS).0, ["missed: nothing there"]);
        assert_eq!(by(Criterion::POINTS).1, ["false: nothing there"]);
        assert_eq!(by(Criterion::CENTRE).0, ["0 at 0.05"]);
        assert_eq!(by(Criterion::BEV_IOU).0, ["0 at 0.10"]);
        // It floats 50 m above.
        assert_eq!(by(Criterion::IOU_3D).1, ["false: nothing there"]);
    }

    #[test]
    fn points_of_two_detections_are_found_by_both() {
        let shared = street(&[(Car, 0..40)], &[(Vehicle, 0..40), (Vehicle, 0..20)]);
        check(&shared, Task::Vehicles, &["0 at 0.00"], &["0 at 0.00", "false: fragment"]);
        let turned = street(&[(Car, 0..40)], &[(Vehicle, 0..20), (Vehicle, 0..40)]);
        check(&turned, Task::Vehicles, &["1 at 0.00"], &["false: fragment", "0 at 0.00"]);
        // Two detections of one third do not add up to two thirds.
        let twice = street(&[(Car, 0..60)], &[(Vehicle, 0..20), (Vehicle, 0..20)]);
        check(&twice, Task::Vehicles, &["missed: partly found"], &["false: fragment", "false: fragment"]);
    }

    #[test]
    fn what_is_left_over_may_find_what_is_tall_and_is_never_false() {
        let tall = |detections: &[(DetectedClass, Range<u32>)]| {
            let mut street = street(&[(Tree, 0..40), (Tree, 100..140), (Pedestrian, 150..180)], detections);
            for annotation in &mut street.scan.annotations {
                annotation.bounding_box.as_mut().unwrap().length_width_height_m[2] = 6.3;
            }
            street
        };
        let found = tall(&[(Object, 10..50), (Object, 50..70), (Object, 150..180)]);
        check(
            &found,
            Task::Objects,
            &["ignored: tall", "ignored: tall", "2 at 0.00"],
            &["ignored: on ignored annotation", "false: nothing there", "2 at 0.00"],
        );
        let it = assign(&found.scan, &found.detections, Task::Objects, &EVERYTHING, &STANDARD);
        assert_eq!(it.found_tall, [FoundTall { annotation_idx: 0, detection_idx: 0, cost: 0.4 }]);
        // Less than half of it is on the ignored annotation: it is ignored only because it found it.
        let large = tall(&[(Object, 80..165)]);
        let params = MatchingParams { criterion: Criterion::CENTRE, ..STANDARD };
        assert_eq!(large.judge_by(Task::Objects, &EVERYTHING, params).1, ["ignored: on ignored annotation"]);
        let higher = EligibilityParams { tall_above_ground_m: 6.4, ..EligibilityParams::STANDARD };
        let params = MatchingParams { eligibility: higher, ..STANDARD };
        assert_eq!(large.judge_by(Task::Objects, &EVERYTHING, params).0[0], "missed: nothing there");
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
        let params = standard(Criterion::CENTRE);
        let it = assign(&shifted.scan, &shifted.detections, Task::Vehicles, &EVERYTHING, &params);
        assert!(matches!(it.annotations[0], AnnotationOutcome::Matched { detection_idx: 0, .. }));
        assert_eq!(it.detections[1], DetectionOutcome::False(FalseReason::NothingThere));
    }

    #[test]
    fn what_holds_an_object_and_as_much_else_merges_it_with_what_it_holds_more_of() {
        let missed = |annotations: &[(AnnotationClass, Range<u32>)], detection: Range<u32>| {
            street(annotations, &[(Vehicle, detection)]).judge(Task::Vehicles, &EVERYTHING).0[0].clone()
        };
        let two = [(Car, 0..40), (Car, 40..80)];
        assert_eq!(missed(&two, 0..90), "missed: merged with others");
        assert_eq!(missed(&two[..1], 0..90), "missed: merged with background");
        // 40 of another, 41 of none.
        assert_eq!(missed(&two, 0..121), "missed: merged with background");
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
            let params = standard(criterion);
            let (annotations, detections) = two.judge_by(Task::Vehicles, &EVERYTHING, params);
            assert_eq!(annotations, ["0 at 0.46", "missed: merged with background"]);
            assert_eq!(detections, ["0 at 0.46", "false: fragment", "false: nothing there"]);
        }
        two.scan.annotations[0].bounding_box = None;
        let params = standard(Criterion::BEV_IOU);
        let (annotations, detections) = two.judge_by(Task::Vehicles, &EVERYTHING, params);
        assert_eq!(annotations[0], "ignored: no box");
        assert_eq!(detections[0], "ignored: on ignored annotation");
    }
}
