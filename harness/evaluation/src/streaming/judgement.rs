//! How an answer fares at a moment.

use detector::{DetectedClass, Detection, Detections};
use reports::rows::counts::Counts;
use reports::rows::match_outcome::{BoxFacts, DetectionFacts, FoundBy, MatchOutcome};
use reports::vocabulary::class::DetectionClass;
use reports::vocabulary::reason::{FalseReason, IgnoredAnnotation, IgnoredDetection, MissReason};
use scans::conversion::results::detection_rows::oriented_box;

use super::logged_drive::{LoggedDetection, Unmatched};
use super::truth::TrueMoment;
use crate::matching::criterion::Criterion;
use crate::matching::detection_order::detection_ranks;
use crate::matching::outcome::AnnotationOutcome;
use crate::matching::pairing::Pairing;
use crate::matching::point_overlap::PointOverlap;

/// An answer that is judged at a moment, as in [`assign`](crate::matching::assign::assign), but by boxes alone.
pub struct JudgedMoment<'a> {
    moment: &'a TrueMoment,
    known: &'a [LoggedDetection],
    boxes: Vec<BoxFacts>,
    pairing: Pairing,
    // Of every detection that found nothing at all.
    unmatched: Vec<Option<Unmatched>>,
}

impl<'a> JudgedMoment<'a> {
    /// Judges what is `known` at `moment`, which is taken to be at `boxes` now.
    ///
    /// A detection that finds nothing is what it was in its own scan: ignored, unknowable or false. One that found an object
    /// there is ignored if that object is not labelled any more, or is not followed: nobody knows where it is.
    pub fn new(
        moment: &'a TrueMoment,
        known: &'a [LoggedDetection],
        boxes: Vec<BoxFacts>,
        criterion: Criterion,
    ) -> Self {
        let detection = |(it, bounding_box): (&LoggedDetection, &BoxFacts)| {
            let class = match it.facts.class {
                DetectionClass::Vehicle => DetectedClass::Vehicle,
                DetectionClass::Object | DetectionClass::Given(_) => DetectedClass::Object,
            };
            Detection::new(&[], oriented_box(bounding_box), class, it.facts.score)
        };
        let detections: Detections = known.iter().zip(&boxes).map(detection).collect();
        let overlap = PointOverlap::count(&moment.scan, &detections);
        let admissible = criterion.admissible_pairs(&moment.scan, &detections, &overlap);
        let is_asked = vec![true; known.len()];
        let pairing =
            Pairing::choose(&admissible, &detection_ranks(&detections), &is_asked, &moment.exclusions);
        let mut unmatched: Vec<Option<Unmatched>> = known.iter().map(|it| Some(why(it, moment))).collect();
        for pair in [&pairing.matched, &pairing.found_tall, &pairing.found_ignored].into_iter().flatten() {
            unmatched[pair.detection_idx] = None;
        }
        Self { moment, known, boxes, pairing, unmatched }
    }

    /// The counts; `are_false_known` is whether detections beyond the labels are known to be false.
    pub fn counts(&self, are_false_known: bool) -> Counts {
        let n_counting = self.moment.exclusions.iter().filter(|it| it.is_none()).count() as u64;
        let n_false = self.unmatched.iter().filter(|it| **it == Some(Unmatched::False)).count() as u64;
        let n_matched = self.pairing.matched.len() as u64;
        Counts::new(n_counting, n_matched, are_false_known.then_some(n_false))
            .expect("only annotations that count are matched")
    }

    /// The outcome of everything, each with the speed of the annotation that it is about, if that is known.
    pub fn outcomes(&self) -> Vec<(MatchOutcome, Option<f64>)> {
        let detection =
            |idx: usize| DetectionFacts { bounding_box: self.boxes[idx], ..self.known[idx].facts.clone() };
        let mut outcomes = Vec::with_capacity(self.known.len() + self.moment.facts.len());
        for (annotation_idx, excluded) in self.moment.exclusions.iter().enumerate() {
            let annotation = self.moment.facts[annotation_idx].clone();
            let found = |pairs: &[_]| {
                pairs
                    .iter()
                    .find(|it: &&crate::matching::hungarian::AdmissiblePair| {
                        it.annotation_idx == annotation_idx
                    })
                    .copied()
            };
            let outcome = match excluded {
                Some(AnnotationOutcome::Ignored(IgnoredAnnotation::Tall)) => {
                    let found = found(&self.pairing.found_tall);
                    let found_by =
                        found.map(|it| FoundBy { detection: detection(it.detection_idx), cost: it.cost });
                    MatchOutcome::Tall { annotation, found_by }
                }
                Some(AnnotationOutcome::Ignored(reason)) => {
                    MatchOutcome::IgnoredAnnotation { annotation, reason: *reason }
                }
                _ => match found(&self.pairing.matched) {
                    Some(it) => MatchOutcome::Matched {
                        annotation,
                        detection: detection(it.detection_idx),
                        cost: it.cost,
                    },
                    None => MatchOutcome::Missed { annotation, reason: MissReason::NothingThere },
                },
            };
            outcomes.push((outcome, self.moment.speeds_m_per_s[annotation_idx]));
        }
        let ignored = self.pairing.found_ignored.iter().map(|it| MatchOutcome::IgnoredDetection {
            detection: detection(it.detection_idx),
            reason: IgnoredDetection::OnIgnoredAnnotation,
        });
        let alone = self.unmatched.iter().enumerate().filter_map(|(idx, unmatched)| {
            let detection = detection(idx);
            Some(match (*unmatched)? {
                Unmatched::False => MatchOutcome::False { detection, reason: FalseReason::NothingThere },
                Unmatched::Ignored(reason) => MatchOutcome::IgnoredDetection { detection, reason },
                Unmatched::Unknowable => MatchOutcome::Unknowable { detection, agreement: None },
            })
        });
        outcomes.extend(ignored.chain(alone).map(|it| (it, None)));
        outcomes
    }
}

/// What a detection is that finds nothing at `moment`.
fn why(detection: &LoggedDetection, moment: &TrueMoment) -> Unmatched {
    let is_gone = detection.found.is_some_and(|track| !moment.follows(track));
    if is_gone { Unmatched::Ignored(IgnoredDetection::OnIgnoredAnnotation) } else { detection.unmatched }
}
