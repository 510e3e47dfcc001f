//! Matching as the development kit does it: annotation by annotation, in the order of the files, anew for each least score.
//!
//! It runs twice: first with all detections, where an annotation takes the surest that overlaps it enough; the scores of
//! these hits become the least scores that precision is looked up at. Then for each of these, where an annotation takes the
//! detection that overlaps it most. Each component of pairs is matched by itself.

use super::class_scan::{Candidate, ClassScan};
use super::components::Components;
use super::roles::Role;
use super::rules::{Plane, Question};
use super::score_events::{ScoreEvent, ScoreEvents};

/// Matches scans; its memory is reused.
#[derive(Debug, Default)]
pub struct OfficialMatching {
    candidates: Vec<Candidate>,
    components: Components,
    // For each detection whether its pair is a component by itself, and whether it is taken.
    is_alone: Vec<bool>,
    is_taken: Vec<bool>,
}

/// Right detections among those of at least some score.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    tp: i32,
    // Matched detections that would be false, had they found nothing.
    n_excused: i32,
    similarity: f64,
}

impl OfficialMatching {
    /// Adds the matches of the scan at this index.
    pub fn add(&mut self, index: u32, scan: &ClassScan<'_>, question: &Question, events: &mut ScoreEvents) {
        let n_annotations = scan.n_annotations(question.difficulty);
        events.annotations.extend((n_annotations > 0).then_some((index, n_annotations)));
        for flags in [&mut self.is_alone, &mut self.is_taken] {
            flags.clear();
            flags.resize(scan.scan.detections().len(), false);
        }
        let can_be_false = |detection: usize| can_be_false(scan, *question, detection);
        self.candidates.clear();
        self.candidates.extend(scan.candidates(question));
        for component in self.components.split(&mut self.candidates) {
            if let [it] = component {
                self.is_alone[it.detection] = true;
                events.events.extend(found_alone(it, index));
            } else {
                let mut component = Component { pairs: component, is_taken: &mut self.is_taken };
                component.add_hits(index, &mut events.events);
                component.add_changes(index, can_be_false, &mut events.events);
            }
        }
        let falses = scan.of_class().filter(|(it, _)| !self.is_alone[*it] && can_be_false(*it));
        events.falses.extend(falses.map(|(_, it)| (it.score, index)));
    }
}

/// Whether a detection is false where it finds nothing.
fn can_be_false(scan: &ClassScan<'_>, question: Question, detection: usize) -> bool {
    // Regions without labels have no position in the world, so they excuse in the image only.
    let is_excused =
        || question.plane == Plane::Image && scan.scan.dont_care_share(detection) > question.min_overlap();
    scan.detection_role(detection, question.difficulty) == Role::Counts && !is_excused()
}

fn is_found_by(it: &Candidate) -> bool {
    it.annotation_role == Role::Counts && it.detection_role == Role::Counts
}

/// Event of a pair that is a component by itself; `None` unless annotation and detection count.
fn found_alone(it: &Candidate, scan: u32) -> Option<ScoreEvent> {
    let Candidate { score, similarity, .. } = *it;
    is_found_by(it).then_some(ScoreEvent { score, scan, tp: 1, fp: 0, n_hits: 1, similarity })
}

/// A component of pairs.
struct Component<'a> {
    // In the order of annotations, then detections.
    pairs: &'a [Candidate],
    is_taken: &'a mut [bool],
}

impl Component<'_> {
    fn free_all(&mut self) {
        for it in self.pairs {
            self.is_taken[it.detection] = false;
        }
    }

    /// Adds the scores of the hits, where every annotation takes the surest detection that is free, the first among equals.
    fn add_hits(&mut self, scan: u32, events: &mut Vec<ScoreEvent>) {
        self.free_all();
        for of_annotation in self.pairs.chunk_by(|a, b| a.annotation == b.annotation) {
            let mut surest: Option<&Candidate> = None;
            for it in of_annotation.iter().filter(|it| !self.is_taken[it.detection]) {
                if surest.is_none_or(|surest| it.score > surest.score) {
                    surest = Some(it);
                }
            }
            let Some(it) = surest else { continue };
            self.is_taken[it.detection] = true;
            if is_found_by(it) {
                events.push(ScoreEvent { score: it.score, scan, tp: 0, fp: 0, n_hits: 1, similarity: 0.0 });
            }
        }
    }

    /// Adds the changes at the score of every detection.
    fn add_changes(&mut self, scan: u32, can_be_false: impl Fn(usize) -> bool, events: &mut Vec<ScoreEvent>) {
        let mut scores: Vec<f64> = self.pairs.iter().map(|it| it.score).collect();
        scores.sort_by(|a, b| b.total_cmp(a));
        scores.dedup();
        let mut before = Found::default();
        for score in scores {
            let found = self.found(score, &can_be_false);
            let (tp, fp) = (found.tp - before.tp, before.n_excused - found.n_excused);
            let similarity = found.similarity - before.similarity;
            events.push(ScoreEvent { score, scan, tp, fp, n_hits: 0, similarity });
            before = found;
        }
    }

    /// Right detections among those of at least `min_score`. False ones are counted elsewhere, as if nothing were found.
    fn found(&mut self, min_score: f64, can_be_false: &impl Fn(usize) -> bool) -> Found {
        self.free_all();
        let mut found = Found::default();
        for of_annotation in self.pairs.chunk_by(|a, b| a.annotation == b.annotation) {
            let Some(it) = self.most_overlapping(of_annotation, min_score) else { continue };
            self.is_taken[it.detection] = true;
            found.n_excused += i32::from(can_be_false(it.detection));
            if is_found_by(it) {
                found.tp += 1;
                found.similarity += it.similarity;
            }
        }
        found
    }

    /// The detection that counts and overlaps most, the first among equals; without one, the first that is ignored.
    fn most_overlapping<'a>(&self, of_annotation: &'a [Candidate], min_score: f64) -> Option<&'a Candidate> {
        let is_free = |it: &&Candidate| !self.is_taken[it.detection] && it.score >= min_score;
        let (mut most, mut ignored): (Option<&Candidate>, Option<&Candidate>) = (None, None);
        for it in of_annotation.iter().filter(is_free) {
            if it.detection_role == Role::Ignored {
                ignored = ignored.or(Some(it));
            } else if most.is_none_or(|most| it.overlap > most.overlap) {
                most = Some(it);
            }
        }
        most.or(ignored)
    }
}

