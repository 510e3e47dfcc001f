//! Counts of found and missed annotations and of false detections, and their ratios.

use reports::vocabulary::criterion::CriterionKind;
use reports::vocabulary::task::Task;
use scans::dataset::AnnotatedClasses;

use crate::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome};

/// Increased whenever the same detections would score differently.
pub const SCORING_VERSION: u32 = 2;

/// The same of a run that judges any task by boxes: since version 3 a detection that would match an ignored annotation is
/// ignored, whatever other points its box holds.
const SCORING_VERSION_OF_BOXES: u32 = 3;

/// The same of a run with detectors that are not built in, if it judges any task by points: since version 4 points of a box that
/// labels of overlapping boxes give to another object count neither for nor against it.
const SCORING_VERSION_OF_FOREIGN_BOXES: u32 = 4;

/// The version of the rules that judge by these `criteria`. `has_foreign`: also detectors that are not built in, whose
/// detections may be boxes without points.
pub fn scoring_version(criteria: impl IntoIterator<Item = CriterionKind>, has_foreign: bool) -> u32 {
    let criteria: Vec<CriterionKind> = criteria.into_iter().collect();
    if has_foreign && criteria.contains(&CriterionKind::Points) {
        SCORING_VERSION_OF_FOREIGN_BOXES
    } else if criteria.iter().any(|it| *it != CriterionKind::Points) {
        SCORING_VERSION_OF_BOXES
    } else {
        SCORING_VERSION
    }
}

/// Counts of one task over any number of scans. Sums first, ratios last: a ratio of sums, never a mean of ratios.
///
/// Paper: HG section 5 (NO, MO, FO).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Annotations that count (NO).
    pub n_annotations: u64,
    /// Annotations that were found (TP).
    pub n_matched: u64,
    /// Detections that are known to be false (FO).
    pub n_false: u64,
    /// Detections of which it cannot be known whether they are false.
    pub n_unknowable: u64,
    /// Annotations that are neither found nor missed.
    pub n_ignored_annotations: u64,
    /// Detections that are neither right nor false.
    pub n_ignored_detections: u64,
}

/// Whether every detection that matches nothing is known to be false.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FalseDetections {
    /// All objects that the task asks for are annotated.
    Known,
    /// There may be objects without annotations.
    Unknowable,
}

impl FalseDetections {
    /// Whether false detections are known for `task` where these classes are `annotated`.
    pub fn of(annotated: &AnnotatedClasses, task: Task) -> Self {
        if annotated.covers(task) { Self::Known } else { Self::Unknowable }
    }
}

impl Counts {
    /// Counts one scan.
    pub fn of(assignment: &Assignment) -> Self {
        let mut counts = Self::default();
        for outcome in &assignment.annotations {
            match outcome {
                AnnotationOutcome::NotAsked => {}
                AnnotationOutcome::Ignored(_) => counts.n_ignored_annotations += 1,
                AnnotationOutcome::Matched { .. } => {
                    counts.n_annotations += 1;
                    counts.n_matched += 1;
                }
                AnnotationOutcome::Missed(_) => counts.n_annotations += 1,
            }
        }
        for outcome in &assignment.detections {
            match outcome {
                DetectionOutcome::NotAsked | DetectionOutcome::Matched { .. } => {}
                DetectionOutcome::Ignored(_) => counts.n_ignored_detections += 1,
                DetectionOutcome::False(_) => counts.n_false += 1,
                DetectionOutcome::Unknowable(_) => counts.n_unknowable += 1,
            }
        }
        counts
    }

    /// The counts that rates are computed from; `false_detections` says whether all false ones are known.
    pub fn scored(&self, false_detections: FalseDetections) -> reports::rows::counts::Counts {
        let n_false = (false_detections == FalseDetections::Known).then_some(self.n_false);
        reports::rows::counts::Counts::new(self.n_annotations, self.n_matched, n_false)
            .expect("a matched annotation is counted as one")
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.n_annotations += other.n_annotations;
        self.n_matched += other.n_matched;
        self.n_false += other.n_false;
        self.n_unknowable += other.n_unknowable;
        self.n_ignored_annotations += other.n_ignored_annotations;
        self.n_ignored_detections += other.n_ignored_detections;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::vocabulary::criterion::CriterionKind;
    use reports::vocabulary::reason::{FalseReason, MissReason};

    fn scan(n_matched: usize, n_missed: usize, n_false: usize) -> Counts {
        let matched = |idx| AnnotationOutcome::Matched { detection_idx: idx, cost: 0.2 };
        let missed = AnnotationOutcome::Missed(MissReason::NothingThere);
        let right = |idx| DetectionOutcome::Matched { annotation_idx: idx, cost: 0.2 };
        let wrong = DetectionOutcome::False(FalseReason::NothingThere);
        Counts::of(&Assignment {
            task: Task::Objects,
            criterion: CriterionKind::Points,
            annotations: (0..n_matched).map(matched).chain((0..n_missed).map(|_| missed)).collect(),
            detections: (0..n_matched).map(right).chain((0..n_false).map(|_| wrong)).collect(),
            found_tall: Vec::new(),
        })
    }

    #[test]
    fn rates_are_of_sums_and_not_means_of_rates() {
        let mut all = scan(3, 1, 1);
        all += scan(0, 4, 0);
        // TP 3, MO 5, FO 1: the mean of the two F-rates would be 0.375.
        let scored = all.scored(FalseDetections::Known);
        assert_eq!((scored.no(), scored.mo(), scored.fo()), (8, 5, Some(1)));
        assert_eq!(
            (scored.recall(), scored.precision(), scored.f_rate()),
            (Some(0.375), Some(0.75), Some(0.5))
        );
    }

    #[test]
    fn unknowable_false_detections_are_not_zero() {
        let scored = scan(3, 1, 0).scored(FalseDetections::Unknowable);
        assert_eq!((scored.fo(), scored.f_rate(), scored.recall()), (None, None, Some(0.75)));
    }
}
