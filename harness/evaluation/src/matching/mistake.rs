//! Every mistake in words: missed annotations and false detections, and why.

use detector::{Detections, StageProduct};
use reports::vocabulary::reason::{Agreement, FalseReason, MissReason};
use scans::annotation::{LabeledScan, range_m};

use crate::matching::box_overlap::{bev_iou, iou_3d};
use crate::matching::criterion::Criterion;
use crate::matching::lost_points::LostPoints;
use crate::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome};
use crate::matching::point_overlap::PointOverlap;

/// A mistake, in a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// Which kind.
    pub kind: MistakeKind,
    /// What it is about.
    pub of: Judged,
    /// Points of the annotation or the detection.
    pub n_points: usize,
    /// Which object, and why.
    pub text: String,
}

/// What is judged in a scan, by its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Judged {
    /// An annotation.
    Annotation(usize),
    /// A detection.
    Detection(usize),
}

/// Kinds of mistakes, and of what may be one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MistakeKind {
    /// An annotation that nothing found.
    Missed,
    /// A detection of nothing.
    False,
    /// A detection that no other detector has, where nothing is labelled.
    Alone,
}

/// Evidence that explains the mistakes of a detector on a scan.
pub struct Evidence<'a> {
    scan: &'a LabeledScan,
    detections: &'a Detections,
    criterion: Criterion,
    overlap: PointOverlap,
    lost: LostPoints<'a>,
}

/// At most so many other objects are named.
const MAX_NAMED: usize = 3;

impl<'a> Evidence<'a> {
    /// Gathers it from `detections` in `scan` and from the products of the detector's stages.
    pub fn gather(
        scan: &'a LabeledScan,
        detections: &'a Detections,
        products: &'a [StageProduct],
        criterion: Criterion,
    ) -> Self {
        let lost = LostPoints::gather(scan, detections, products);
        let overlap = PointOverlap::count(scan, detections);
        Self { scan, detections, criterion, overlap, lost }
    }

    /// The mistakes of `assignment`: missed annotations, then false detections, most points first; where nothing is labelled,
    /// the detections that no other detector has.
    pub fn mistakes(&self, assignment: &Assignment) -> Vec<Mistake> {
        let missed = assignment.annotations.iter().enumerate().filter_map(|(annotation_idx, outcome)| {
            let AnnotationOutcome::Missed(reason) = outcome else { return None };
            let n_points = self.n_annotation_points(annotation_idx);
            let why = self.why_missed(assignment, annotation_idx, *reason);
            let (name, range) = (self.name(annotation_idx), self.range(annotation_idx));
            let text = format!("{name}: {why} ({n_points} points, {range})");
            let of = Judged::Annotation(annotation_idx);
            Some(Mistake { kind: MistakeKind::Missed, of, n_points, text })
        });
        let of_detections =
            assignment.detections.iter().enumerate().filter_map(|(detection_idx, outcome)| {
                let (kind, why) = match outcome {
                    DetectionOutcome::False(reason) => {
                        (MistakeKind::False, self.why_false(detection_idx, *reason))
                    }
                    DetectionOutcome::Unknowable(Some(Agreement::Alone)) => {
                        (MistakeKind::Alone, Agreement::Alone.name().to_owned())
                    }
                    _ => return None,
                };
                let detection = self.detections.get(detection_idx);
                let n_points = detection.point_indices.len();
                let score = detection.score.map(|it| format!(" {it:.2}")).unwrap_or_default();
                let class = detection.class_name();
                let range_m = detection.bounding_box.range_m();
                let text = format!(
                    "detection {detection_idx}: {why} ({class}{score}, {n_points} points, {range_m:.0} m)"
                );
                let of = Judged::Detection(detection_idx);
                Some(Mistake { kind, of, n_points, text })
            });
        let mut mistakes: Vec<Mistake> = missed.chain(of_detections).collect();
        mistakes.sort_by_key(|it| (it.kind, std::cmp::Reverse(it.n_points)));
        mistakes
    }

