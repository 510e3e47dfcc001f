//! What was found, missed and false, and the ratios of these.

use crate::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome};

/// Bumped whenever the same detections would score differently.
pub const SCORING_VERSION: u32 = 1;

/// Counts of one task over any number of scans. Sums first, ratios last: a ratio of sums, never a mean of ratios.
///
/// Paper: HG section 5 (NO, MO, FO).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Annotations that count (NO).
    pub n_annotations: u64,
    /// Annotations that were found (TP).
    pub n_matched: u64,
    /// Detections that are false (FO), of those about which it can be known.
    pub n_false: u64,
    /// Detections of which it cannot be known whether they are false.
    pub n_unknowable: u64,
    /// Annotations that are neither found nor missed.
    pub n_ignored_annotations: u64,
    /// Detections that are neither right nor false.
    pub n_ignored_detections: u64,
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
                DetectionOutcome::Unknowable => counts.n_unknowable += 1,
            }
        }
        counts
    }

    /// Annotations that were missed (MO).
    pub fn n_missed(&self) -> u64 {
        self.n_annotations - self.n_matched
    }

    /// Share of the annotations that were found; `None` without annotations.
    pub fn recall(&self) -> Option<f64> {
        ratio(self.n_matched, self.n_annotations)
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

/// What additionally follows where every false detection is known to be one.
///
/// Undefined ratios, those with a zero denominator, are `None`: neither 0 nor 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompleteCounts(pub Counts);

impl CompleteCounts {
    /// TP / (TP + FO).
    pub fn precision(&self) -> Option<f64> {
        ratio(self.0.n_matched, self.0.n_matched + self.0.n_false)
    }

    /// 2 TP / (2 TP + MO + FO).
    pub fn f_rate(&self) -> Option<f64> {
        let counts = &self.0;
        ratio(2 * counts.n_matched, 2 * counts.n_matched + counts.n_missed() + counts.n_false)
    }
}

fn ratio(numerator: u64, denominator: u64) -> Option<f64> {
    (denominator > 0).then(|| numerator as f64 / denominator as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::outcome::{FalseReason, MissReason};
    use crate::task::Task;

    fn scan(n_matched: usize, n_missed: usize, n_false: usize) -> Counts {
        let matched = |idx| AnnotationOutcome::Matched { detection_idx: idx, cost: 0.2 };
        let missed = AnnotationOutcome::Missed(MissReason::NothingThere);
        let right = |idx| DetectionOutcome::Matched { annotation_idx: idx, cost: 0.2 };
        let wrong = DetectionOutcome::False(FalseReason::NothingThere);
        Counts::of(&Assignment {
            task: Task::Objects,
            annotations: (0..n_matched).map(matched).chain((0..n_missed).map(|_| missed)).collect(),
            detections: (0..n_matched).map(right).chain((0..n_false).map(|_| wrong)).collect(),
        })
    }

    #[test]
    fn ratios_are_of_sums_and_not_means_of_ratios() {
        let mut all = scan(3, 1, 1);
        all += scan(0, 4, 0);
        // TP 3, MO 5, FO 1: the mean of the two F-rates would be 0.375.
        assert_eq!((all.n_annotations, all.n_missed(), all.n_false), (8, 5, 1));
        assert_eq!(all.recall(), Some(0.375));
        assert_eq!(CompleteCounts(all).precision(), Some(0.75));
        assert_eq!(CompleteCounts(all).f_rate(), Some(0.5));
    }

    #[test]
    fn ratios_of_nothing_are_undefined() {
        let nothing = scan(0, 0, 0);
        assert_eq!(nothing.recall(), None);
        assert_eq!(CompleteCounts(nothing).precision(), None);
        assert_eq!(CompleteCounts(nothing).f_rate(), None);
        assert_eq!(CompleteCounts(scan(0, 2, 0)).precision(), None);
        assert_eq!(CompleteCounts(scan(0, 2, 0)).f_rate(), Some(0.0));
    }
}
