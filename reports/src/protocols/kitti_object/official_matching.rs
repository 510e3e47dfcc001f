//! Matching as the development kit does it: annotation by annotation, in the order of the files, anew for each least score.
//!
//! Twice over: first with all detections, where an annotation takes the surest that overlaps it enough; the scores of what is found so
//! become the least scores that precision is looked up at. Then for each of these, where an annotation takes the one that overlaps it most.

use super::roles::{Role, Roles};
use super::rules::{Plane, Question};
use super::scan::{KittiPair, KittiScan};
use super::score_events::{Counted, Hit, ScoreEvent, ScoredMatches};

/// Matches all `scans`; of each, its place is told in events.
pub fn official_matches<'a>(
    scans: impl IntoIterator<Item = (u32, &'a KittiScan)>,
    question: &Question,
) -> ScoredMatches {
    let mut matches = ScoredMatches::default();
    for (place, scan) in scans {
        let mut matching = OfficialMatching::new(scan, *question);
        let n_annotations = matching.roles.n_annotations();
        if n_annotations > 0 {
            matches.annotations.push((place, n_annotations));
        }
        matches.hits.extend(matching.surest_first().map(|score| Hit { score, scan: place }));
        matching.add_events(place, &mut matches.events);
    }
    matches.sort();
    matches
}

/// A scan that is being matched.
struct OfficialMatching<'a> {
    scan: &'a KittiScan,
    roles: Roles,
    // Overlapping enough, of those that are not absent, in the order of annotations, then detections.
    pairs: Vec<(&'a KittiPair, f64)>,
    // Of each detection, whether it is false where it finds nothing.
    can_be_false: Vec<bool>,
    is_taken: Vec<bool>,
}

impl<'a> OfficialMatching<'a> {
    fn new(scan: &'a KittiScan, question: Question) -> Self {
        let roles = Roles::of(scan, &question);
        let min_overlap = question.min_overlap();
        let pairs = scan.pairs().iter().map(|it| (it, it.overlap_in(&question)));
        let pairs = pairs.filter(|(it, overlap)| {
            *overlap > min_overlap
                && roles.annotations[it.annotation] != Role::Absent
                && roles.detections[it.detection] != Role::Absent
        });
        // Regions without labels have no place in the world, so that they excuse in the image only.
        let is_excused =
            |place: usize| question.plane == Plane::Image && scan.dont_care_share(place) > min_overlap;
        let can_be_false = roles.detections.iter().zip(0..);
        Self {
            scan,
            pairs: pairs.collect(),
            can_be_false: can_be_false
                .map(|(role, place)| *role == Role::Counts && !is_excused(place))
                .collect(),
            is_taken: vec![false; roles.detections.len()],
            roles,
        }
    }

    fn score(&self, pair: &KittiPair) -> f64 {
        self.scan.detections()[pair.detection].score
    }

    /// The scores of what is found when every annotation takes the surest detection that is free; the first of those alike.
    fn surest_first(&mut self) -> impl Iterator<Item = f64> + use<> {
        self.is_taken.fill(false);
        let mut scores = Vec::new();
        for of_annotation in self.pairs.chunk_by(|a, b| a.0.annotation == b.0.annotation) {
            let mut surest: Option<&KittiPair> = None;
            for (pair, _) in of_annotation.iter().filter(|(it, _)| !self.is_taken[it.detection]) {
                if surest.is_none_or(|it| self.score(pair) > self.score(it)) {
                    surest = Some(pair);
                }
            }
            let Some(pair) = surest else { continue };
            self.is_taken[pair.detection] = true;
            if self.is_found_by(pair) {
                scores.push(self.score(pair));
            }
        }
        scores.into_iter()
    }

    fn is_found_by(&self, pair: &KittiPair) -> bool {
        self.roles.annotations[pair.annotation] == Role::Counts
            && self.roles.detections[pair.detection] == Role::Counts
    }