    fn why_missed(&self, assignment: &Assignment, annotation_idx: usize, reason: MissReason) -> String {
        let parts = self.overlap.of_annotation(annotation_idx);
        let Some(&(detection_idx, n_shared)) = parts.iter().max_by_key(|(_, n_shared)| *n_shared) else {
            return match reason {
                MissReason::DetectorFailed => {
                    "the detector failed, and gave no answer to this scan".to_owned()
                }
                // By boxes or centres, which need no common point.
                MissReason::TakenByAnother | MissReason::WrongClass => {
                    format!("{}; no detection has any of its points", reason.name())
                }
                _ => format!("not detected: {}", self.losses(annotation_idx)),
            };
        };
        let agreement = self.agreement(annotation_idx, detection_idx);
        match reason {
            MissReason::WrongClass => {
                let detection = self.detections.get(detection_idx);
                let score =
                    detection.score.map_or("because of its size".to_owned(), |it| format!("score {it:.2}"));
                format!("detection {detection_idx} is classified as background, {score}")
            }
            MissReason::MergedWithOthers | MissReason::MergedWithBackground => {
                let others = self.others(detection_idx, annotation_idx);
                format!("merged with {others} in detection {detection_idx}; {agreement}")
            }
            MissReason::Split => {
                let mut sizes: Vec<usize> = parts.iter().map(|(_, n_shared)| *n_shared).collect();
                sizes.sort_unstable_by(|a, b| b.cmp(a));
                let sizes: Vec<String> = sizes.iter().take(MAX_NAMED).map(usize::to_string).collect();
                let etc = if parts.len() > MAX_NAMED { ", …" } else { "" };
                format!("split into {} of {}{etc} points; best {agreement}", parts.len(), sizes.join(", "))
            }
            MissReason::OutsideGrid
            | MissReason::Clutter
            | MissReason::Ground
            | MissReason::Tall
            | MissReason::Wall
            | MissReason::ClusterSize
            | MissReason::NothingThere
            | MissReason::PartlyFound
            | MissReason::DetectorFailed => {
                let losses = self.losses(annotation_idx);
                format!("detection {detection_idx} has {n_shared} of its points; {agreement}; {losses}")
            }
            MissReason::TakenByAnother => {
                let of_annotation = |it: &usize| match assignment.annotations[*it] {
                    AnnotationOutcome::Matched { detection_idx, .. } => {
                        parts.iter().any(|part| part.0 == detection_idx)
                    }
                    _ => false,
                };
                let takers: Vec<String> = (0..assignment.annotations.len())
                    .filter(of_annotation)
                    .map(|annotation_idx| self.name(annotation_idx))
                    .collect();
                format!("detection {detection_idx} is matched with {}", listed(&takers))
            }
        }
    }

    fn why_false(&self, detection_idx: usize, reason: FalseReason) -> String {
        let mut shared: Vec<(usize, usize)> = self.overlap.of_detection(detection_idx).to_vec();
        shared.sort_by_key(|&(_, n_shared)| std::cmp::Reverse(n_shared));
        let Some(&(annotation_idx, n_shared)) = shared.first() else {
            return "nothing is annotated there".to_owned();
        };
        let name = self.name(annotation_idx);
        let n_annotation = self.n_annotation_points(annotation_idx);
        let agreement = self.agreement(annotation_idx, detection_idx);
        match reason {
            FalseReason::NothingThere => {
                format!("only {n_shared} points are annotated, as {name}; {agreement}")
            }
            FalseReason::WrongClass => format!("{name} is not a vehicle"),
            FalseReason::Fragment => {
                format!("only a part of {name}, {n_shared} of {n_annotation} points; {agreement}")
            }
            FalseReason::JoinsSeveral => {
                let names: Vec<String> = shared.iter().map(|it| self.name(it.0)).collect();
                format!("joins {}; best {agreement}", listed(&names))
            }
            FalseReason::TooLarge => {
                let n_points = self.detections.get(detection_idx).point_indices.len();
                format!("has {name} and {} other points; {agreement}", n_points - n_shared)
            }
        }
    }

    /// In words, where the undetected points of an annotation were lost.
    fn losses(&self, annotation_idx: usize) -> String {
        let point_indices = &self.scan.annotations[annotation_idx].point_indices;
        let reasons = self.lost.reasons(point_indices).into_iter();
        let mut said: Vec<String> = reasons
            .map(|(reason, n_points)| match reason {
                MissReason::NothingThere => format!("{n_points} in no object"),
                MissReason::ClusterSize => format!("{n_points} in clusters of a wrong size"),
                _ => format!("{n_points} {}", reason.name()),
            })
            .collect();
        let largest = self.lost.largest_cluster(point_indices);
        if largest > 0 {
            said.push(format!("the largest such cluster has {largest}"));
        }
        said.join(", ")
    }

    /// In words, the other annotations of a detection, or the number of its points without annotation.
    fn others(&self, detection_idx: usize, annotation_idx: usize) -> String {
        let mut others: Vec<(usize, usize)> = self
            .overlap
            .of_detection(detection_idx)
            .iter()
            .copied()
            .filter(|it| it.0 != annotation_idx)
            .collect();
        others.sort_by_key(|&(_, n_shared)| std::cmp::Reverse(n_shared));
        if others.is_empty() {
            let own = self.overlap.of_annotation(annotation_idx).iter();
            let n_own: usize = own.filter(|it| it.0 == detection_idx).map(|it| it.1).sum();
            let n_points = self.detections.get(detection_idx).point_indices.len();
            return format!("{} points without annotation", n_points - n_own);
        }
        listed(&others.iter().map(|it| self.name(it.0)).collect::<Vec<_>>())
    }

