//! Average precision over the whole ranking: every score is looked at, and detections of like scores stay or go together.
//!
//! Everingham et al. 2010 (interpolation), Simonelli et al. 2019 (R40).

use super::averages::Recalls;
use super::score_events::{Counted, ScoredMatches};

/// What remains when detections below some score are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct SoundCurve {
    n_annotations: u64,
    points: Vec<Counted>,
}

impl SoundCurve {
    /// Of scans of which each is there so many `times`.
    pub fn of(matches: &ScoredMatches, times: &[u16]) -> Self {
        let mut counted = Counted::default();
        let mut points = Vec::new();
        for alike in matches.events.chunk_by(|a, b| a.score == b.score) {
            for event in alike {
                counted.add(event, times[event.scan as usize]);
            }
            points.push(counted);
        }
        Self { n_annotations: matches.n_annotations(times), points }
    }

    /// Mean, over recalls, of the largest `value` that is reached at that recall or beyond; 0 where none is. `None` without any annotation.
    fn mean(&self, recalls: Recalls, value: impl Fn(&Counted) -> f64) -> Option<f64> {
        if self.n_annotations == 0 {
            return None;
        }
        let (steps, n_steps) = recalls.steps();
        let mut from_the_end = self.points.iter().rev().filter(|it| it.tp + it.fp > 0).peekable();
        let (mut largest, mut sum) = (0.0_f64, 0.0);
        for step in steps.clone().rev() {
            // In whole numbers: a recall of 0.3 is not to fall short of 30 %.
            let is_reached = |it: &Counted| it.tp as u64 * n_steps >= step * self.n_annotations;
            while let Some(point) = from_the_end.next_if(|it| is_reached(it)) {
                largest = largest.max(value(point));
            }
            sum += largest;
        }
        Some(sum / steps.count() as f64)
    }

    /// Average precision, 0 to 1.
    pub fn average_precision(&self, recalls: Recalls) -> Option<f64> {
        self.mean(recalls, |it| it.tp as f64 / (it.tp + it.fp) as f64)
    }

    /// Average similarity of headings, 0 to 1.
    pub fn average_similarity(&self, recalls: Recalls) -> Option<f64> {
        self.mean(recalls, |it| it.similarity / (it.tp + it.fp) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::super::score_events::ScoreEvent;
    use super::*;

    #[track_caller]
    fn check(scored: &[(f64, bool)], n: u32, expected_r11: f64, expected_r40: f64) {
        let mut matches = ScoredMatches { annotations: vec![(0, n)], ..ScoredMatches::default() };
        for &(score, is_right) in scored {
            let (tp, fp) = (i32::from(is_right), i32::from(!is_right));
            matches.events.push(ScoreEvent { score, scan: 0, tp, fp, similarity: 0.5 * f64::from(tp) });
        }
        matches.sort();
        let curve = SoundCurve::of(&matches, &[1]);
        for (recalls, expected) in [(Recalls::R11, expected_r11), (Recalls::R40, expected_r40)] {
            let found = curve.average_precision(recalls).unwrap();
            assert!((found - expected).abs() < 1e-12, "{recalls:?}: {found} instead of {expected}");
            assert!((curve.average_similarity(recalls).unwrap() - expected / 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn averages_that_can_be_done_in_the_head() {
        check(&[(0.9, true)], 1, 1.0, 1.0);
        check(&[(0.9, true)], 2, 6.0 / 11.0, 0.5);
        check(
            &[(0.9, true), (0.8, false), (0.7, true)],
            2,
            (6.0 + 5.0 * 2.0 / 3.0) / 11.0,
            (20.0 + 20.0 * 2.0 / 3.0) / 40.0,
        );
        check(&[(0.5, true), (0.5, false)], 1, 0.5, 0.5);
        check(&[(0.5, false)], 1, 0.0, 0.0);
    }

    #[test]
    fn nothing_to_find_is_undefined() {
        assert_eq!(SoundCurve::of(&ScoredMatches::default(), &[]).average_precision(Recalls::R40), None);
    }
}
