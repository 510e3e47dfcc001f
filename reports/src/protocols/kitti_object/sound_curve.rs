//! Average precision over the whole ranking: every score is looked at, and detections of like scores stay or go together.
//!
//! Everingham et al. 2010 (interpolation), Simonelli et al. 2019 (R40).

use super::recall_curve::{N_RECALLS, RecallCurve, best_from_here};
use super::score_events::{Counted, ScoredMatches};
use crate::protocols::drawn_scans::Times;

const N_STEPS: u64 = N_RECALLS as u64 - 1;

/// Curve of each draw: the largest value that is reached at each recall or beyond, 0 where none is; `None` without
/// annotations.
pub fn sound_curves<const N: usize>(matches: &ScoredMatches, times: &[Times<N>]) -> [Option<RecallCurve>; N] {
    let n_annotations = matches.n_annotations(times);
    let mut best = BestValues::new(&n_annotations);
    matches.go_through(times, |counted| best.take(counted));
    (0..N).for_each(|draw| best.end(draw));
    std::array::from_fn(|draw| {
        (n_annotations[draw] > 0.0).then(|| RecallCurve {
            precision: best_from_here(&best.precision[draw]),
            similarity: best_from_here(&best.similarity[draw]),
        })
    })
}

/// Best values between one recall and the next, while going through the scores.
struct BestValues<const N: usize> {
    n_annotations: [f64; N],
    // Number to be found for the recall after the last that was reached.
    n_needed: [f64; N],
    reached: [usize; N],
    precision: [[f64; N_RECALLS]; N],
    similarity: [[f64; N_RECALLS]; N],
    // Best values since the last recall was reached.
    precision_since: [f64; N],
    similarity_since: [f64; N],
}

impl<const N: usize> BestValues<N> {
    fn new(n_annotations: &[f64; N]) -> Self {
        Self {
            n_annotations: *n_annotations,
            n_needed: n_annotations.map(|it| n_to_reach(1, it)),
            reached: [0; N],
            precision: [[0.0; N_RECALLS]; N],
            similarity: [[0.0; N_RECALLS]; N],
            precision_since: [0.0; N],
            similarity_since: [0.0; N],
        }
    }

    #[inline(always)]
    fn take(&mut self, counted: &Counted<N>) {
        if counted.tp.iter().zip(&self.n_needed).map(|(tp, needed)| u32::from(tp >= needed)).sum::<u32>() > 0
        {
            self.reach(&counted.tp);
        }
        for draw in 0..N {
            let n_detections = counted.tp[draw] + counted.fp[draw];
            // Without detections they are NaN, which is not above the best.
            let values = [counted.tp[draw] / n_detections, counted.similarity[draw] / n_detections];
            let since = [&mut self.precision_since[draw], &mut self.similarity_since[draw]];
            for (value, since) in values.into_iter().zip(since) {
                *since = if value > *since { value } else { *since };
            }
        }
    }

    /// Goes on to the last recall that `n_found` reaches.
    fn reach(&mut self, n_found: &[f64; N]) {
        let n_needed = self.n_needed;
        for draw in (0..N).filter(|it| n_found[*it] >= n_needed[*it]) {
            self.end(draw);
            while n_found[draw] >= self.n_needed[draw] {
                self.reached[draw] += 1;
                self.n_needed[draw] = n_to_reach(self.reached[draw] + 1, self.n_annotations[draw]);
            }
        }
    }

    /// Notes the best values since the last recall was reached.
    fn end(&mut self, draw: usize) {
        let reached = self.reached[draw];
        self.precision[draw][reached] = std::mem::take(&mut self.precision_since[draw]);
        self.similarity[draw][reached] = std::mem::take(&mut self.similarity_since[draw]);
    }
}

/// Number of `n_annotations` to be found for a recall of `step` steps; infinity beyond the last. In whole numbers, so that a
/// recall of 0.3 does not fall short of 30 %.
fn n_to_reach(step: usize, n_annotations: f64) -> f64 {
    if step < N_RECALLS {
        (step as u64 * n_annotations as u64).div_ceil(N_STEPS) as f64
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::super::averages::Recalls;
    use super::super::score_events::{ScoreEvent, ScoreEvents};
    use super::*;
    use crate::protocols::drawn_scans::single_draw;

    #[track_caller]
    fn check(scored: &[(f64, bool)], n: u32, expected_r11: f64, expected_r40: f64) {
        let mut matches = ScoreEvents { annotations: vec![(0, n)], ..ScoreEvents::default() };
        for &(score, is_right) in scored {
            if is_right {
                let event = ScoreEvent { score, scan: 0, tp: 1, fp: 0, n_hits: 0, similarity: 0.5 };
                matches.events.push(event);
            } else {
                matches.falses.push((score, 0));
            }
        }
        let [curve] = sound_curves(&matches.sorted(), &single_draw(&[1]));
        let curve = curve.unwrap();
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
        assert_eq!(sound_curves::<1>(&ScoreEvents::default().sorted(), &[]), [None]);
    }
}