    /// In words, how well the pair agrees, compared with the gate.
    fn agreement(&self, annotation_idx: usize, detection_idx: usize) -> String {
        let annotation = &self.scan.annotations[annotation_idx];
        let detection = self.detections.get(detection_idx);
        let of_boxes = |iou: fn(&_, &_) -> f64| {
            annotation.bounding_box.map_or(0.0, |labelled| iou(&labelled, &detection.bounding_box))
        };
        let (iou, min_iou) = match self.criterion {
            Criterion::Points { min_iou } => {
                let shared = self.overlap.of_annotation(annotation_idx).iter();
                let n_shared: usize = shared.filter(|it| it.0 == detection_idx).map(|it| it.1).sum();
                let n_union = annotation.point_indices.len() + detection.point_indices.len() - n_shared;
                (n_shared as f64 / n_union as f64, min_iou)
            }
            Criterion::BevIou { min_iou } => (of_boxes(bev_iou), min_iou),
            Criterion::Iou3d { min_iou } => (of_boxes(iou_3d), min_iou),
            Criterion::Centre { max_distance_m } => {
                let found_m = detection.bounding_box.center_m;
                let distance_m = annotation.center_m(&self.scan.cloud).map_or(f64::INFINITY, |at_m| {
                    let apart_m = |axis: usize| f64::from(found_m[axis]) - f64::from(at_m[axis]);
                    apart_m(0).hypot(apart_m(1))
                });
                return format!(
                    "centres {distance_m:.1} m apart, allowed are less than {max_distance_m:.1} m"
                );
            }
        };
        if iou < min_iou {
            format!("IoU {iou:.2} < {min_iou:.2}")
        } else {
            format!("IoU {iou:.2}, but another match is better")
        }
    }

    fn name(&self, annotation_idx: usize) -> String {
        self.scan.annotations[annotation_idx].label()
    }

    fn range(&self, annotation_idx: usize) -> String {
        let at_m = self.scan.annotations[annotation_idx].center_m(&self.scan.cloud);
        at_m.map_or("nowhere".to_owned(), |it| format!("{:.0} m", range_m(it)))
    }

    fn n_annotation_points(&self, annotation_idx: usize) -> usize {
        self.scan.annotations[annotation_idx].point_indices.len()
    }
}

