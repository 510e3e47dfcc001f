//! How often, and how far, objects are torn apart or run together, whether or not the pieces match.
//!
//! The entropies are those of Oh et al.: TRAVEL, 2022. Points without a detection, or without an annotation, give no term.

use detector::Detections;
use reports::rows::scan_row::SegmentationNumbers;
use scans::annotation::LabeledScan;

use crate::matching::outcome::{AnnotationOutcome, Assignment};
use crate::matching::point_overlap::PointOverlap;

/// Over- and under-segmentation of one scan. Counts detections of every class, but only the annotations that count in
/// `assignment`.
pub fn segmentation_quality(
    scan: &LabeledScan,
    detections: &Detections,
    assignment: &Assignment,
) -> SegmentationNumbers {
    let overlap = PointOverlap::count(scan, detections);
    let mut quality = SegmentationNumbers::default();
    let (mut over_nats, mut under_nats) = (Vec::new(), Vec::new());
    let mut n_held = vec![0_u32; detections.len()];
    let mut is_touching = vec![false; detections.len()];
    for (annotation_idx, outcome) in assignment.annotations.iter().enumerate() {
        if !matches!(outcome, AnnotationOutcome::Matched { .. } | AnnotationOutcome::Missed(_)) {
            continue;
        }
        let n_points = scan.annotations[annotation_idx].point_indices.len();
        let shared = overlap.of_annotation(annotation_idx);
        over_nats.extend(shared.iter().map(|&(_, n_shared)| entropy_nats(n_shared, n_points)));
        let n_pieces = shared.iter().filter(|&&(_, n_shared)| 10 * n_shared >= n_points).count();
        quality.n_split += u64::from(n_pieces >= 2);
        for &(detection_idx, _) in shared.iter().filter(|&&(_, n_shared)| 2 * n_shared > n_points) {
            n_held[detection_idx] += 1;
        }
        for &(detection_idx, n_shared) in shared {
            let n_points = detections.get(detection_idx).point_indices.len();
            is_touching[detection_idx] = true;
            under_nats.push(entropy_nats(n_shared, n_points));
        }
    }
    quality.over_entropy_nats = sum_in_order(over_nats);
    quality.under_entropy_nats = sum_in_order(under_nats);
    quality.n_touching = is_touching.iter().filter(|&&it| it).count() as u64;
    quality.n_holding = n_held.iter().filter(|&&n| n >= 1).count() as u64;
    quality.n_joining = n_held.iter().filter(|&&n| n >= 2).count() as u64;
    quality
}

/// The sum, equal to the bit for every order of the terms: the order of detections must not change it.
fn sum_in_order(mut terms: Vec<f64>) -> f64 {
    terms.sort_by(f64::total_cmp);
    terms.iter().sum()
}

/// −p ln p of the share `n` of `n_all`; `n` is not 0.
fn entropy_nats(n: usize, n_all: usize) -> f64 {
    let share = n as f64 / n_all as f64;
    // Not minus the product: a share of 1 would give a negative zero.
    share * (n_all as f64 / n as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::assign::assign;
    use crate::matching::criterion::Criterion;
    use crate::matching::drawn_labels::{drawn_in_letters, standard};
    use detector::DetectedClass;
    use reports::vocabulary::class::AnnotationClass;
    use reports::vocabulary::task::Task;
    use scans::dataset::AnnotatedClasses;

    /// Twenty points a letter: each letter of `annotations` and `detections` is one object, a dot is no object.
    fn quality(annotations: &str, detections: &str) -> SegmentationNumbers {
        let (scan, found) =
            drawn_in_letters(20, AnnotationClass::Car, annotations, DetectedClass::Vehicle, detections);
        let (everything, params) = (AnnotatedClasses::EveryObject, standard(Criterion::POINTS));
        let assignment = assign(&scan, &found, Task::Vehicles, &everything, &params);
        segmentation_quality(&scan, &found, &assignment)
    }

    /// Compares the number of annotations that are split, of detections that hold one, and of those that hold several.
    #[track_caller]
    fn check(annotations: &str, detections: &str, expected: [u64; 3]) {
        let SegmentationNumbers { n_split, n_holding, n_joining, .. } = quality(annotations, detections);
        assert_eq!([n_split, n_holding, n_joining], expected, "{annotations}\n{detections}");
    }

    #[test]
    fn one_detection_for_each_annotation_is_neither_split_nor_joined() {
        check("aaaa.bbbb", "xxxx.yyyy", [0, 2, 0]);
    }

    #[test]
    fn an_annotation_in_two_pieces_is_split() {
        check("aaaaaaaaaa", "xxxxxyyyyy", [1, 0, 0]);
        // The second piece holds exactly a tenth.
        check("aaaaaaaaaa", "xxxxxxxxxy", [1, 1, 0]);
    }

    #[test]
    fn less_than_a_tenth_is_no_piece() {
        check("aaaaaaaaaaa", "xxxxxxxxxxy", [0, 1, 0]);
    }

    #[test]
    fn a_detection_that_holds_two_annotations_joins_them() {
        check("aaaa.bbbb", "xxxxxxxxx", [0, 1, 1]);
    }

    #[test]
    fn half_of_an_annotation_is_not_held() {
        check("aaaa.bbbb", "xxxxxxx..", [0, 1, 0]);
    }

    #[test]
    fn what_nobody_found_and_what_is_on_nothing_say_nothing() {
        check("aaaa....", "....xxxx", [0, 0, 0]);
    }

    /// Compares OSE and USE, and the number of detections with a point of an annotation.
    #[track_caller]
    fn check_entropies(annotations: &str, detections: &str, expected_nats: [f64; 2], n_touching: u64) {
        let found = quality(annotations, detections);
        let nats = [found.over_entropy_nats, found.under_entropy_nats];
        let is_close = nats.iter().zip(expected_nats).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(is_close, "{nats:?}\n{annotations}\n{detections}");
        assert_eq!(found.n_touching, n_touching, "{annotations}\n{detections}");
    }

    #[test]
    fn entropies_are_zero_where_nothing_is_torn_or_joined() {
        check_entropies("aaaa.bbbb", "xxxx.yyyy", [0.0, 0.0], 2);
        check_entropies("aaaa.....", ".....xxxx", [0.0, 0.0], 0);
    }

    #[test]
    fn two_halves_are_an_entropy_of_ln_2() {
        let ln_2 = std::f64::consts::LN_2;
        check_entropies("aaaa", "xxyy", [ln_2, 0.0], 2);
        check_entropies("aabb", "xxxx", [0.0, ln_2], 1);
        check_entropies("aaaa.bbcc", "xxyy.zzzz", [ln_2, ln_2], 3);
    }

    #[test]
    fn points_of_nothing_give_no_term() {
        // Half found by one detection, half by none: one term of a half.
        check_entropies("aaaa", "xx..", [0.5 * std::f64::consts::LN_2, 0.0], 1);
        check_entropies("aa..", "xxxx", [0.0, 0.5 * std::f64::consts::LN_2], 1);
    }
}