#[cfg(test)]
mod tests {
    use super::super::drawn_scan::{QUESTION, annotation, changes, detection, scan};
    use super::super::rules::KittiClass;
    use super::super::scan::KittiScan;
    use super::*;
    use crate::vocabulary::class::AnnotationClass::{Car, Van};

    /// Scores that thresholds are taken from, and the numbers of right and false detections down to each score.
    fn counted(scan: &KittiScan) -> (Vec<f64>, Vec<(f64, i32, i32)>) {
        let mut events = ScoreEvents::default();
        let scan = ClassScan::of(scan, KittiClass::Car);
        OfficialMatching::default().add(0, &scan, &QUESTION, &mut events);
        let (mut tp, mut fp) = (0, 0);
        let mut counted: Vec<(f64, i32, i32)> = Vec::new();
        for change in changes(&events) {
            (tp, fp) = (tp + change.1, fp + change.2);
            counted.retain(|it| it.0 != change.0);
            counted.push((change.0, tp, fp));
        }
        let mut hits: Vec<f64> = events.events.iter().filter(|it| it.n_hits > 0).map(|it| it.score).collect();
        hits.sort_by(|a, b| b.total_cmp(a));
        (hits, counted)
    }

    #[test]
    fn thresholds_come_from_the_surest_and_counts_from_the_best_overlap() {
        let two = [detection(Car, 0.0, 0.5), detection(Car, 0.1, 0.9)];
        let it = scan(&[annotation(Car, 0.0)], &two, &[(0, 0, 0.95), (0, 1, 0.8)]);
        assert_eq!(counted(&it), (vec![0.9], vec![(0.9, 1, 0), (0.5, 1, 1)]));
    }

    #[test]
    fn a_detection_that_joins_can_take_an_annotation_away() {
        // With the less sure detection the first annotation takes what the second needs.
        let both = [annotation(Car, 0.0), annotation(Car, 0.1)];
        let two = [detection(Car, 0.0, 0.9), detection(Car, 0.1, 0.5)];
        let it = scan(&both, &two, &[(0, 0, 0.8), (0, 1, 0.9), (1, 1, 0.85)]);
        assert_eq!(counted(&it), (vec![0.9, 0.5], vec![(0.9, 1, 0), (0.5, 1, 1)]));
    }

    #[test]
    fn annotations_take_in_the_order_of_the_file() {
        let both = [annotation(Car, 0.0), annotation(Car, 0.1)];
        let one = [detection(Car, 0.0, 0.9)];
        let two = scan(&both, &[one[0], detection(Car, 0.1, 0.5)], &[(0, 0, 0.8), (0, 1, 0.75), (1, 0, 0.9)]);
        assert_eq!(counted(&two).0, [0.9]);
        let other =
            scan(&both, &[one[0], detection(Car, 0.1, 0.5)], &[(1, 0, 0.8), (1, 1, 0.75), (0, 0, 0.9)]);
        assert_eq!(counted(&other).0, [0.9, 0.5]);
    }

    #[test]
    fn what_finds_something_ignored_is_neither_right_nor_false() {
        let it = scan(&[annotation(Van, 0.0)], &[detection(Car, 0.0, 0.9)], &[(0, 0, 0.8)]);
        assert_eq!(counted(&it), (vec![], vec![]));
    }

    #[test]
    fn a_low_detection_of_any_class_takes_an_annotation_that_nothing_else_finds() {
        let mut low = detection(Van, 0.0, 0.9);
        low.object.left_top_right_bottom_px[3] = 110.0;
        let it = scan(&[annotation(Car, 0.0)], &[low], &[(0, 0, 0.8)]);
        assert_eq!(counted(&it), (vec![], vec![]));
        let it =
            scan(&[annotation(Car, 0.0)], &[low, detection(Car, 0.1, 0.5)], &[(0, 0, 0.8), (0, 1, 0.75)]);
        // The surest takes it when thresholds are sought; so there is none, and precision is 0.
        assert_eq!(counted(&it), (vec![], vec![(0.9, 0, 0), (0.5, 1, 0)]));
    }
}