    /// Adds what changes at every score that a detection of the scan has.
    fn add_events(&mut self, place: u32, events: &mut Vec<ScoreEvent>) {
        let mut scores: Vec<f64> = self.pairs.iter().map(|(it, _)| self.score(it)).collect();
        scores.sort_by(|a, b| b.total_cmp(a));
        scores.dedup();
        let mut before = Counted::default();
        for min_score in scores {
            let counted = self.found_and_excused(min_score);
            events.push(ScoreEvent {
                score: min_score,
                scan: place,
                tp: (counted.tp - before.tp) as i32,
                fp: (counted.fp - before.fp) as i32,
                similarity: counted.similarity - before.similarity,
            });
            before = counted;
        }
        let false_alone = self.scan.detections().iter().zip(&self.can_be_false).filter(|(_, can)| **can);
        let event = |(it, _): (&super::scan::KittiDetection, _)| ScoreEvent {
            score: it.score,
            scan: place,
            tp: 0,
            fp: 1,
            similarity: 0.0,
        };
        events.extend(false_alone.map(event));
    }

    /// What is right among detections of at least `min_score`. Those that are false are counted as if nothing were found, elsewhere; so
    /// what is taken of them counts as less than none here.
    fn found_and_excused(&mut self, min_score: f64) -> Counted {
        self.is_taken.fill(false);
        let mut counted = Counted::default();
        for of_annotation in self.pairs.chunk_by(|a, b| a.0.annotation == b.0.annotation) {
            let Some(pair) = self.most_overlapping(of_annotation, min_score) else { continue };
            self.is_taken[pair.detection] = true;
            counted.fp -= i64::from(self.can_be_false[pair.detection]);
            if self.is_found_by(pair) {
                counted.tp += 1;
                let turn_rad = self.scan.annotations()[pair.annotation].object.alpha_rad
                    - self.scan.detections()[pair.detection].object.alpha_rad;
                counted.similarity += f64::midpoint(1.0, turn_rad.cos());
            }
        }
        counted
    }

    /// The detection that counts and overlaps most, the first of those alike; without one, the first that is ignored.
    fn most_overlapping(
        &self,
        of_annotation: &[(&'a KittiPair, f64)],
        min_score: f64,
    ) -> Option<&'a KittiPair> {
        let is_free = |it: &KittiPair| !self.is_taken[it.detection] && self.score(it) >= min_score;
        let (mut most, mut ignored): (Option<(&KittiPair, f64)>, Option<&KittiPair>) = (None, None);
        for (pair, overlap) in of_annotation.iter().filter(|(it, _)| is_free(it)) {
            if self.roles.detections[pair.detection] == Role::Ignored {
                ignored = ignored.or(Some(pair));
            } else if most.is_none_or(|(_, it)| *overlap > it) {
                most = Some((pair, *overlap));
            }
        }
        most.map(|(pair, _)| pair).or(ignored)
    }
}

#[cfg(test)]
mod tests {
    use super::super::drawn_scan::{annotation, detection, scan};
    use super::super::rules::{Demand, Difficulty, KittiClass};
    use super::*;
    use crate::vocabulary::class::AnnotationClass::{Car, Van};

    const QUESTION: Question = Question {
        class: KittiClass::Car,
        difficulty: Difficulty::Moderate,
        plane: Plane::Volume,
        demand: Demand::Strict,
    };

    /// The scores that thresholds are taken from, and what is right and false from each score on.
    fn counted(scan: &KittiScan) -> (Vec<f64>, Vec<(f64, i32, i32)>) {
        let matches = official_matches([(0, scan)], &QUESTION);
        let (mut tp, mut fp) = (0, 0);
        let mut counted: Vec<(f64, i32, i32)> = Vec::new();
        for event in &matches.events {
            (tp, fp) = (tp + event.tp, fp + event.fp);
            counted.retain(|it| it.0 != event.score);
            counted.push((event.score, tp, fp));
        }
        (matches.hits.iter().map(|it| it.score).collect(), counted)
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
        assert_eq!(counted(&it), (vec![], vec![(0.9, 0, 0)]));
    }

    #[test]
    fn a_low_detection_of_any_class_takes_an_annotation_that_nothing_else_finds() {
        let mut low = detection(Van, 0.0, 0.9);
        low.object.left_top_right_bottom_px[3] = 110.0;
        let it = scan(&[annotation(Car, 0.0)], &[low], &[(0, 0, 0.8)]);
        assert_eq!(counted(&it), (vec![], vec![(0.9, 0, 0)]));
        let it =
            scan(&[annotation(Car, 0.0)], &[low, detection(Car, 0.1, 0.5)], &[(0, 0, 0.8), (0, 1, 0.75)]);
        // The surest takes it when thresholds are sought; so there is none, and precision is 0.
        assert_eq!(counted(&it), (vec![], vec![(0.9, 0, 0), (0.5, 1, 0)]));
    }
}
