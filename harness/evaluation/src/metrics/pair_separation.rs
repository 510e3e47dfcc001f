//! Whether two objects next to each other were separated.

use crate::matching::assign::{MatchingParams, assign};
use crate::matching::outcome::AnnotationOutcome;
use crate::matching::point_overlap::PointOverlap;
use detector::Detections;
use reports::vocabulary::task::Task;
use scans::annotation::LabeledScan;
use scans::dataset::AnnotatedClasses;

/// Outcome of a pair of objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PairOutcome {
    /// One of the two has too few points to be judged, or none: hidden by the other, or too thin.
    NotSeen,
    /// Each has a detection of its own, matched as in any run, and no detection joins the two.
    Separated,
    /// A detection holds more than [`JOINING_SHARE`] of the points of each.
    Joined,
    /// Neither separated nor joined: at least one of them was lost or torn apart.
    Lost,
}

/// A detection with more than this share of the points of both objects joins them.
pub const JOINING_SHARE: f64 = 0.1;

/// Definition of *separated*, for tables and pages.
pub const SEPARATED: &str = "Separated: each of the two objects matches a detection of its own (points, IoU at \
    least 0.5), and no detection has more than a tenth of the points of both. Pairs with an object of fewer than \
    20 points are not judged.";

/// Judges the pairs of `scan`, each given by the tracks of its two objects. Whether an object is judged at all and when
/// it is matched is as in the task *objects*.
pub fn judge_pairs(
    scan: &LabeledScan,
    detections: &Detections,
    pairs: &[[u32; 2]],
    matching: &MatchingParams,
) -> Vec<PairOutcome> {
    let assignment = assign(scan, detections, Task::Objects, &AnnotatedClasses::EveryObject, matching);
    let overlap = PointOverlap::count(scan, detections);
    let judge = |tracks: &[u32; 2]| {
        let index = |track: u32| scan.annotations.iter().position(|it| it.track == Some(track));
        let [Some(one), Some(other)] = tracks.map(index) else { return PairOutcome::NotSeen };
        let outcomes = [one, other].map(|annotation_idx| assignment.annotations[annotation_idx]);
        let is_judged = |it: &AnnotationOutcome| {
            matches!(it, AnnotationOutcome::Matched { .. } | AnnotationOutcome::Missed(_))
        };
        if !outcomes.iter().all(is_judged) {
            PairOutcome::NotSeen
        } else if is_joined(scan, &overlap, [one, other]) {
            PairOutcome::Joined
        } else if outcomes.iter().all(|it| matches!(it, AnnotationOutcome::Matched { .. })) {
            PairOutcome::Separated
        } else {
            PairOutcome::Lost
        }
    };
    pairs.iter().map(judge).collect()
}

fn is_joined(scan: &LabeledScan, overlap: &PointOverlap, pair: [usize; 2]) -> bool {
    let [held, held_of_other] = pair.map(|annotation_idx| {
        let least = JOINING_SHARE * scan.annotations[annotation_idx].point_indices.len() as f64;
        let holding = overlap.of_annotation(annotation_idx).iter().filter(move |(_, n)| *n as f64 > least);
        holding.map(|(detection_idx, _)| *detection_idx).collect::<Vec<_>>()
    });
    held.iter().any(|detection_idx| held_of_other.contains(detection_idx))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::criterion::Criterion;
    use crate::matching::drawn_labels::{drawn_in_letters, standard};
    use detector::DetectedClass;
    use reports::vocabulary::class::AnnotationClass;

    /// Judges the pair of the objects `a` and `b`, of ten points a letter.
    #[track_caller]
    fn check(objects: &str, detections: &str, expected: PairOutcome) {
        let (mut scan, found) =
            drawn_in_letters(10, AnnotationClass::Pedestrian, objects, DetectedClass::Object, detections);
        for (annotation, track) in scan.annotations.iter_mut().zip(0..) {
            annotation.track = Some(track);
        }
        let matching = standard(Criterion::POINTS);
        assert_eq!(judge_pairs(&scan, &found, &[[0, 1]], &matching), [expected], "{objects}\n{detections}");
    }

    #[test]
    fn a_detection_for_each_separates() {
        check("aaaa.bbbb", "xxxx.yyyy", PairOutcome::Separated);
        check("aaaa.bbbb", "xxxxxyyyz", PairOutcome::Separated);
    }

    #[test]
    fn one_detection_for_both_joins() {
        check("aaaa.bbbb", "xxxxxxxxx", PairOutcome::Joined);
        check("aaaa.bb", "xxxxxxx", PairOutcome::Joined);
    }

    #[test]
    fn a_tenth_of_the_other_does_not_join_and_more_does() {
        check("aaaaaaaaaabbbbbbbbbb", "xxxxxxxxxxxyyyyyyyyy", PairOutcome::Separated);
        check("aaaaaaaaaabbbbbbbbbb", "xxxxxxxxxxxxyyyyyyyy", PairOutcome::Joined);
    }

    #[test]
    fn who_misses_one_does_not_separate() {
        check("aaaa.bbbb", "xxxx.....", PairOutcome::Lost);
        check("aaaa.bbbb", "xxyz.xxxx".replace("xxxx", "....").as_str(), PairOutcome::Lost);
    }

    #[test]
    fn what_is_hidden_is_not_judged() {
        check("aaaa.....", "xxxx.....", PairOutcome::NotSeen);
        check("aaaa.b...", "xxxx.y...", PairOutcome::NotSeen);
    }
}