/// The first few of `names`, and how many more there are.
fn listed(names: &[String]) -> String {
    let first = names.iter().take(MAX_NAMED).cloned().collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MAX_NAMED) {
        0 => first,
        n_more => format!("{first} and {n_more} more"),
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use detector::DetectedClass;
    use detector::stage_product::Shape;
    use detector::surface_class::SurfaceClass;

    use super::*;
    use crate::matching::assign::assign;
    use crate::matching::drawn_labels::{annotations_in_row, detections_in_row, labeled, row, standard};
    use reports::vocabulary::class::AnnotationClass::{self, Car, Pedestrian};
    use reports::vocabulary::task::Task;
    use scans::annotation::Annotation;
    use scans::dataset::AnnotatedClasses;

    const N_POINTS: u32 = 200;

    /// Points along x, 10 cm apart; annotations, detections, dropped clusters and surfaces are ranges of them.
    #[track_caller]
    fn check_by(
        criterion: Criterion,
        annotations: &[(AnnotationClass, Range<u32>)],
        detections: &[(DetectedClass, Range<u32>)],
        lost: &[(SurfaceClass, Range<u32>)],
        expected: &[&str],
    ) {
        let annotations = (0..).zip(annotations_in_row(annotations));
        let annotations = annotations.map(|(number, it)| Annotation { track: Some(number), ..it });
        let scan = labeled(row(N_POINTS), annotations);
        let all = detections_in_row(detections, Some(-0.25));
        let mut surfaces = vec![SurfaceClass::Short; N_POINTS as usize];
        let mut clusters = vec![None; N_POINTS as usize];
        for (class, range) in lost {
            let range = range.start as usize..range.end as usize;
            surfaces[range.clone()].fill(*class);
            if *class == SurfaceClass::Short {
                clusters[range.clone()].fill(Some(range.start as u32));
            }
        }
        let product = |name, shape| StageProduct { stage: "drawn", name, shape };
        let products = [
            product("points", Shape::LabeledPoints(surfaces)),
            product("clusters", Shape::Clusters(clusters)),
        ];
        let annotated = AnnotatedClasses::EveryObject;
        let assignment = assign(&scan, &all, Task::Vehicles, &annotated, &standard(criterion));
        let evidence = Evidence::gather(&scan, &all, &products, criterion);
        let found: Vec<String> = evidence.mistakes(&assignment).into_iter().map(|it| it.text).collect();
        assert_eq!(found, expected);
    }

    #[track_caller]
    fn check(
        annotations: &[(AnnotationClass, Range<u32>)],
        detections: &[(DetectedClass, Range<u32>)],
        lost: &[(SurfaceClass, Range<u32>)],
        expected: &[&str],
    ) {
        check_by(Criterion::POINTS, annotations, detections, lost, expected);
    }

    use DetectedClass::{Object, Vehicle};

    #[test]
    fn where_points_were_lost_is_said() {
        use SurfaceClass::{Clutter, Ground, Short, Tall, Unseen};
        let lost = [(Ground, 0..20), (Tall, 20..32), (Short, 32..41), (Clutter, 41..45), (Unseen, 45..47)];
        let expected = "car 0: not detected: 20 taken for ground, \
            12 taken for tall, 9 in clusters of a wrong size, 4 taken for clutter, 3 in no object, \
            2 outside of the grid, the largest such cluster has 9 (50 points, 2 m)";
        check(&[(Car, 0..50)], &[], &lost, &[expected]);
        let partly = "car 0: detection 0 has 20 of its points; IoU 0.40 < 0.50; \
            30 taken for ground (50 points, 2 m)";
        let fragment = "detection 0: only a part of car 0, 20 of 50 points; IoU 0.40 < 0.50 \
            (vehicle -0.25, 20 points, 1 m)";
        check(&[(Car, 0..50)], &[(Vehicle, 0..20)], &[(Ground, 20..50)], &[partly, fragment]);
    }

    #[test]
    fn what_it_was_merged_with_is_named() {
        check(
            &[(Car, 0..40), (Car, 40..80)],
            &[(Vehicle, 0..90)],
            &[],
            &[
                "car 0: merged with car 1 in detection 0; IoU 0.44 < 0.50 (40 points, 2 m)",
                "car 1: merged with car 0 in detection 0; IoU 0.44 < 0.50 (40 points, 6 m)",
                "detection 0: joins car 0, car 1; best IoU 0.44 < 0.50 (vehicle -0.25, 90 points, 4 m)",
            ],
        );
        check(
            &[(Car, 0..40)],
            &[(Vehicle, 0..90)],
            &[],
            &[
                "car 0: merged with 50 points without annotation in detection 0; \
                    IoU 0.44 < 0.50 (40 points, 2 m)",
                "detection 0: has car 0 and 50 other points; IoU 0.44 < 0.50 \
                    (vehicle -0.25, 90 points, 4 m)",
            ],
        );
        check(
            &[(Car, 0..40), (Car, 40..80)],
            &[(Vehicle, 0..80)],
            &[],
            &["car 1: detection 0 is matched with car 0 (40 points, 6 m)"],
        );
    }

    #[test]
    fn splits_classes_and_empty_positions_are_explained() {
        check(
            &[(Car, 0..60)],
            &[(Object, 0..25), (Object, 25..50)],
            &[],
            &["car 0: split into 2 of 25, 25 points; best IoU 0.42 < 0.50 (60 points, 3 m)"],
        );
        check(
            &[(Car, 0..40), (Pedestrian, 50..90)],
            &[(Object, 0..40), (Vehicle, 50..90), (Vehicle, 100..120)],
            &[],
            &[
                "car 0: detection 0 is classified as background, score -0.25 (40 points, 2 m)",
                "detection 1: pedestrian 1 is not a vehicle (vehicle -0.25, 40 points, 7 m)",
                "detection 2: nothing is annotated there (vehicle -0.25, 20 points, 11 m)",
            ],
        );
    }

    #[test]
    fn the_gate_is_that_of_the_criterion() {
        let off = [(Vehicle, 25..60)];
        check_by(
            Criterion::CENTRE,
            &[(Car, 0..40)],
            &off,
            &[],
            &[
                "car 0: detection 0 has 15 of its points; centres 2.3 m apart, allowed are less than 2.0 m; \
                    25 in no object (40 points, 2 m)",
                "detection 0: only 15 points are annotated, as car 0; \
                    centres 2.3 m apart, allowed are less than 2.0 m (vehicle -0.25, 35 points, 4 m)",
            ],
        );
    }
}
