//! Precision over recall, where detections are ranked by score.

use crate::vocabulary::metric::RecallPositions;

/// A detection that counts: matched or false, and how sure the detector is of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RankedDetection {
    /// Higher is surer.
    pub score: f32,
    /// Whether it found an annotation; it is false otherwise.
    pub is_match: bool,
}

/// Counts of the detections at or above a score.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingPoint {
    /// The least score that is kept.
    pub min_score: f32,
    /// Matched detections of at least that score.
    pub tp: u64,
    /// False detections of at least that score.
    pub fo: u64,
}

impl OperatingPoint {
    /// TP / (TP + FO).
    pub fn precision(&self) -> f64 {
        self.tp as f64 / (self.tp + self.fo) as f64
    }
}

/// A point for every score that occurs, from the highest; detections of equal score stay together.
pub fn operating_points(detections: &[RankedDetection]) -> Vec<OperatingPoint> {
    let mut best_first = detections.to_vec();
    best_first.sort_by(|a, b| b.score.total_cmp(&a.score));
    let (mut tp, mut fo) = (0, 0);
    let alike = best_first.chunk_by(|a, b| a.score == b.score);
    alike
        .map(|alike| {
            let n_matches = alike.iter().filter(|it| it.is_match).count() as u64;
            tp += n_matches;
            fo += alike.len() as u64 - n_matches;
            OperatingPoint { min_score: alike[0].score, tp, fo }
        })
        .collect()
}

/// Mean, over recalls, of the best precision that is reached at that recall or beyond; 0 where none is.
///
/// `no` is the number of annotations; `None` if there are none. Detections are matched once, with all detections there;
/// so recall ends where the detector itself ends.
///
/// Everingham et al. 2010 (interpolation), Lin et al. 2014 (101 points), Simonelli et al. 2019 (R40).
pub fn average_precision(detections: &[RankedDetection], no: u64, positions: RecallPositions) -> Option<f64> {
    if no == 0 {
        return None;
    }
    let points = operating_points(detections);
    let (first, last) = match positions {
        RecallPositions::Points101 => (0, 100),
        RecallPositions::R40 => (1, 40),
    };
    let best_from = |step: u64| {
        // In whole numbers: a recall of 0.3 is not to fall short of 30 %.
        let reached = points.iter().filter(|it| it.tp * last >= step * no);
        reached.map(OperatingPoint::precision).fold(0.0, f64::max)
    };
    let n_positions = (last - first + 1) as f64;
    Some((first..=last).map(best_from).sum::<f64>() / n_positions)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranked(scored: &[(f32, bool)]) -> Vec<RankedDetection> {
        scored.iter().map(|&(score, is_match)| RankedDetection { score, is_match }).collect()
    }

    #[track_caller]
    fn check(scored: &[(f32, bool)], no: u64, expected_101: f64, expected_r40: f64) {
        for (positions, expected) in
            [(RecallPositions::Points101, expected_101), (RecallPositions::R40, expected_r40)]
        {
            let found = average_precision(&ranked(scored), no, positions).unwrap();
            assert!((found - expected).abs() < 1e-12, "{positions:?}: {found} instead of {expected}");
        }
    }

    #[test]
    fn all_found_and_nothing_false_is_one() {
        check(&[(0.9, true), (0.8, true)], 2, 1.0, 1.0);
    }

    #[test]
    fn half_of_the_annotations_is_half_of_the_recalls() {
        // 0 to 50 % are 51 of 101 recalls; 1/40 to 20/40 are 20 of 40.
        check(&[(0.9, true)], 2, 51.0 / 101.0, 0.5);
    }

    #[test]
    fn a_false_one_in_between_costs_what_comes_after_it() {
        // Precision 1 up to a recall of a half, then 2/3.
        check(
            &[(0.9, true), (0.8, false), (0.7, true)],
            2,
            (51.0 + 50.0 * 2.0 / 3.0) / 101.0,
            (20.0 + 20.0 * 2.0 / 3.0) / 40.0,
        );
    }

    #[test]
    fn precision_that_recovers_counts_from_the_start() {
        // The first is false, then four of five: the best precision at any recall is 4/5.
        check(&[(0.9, false), (0.8, true), (0.7, true), (0.6, true), (0.5, true)], 4, 0.8, 0.8);
    }

    #[test]
    fn equal_scores_stay_together_in_any_order() {
        check(&[(0.5, true), (0.5, false)], 1, 0.5, 0.5);
        check(&[(0.5, false), (0.5, true)], 1, 0.5, 0.5);
    }

    #[test]
    fn nothing_found_is_zero_and_nothing_to_find_is_undefined() {
        check(&[], 3, 0.0, 0.0);
        assert_eq!(average_precision(&ranked(&[(0.5, false)]), 0, RecallPositions::R40), None);
    }
}
