//! Matching that does not depend on the order of files: once, the surest detection first.
//!
//! A detection takes the free annotation that it overlaps most, one that counts before one that is ignored. Among detections
//! of like scores the pair with the largest overlap comes first, so that annotations fed back find themselves. Regions
//! without labels excuse in every plane.
//!
//! Everingham et al. 2010 (detections in the order of their scores), Lin et al. 2014 (what is ignored).

use std::cmp::Ordering;

use super::class_scan::{Candidate, ClassScan};
use super::components::Components;
use super::roles::Role;
use super::rules::{Demand, Plane, Question};
use super::scan::{KittiDetection, KittiScan};
use super::score_events::{ScoreEvent, ScoreEvents};
use crate::rows::kitti_object_row::KittiBox;

/// Matches scans; its memory is reused.
#[derive(Debug, Default)]
pub struct SoundMatching {
    candidates: Vec<Candidate>,
    components: Components,
    // For each detection the pair that it takes.
    taken_by: Vec<Option<Candidate>>,
    // Whether each annotation is taken.
    is_taken: Vec<bool>,
}

impl SoundMatching {
    /// Adds the matches of the scan at this index.
    pub fn add(&mut self, index: u32, scan: &ClassScan<'_>, question: &Question, events: &mut ScoreEvents) {
        let n_annotations = scan.n_annotations(question.difficulty);
        events.annotations.extend((n_annotations > 0).then_some((index, n_annotations)));
        self.match_all(scan, *question);
        let min_share = question.class.min_overlap(Plane::Image, Demand::Strict);
        for (detection, KittiDetection { score, .. }) in scan.of_class() {
            match self.taken_by[detection] {
                Some(Candidate { annotation_role: Role::Counts, similarity, .. }) => {
                    let event =
                        ScoreEvent { score: *score, scan: index, tp: 1, fp: 0, n_hits: 0, similarity };
                    events.events.push(event);
                }
                Some(_) => {}
                None if scan.detection_role(detection, question.difficulty) == Role::Ignored => {}
                None if scan.scan.dont_care_share(detection) > min_share => {}
                None => events.falses.push((*score, index)),
            }
        }
    }

    fn match_all(&mut self, scan: &ClassScan<'_>, question: Question) {
        let class = question.class.annotation_class();
        let is_of_class = |it: &Candidate| scan.scan.detections()[it.detection].object.class == class;
        self.candidates.clear();
        self.candidates.extend(scan.candidates(&question).filter(is_of_class));
        self.taken_by.clear();
        self.taken_by.resize(scan.scan.detections().len(), None);
        self.is_taken.clear();
        self.is_taken.resize(scan.scan.annotations().len(), false);
        for component in self.components.split(&mut self.candidates) {
            let mut take = |it: &Candidate| {
                if self.taken_by[it.detection].is_none() && !self.is_taken[it.annotation] {
                    self.taken_by[it.detection] = Some(*it);
                    self.is_taken[it.annotation] = true;
                }
            };
            if let [it] = component {
                take(it);
            } else {
                let mut sorted = component.to_vec();
                sorted.sort_by(|a, b| order(scan.scan, a, b));
                sorted.iter().for_each(take);
            }
        }
    }
}

/// The order in which pairs are taken.
fn order(scan: &KittiScan, a: &Candidate, b: &Candidate) -> Ordering {
    let is_ignored = |it: &Candidate| it.annotation_role == Role::Ignored;
    b.score
        .total_cmp(&a.score)
        .then(is_ignored(a).cmp(&is_ignored(b)))
        .then(b.overlap.total_cmp(&a.overlap))
        .then_with(|| by_content(scan, a, b))
}

/// Orders pairs of equal scores and overlaps by their content, not by their position in files.
fn by_content(scan: &KittiScan, a: &Candidate, b: &Candidate) -> Ordering {
    let boxes =
        |it: &Candidate| [&scan.annotations()[it.annotation].object, &scan.detections()[it.detection].object];
    let numbers = |it: &Candidate| boxes(it).into_iter().flat_map(KittiBox::numbers);
    let mut compared = numbers(a).zip(numbers(b)).map(|(a, b)| a.total_cmp(&b));
    compared.find(|it| it.is_ne()).unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::super::drawn_scan::{QUESTION, annotation, changes, detection, scan};
    use super::super::rules::KittiClass;
    use super::*;
    use crate::vocabulary::class::AnnotationClass::{Car, Van};

    /// Changes at the scores of the detections, as `(score, right, false)`.
    fn events(scan: &KittiScan) -> Vec<(f64, i32, i32)> {
        let mut events = ScoreEvents::default();
        let scan = ClassScan::of(scan, KittiClass::Car);
        SoundMatching::default().add(0, &scan, &QUESTION, &mut events);
        changes(&events)
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
