//! Matching that does not depend on the order of files: once, the surest detection first.
//!
//! A detection takes the free annotation that it overlaps most, one that counts before one that is ignored. Among detections of like scores
//! the pair with the largest overlap comes first, so that annotations fed back find themselves. Regions without labels excuse in every
//! plane.
//!
//! Everingham et al. 2010 (detections in the order of their scores), Lin et al. 2014 (what is ignored).

use std::cmp::Ordering;

use super::roles::{Role, Roles};
use super::rules::{Demand, Plane, Question};
use super::scan::{KittiPair, KittiScan};
use super::score_events::{ScoreEvent, ScoredMatches};
use crate::rows::kitti_object_row::KittiBox;

/// Matches all `scans`; of each, its place is told in events.
pub fn sound_matches<'a>(
    scans: impl IntoIterator<Item = (u32, &'a KittiScan)>,
    question: &Question,
) -> ScoredMatches {
    let mut matches = ScoredMatches::default();
    for (place, scan) in scans {
        let roles = Roles::of(scan, question);
        let n_annotations = roles.n_annotations();
        if n_annotations > 0 {
            matches.annotations.push((place, n_annotations));
        }
        let found = found_by_detections(scan, *question, &roles);
        let min_share = question.class.min_overlap(Plane::Image, Demand::Strict);
        for (detection_idx, detection) in scan.detections().iter().enumerate() {
            if detection.object.class != question.class.annotation_class() {
                continue;
            }
            let (tp, fp, similarity) = match found[detection_idx] {
                Some(annotation) if roles.annotations[annotation] == Role::Counts => {
                    let seen_rad = scan.annotations()[annotation].object.alpha_rad;
                    (1, 0, f64::midpoint(1.0, (seen_rad - detection.object.alpha_rad).cos()))
                }
                Some(_) => continue,
                None if roles.detections[detection_idx] == Role::Ignored => continue,
                None if scan.dont_care_share(detection_idx) > min_share => continue,
                None => (0, 1, 0.0),
            };
            matches.events.push(ScoreEvent { score: detection.score, scan: place, tp, fp, similarity });
        }
    }
    matches.sort();
    matches
}

/// Of each detection the annotation that it takes.
fn found_by_detections(scan: &KittiScan, question: Question, roles: &Roles) -> Vec<Option<usize>> {
    let min_overlap = question.min_overlap();
    let class = question.class.annotation_class();
    let mut candidates: Vec<(&KittiPair, f64)> = scan
        .pairs()
        .iter()
        .map(|it| (it, it.overlap_in(&question)))
        .filter(|(it, overlap)| {
            *overlap > min_overlap
                && roles.annotations[it.annotation] != Role::Absent
                && scan.detections()[it.detection].object.class == class
        })
        .collect();
    let is_ignored = |pair: &KittiPair| roles.annotations[pair.annotation] == Role::Ignored;
    let score = |pair: &KittiPair| scan.detections()[pair.detection].score;
    candidates.sort_by(|(a, overlap_of_a), (b, overlap_of_b)| {
        score(b)
            .total_cmp(&score(a))
            .then(is_ignored(a).cmp(&is_ignored(b)))
            .then(overlap_of_b.total_cmp(overlap_of_a))
            .then_with(|| by_content(scan, a, b))
    });
    let mut taken_by = vec![None; scan.detections().len()];
    let mut is_taken = vec![false; scan.annotations().len()];
    for (pair, _) in candidates {
        if taken_by[pair.detection].is_none() && !is_taken[pair.annotation] {
            taken_by[pair.detection] = Some(pair.annotation);
            is_taken[pair.annotation] = true;
        }
    }
    taken_by
}

/// Tells pairs of like scores and overlaps apart by what they are, not by where they stand in files.
fn by_content(scan: &KittiScan, a: &KittiPair, b: &KittiPair) -> Ordering {
    let boxes =
        |it: &KittiPair| [&scan.annotations()[it.annotation].object, &scan.detections()[it.detection].object];
    let numbers = |it: &KittiPair| boxes(it).into_iter().flat_map(numbers_of);
    let mut compared = numbers(a).zip(numbers(b)).map(|(a, b)| a.total_cmp(&b));
    compared.find(|it| it.is_ne()).unwrap_or(Ordering::Equal)
}

fn numbers_of(it: &KittiBox) -> impl Iterator<Item = f64> {
    let in_image = it.left_top_right_bottom_px.into_iter().chain([it.alpha_rad]);
    in_image.chain(it.bottom_center_m).chain(it.height_width_length_m).chain([it.rotation_y_rad])
}

#[cfg(test)]
mod tests {
    use super::super::drawn_scan::{annotation, detection, scan};
    use super::super::rules::{Difficulty, KittiClass};
    use super::*;
    use crate::vocabulary::class::AnnotationClass::{Car, Van};

    const QUESTION: Question = Question {
        class: KittiClass::Car,
        difficulty: Difficulty::Moderate,
        plane: Plane::Volume,
        demand: Demand::Strict,
    };

    /// What detections of these scores find, as `(score, right, false)`.
    fn events(scan: &KittiScan) -> Vec<(f64, i32, i32)> {
        let matches = sound_matches([(0, scan)], &QUESTION);
        matches.events.iter().map(|it| (it.score, it.tp, it.fp)).collect()
    }

    #[test]
    fn the_surest_takes_first_and_the_second_is_false() {
        let two = [detection(Car, 0.0, 0.5), detection(Car, 0.1, 0.9)];
        let it = scan(&[annotation(Car, 0.0)], &two, &[(0, 0, 0.95), (0, 1, 0.8)]);
        assert_eq!(events(&it), [(0.9, 1, 0), (0.5, 0, 1)]);
    }

    #[test]
    fn detections_of_like_scores_take_what_they_overlap_most() {
        // The first would take the annotation of the second.
        let two = [detection(Car, 0.0, 0.5), detection(Car, 0.1, 0.5)];
        let both = [annotation(Car, 0.0), annotation(Car, 0.1)];
        let pairs = [(0, 0, 0.8), (0, 1, 0.9), (1, 0, 0.75)];
        assert_eq!(events(&scan(&both, &two, &pairs)), [(0.5, 1, 0), (0.5, 1, 0)]);
    }

    #[test]
    fn what_finds_something_ignored_is_neither_right_nor_false() {
        let both = [annotation(Van, 0.0), annotation(Car, 0.1)];
        let one = [detection(Car, 0.0, 0.5)];
        assert_eq!(events(&scan(&both, &one, &[(0, 0, 0.9)])), []);
        // It is right where it can be.
        assert_eq!(events(&scan(&both, &one, &[(0, 0, 0.9), (1, 0, 0.8)])), [(0.5, 1, 0)]);
    }

    #[test]
    fn what_is_low_is_not_false() {
        let mut low = detection(Car, 0.0, 0.5);
        low.object.left_top_right_bottom_px[3] = 124.0;
        assert_eq!(events(&scan(&[annotation(Car, 0.0)], &[low], &[])), []);
        assert_eq!(events(&scan(&[annotation(Car, 0.0)], &[low], &[(0, 0, 0.8)])), [(0.5, 1, 0)]);
    }
}
