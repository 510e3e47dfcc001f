//! Precision at 41 recalls as the development kit has it.
//!
//! Its thresholds are scores of detections that are right when all are kept: from the surest down, each is taken that comes
//! nearest to the next of the recalls 0, 1/40, …, 1. So with fewer than 41 annotations there are fewer thresholds, and
//! precision is 0 at the other recalls: annotations fed back do not reach the maximum.

use super::recall_curve::{N_RECALLS, RecallCurve, best_from_here};
use super::score_events::{Counted, ScoredMatches};
use crate::protocols::drawn_scans::Times;

/// The curve of each draw.
pub fn official_curves<const N: usize>(matches: &ScoredMatches, times: &[Times<N>]) -> [RecallCurve; N] {
    let (n_annotations, n_hits) = (matches.n_annotations(times), matches.n_hits(times));
    let mut lookups: [Lookup; N] = std::array::from_fn(|draw| Lookup::new(n_annotations[draw], n_hits[draw]));
    let mut n_needed = lookups.each_ref().map(Lookup::n_needed);
    matches.go_through(times, |counted| {
        let pairs = counted.n_hits.iter().zip(&n_needed);
        if pairs.map(|(n_hits, needed)| u32::from(n_hits >= needed)).sum::<u32>() > 0 {
            for (draw, lookup) in lookups.iter_mut().enumerate() {
                lookup.take(counted, draw);
                n_needed[draw] = lookup.n_needed();
            }
        }
    });
    lookups.map(|it| RecallCurve {
        precision: best_from_here(&it.precision),
        similarity: best_from_here(&it.similarity),
    })
}

/// Values looked up in one draw so far.
struct Lookup {
    n_annotations: f64,
    n_hits: f64,
    // Number of hits before the next threshold, and the recall that it is to be near.
    next: f64,
    next_recall: f64,
    n_taken: usize,
    precision: [f64; N_RECALLS],
    similarity: [f64; N_RECALLS],
}

impl Lookup {
    fn new(n_annotations: f64, n_hits: f64) -> Self {
        let mut lookup = Self {
            n_annotations,
            n_hits,
            next: 0.0,
            next_recall: 0.0,
            n_taken: 0,
            precision: [0.0; N_RECALLS],
            similarity: [0.0; N_RECALLS],
        };
        lookup.skip();
        lookup
    }

    /// Number of hits to be kept for the next threshold; infinity if there is none.
    fn n_needed(&self) -> f64 {
        if self.next < self.n_hits && self.n_taken < N_RECALLS { self.next + 1.0 } else { f64::INFINITY }
    }

    /// Takes the values at all thresholds that are reached.
    fn take<const N: usize>(&mut self, counted: &Counted<N>, draw: usize) {
        while counted.n_hits[draw] >= self.n_needed() {
            let n_detections = counted.tp[draw] + counted.fp[draw];
            self.precision[self.n_taken] = counted.tp[draw] / n_detections;
            self.similarity[self.n_taken] = counted.similarity[draw] / n_detections;
            self.n_taken += 1;
            // Summed up, as the makers do: a product rounds otherwise.
            self.next_recall += 1.0 / (N_RECALLS as f64 - 1.0);
            self.next += 1.0;
            self.skip();
        }
    }

    /// Skips the hits that are farther from the next recall than those that follow. The last is never skipped.
    fn skip(&mut self) {
        let is_skipped = |n_before: f64| {
            let [recall, recall_of_next] = [1.0, 2.0].map(|it| (n_before + it) / self.n_annotations);
            recall_of_next - self.next_recall < self.next_recall - recall
        };
        // Smaller by more than rounding adds: all hits before it are skipped.
        let surely = (self.next_recall * self.n_annotations - 2.5).floor();
        let mut next = self.next.max(surely.min(self.n_hits - 1.0));
        while next + 1.0 < self.n_hits && is_skipped(next) {
            next += 1.0;
        }
        self.next = next;
    }
}

#[cfg(test)]
mod tests {
    use super::super::averages::Recalls;
    use super::super::score_events::{ScoreEvent, ScoreEvents};
    use super::*;
    use crate::protocols::drawn_scans::single_draw;

    /// Matches of detections of these scores, right or false, one a scan, and of `n` annotations.
    fn matches(scored: &[(f64, bool)], n: u32) -> ScoredMatches {
        let mut matches = ScoreEvents { annotations: vec![(0, n)], ..ScoreEvents::default() };
        for (&(score, is_right), scan) in scored.iter().zip(0..) {
            if is_right {
                matches.events.push(ScoreEvent { score, scan, tp: 1, fp: 0, n_hits: 1, similarity: 1.0 });
            } else {
                matches.falses.push((score, scan));
            }
        }
        matches.sorted()
    }

    fn curve(matches: &ScoredMatches, times: &[u16]) -> RecallCurve {
        let [curve] = official_curves(matches, &single_draw(times));
        curve
    }

    #[test]
    fn one_of_one_is_one_recall_of_41() {
        let it = curve(&matches(&[(0.9, true)], 1), &[1]);
        assert_eq!(it.precision[..2], [1.0, 0.0]);
        assert_eq!(it.average_precision(Recalls::R11), Some(1.0 / 11.0));
        assert_eq!(it.average_precision(Recalls::R40), Some(0.0));
    }

    #[test]
    fn forty_one_of_forty_one_is_all() {
        for (n, r40) in [(40, 39.0 / 40.0), (41, 1.0), (100, 1.0)] {
            let all: Vec<(f64, bool)> = (0..n).map(|it| (f64::from(it), true)).collect();
            let it = curve(&matches(&all, n), &vec![1; all.len()]);
            assert_eq!(it.average_precision(Recalls::R40), Some(r40), "{n}");
        }
    }

    #[test]
    fn a_hundred_of_two_hundred_is_half() {
        // Every other detection is false, so precision is a half from the second on.
        let half: Vec<(f64, bool)> = (0..200).map(|it| (f64::from(-it), it % 2 == 0)).collect();
        let it = curve(&matches(&half, 200), &[1; 200]);
        // Recall 0 is the first detection; recall 0.5 is the last that is right, of 199.
        assert_eq!(it.precision[0], 1.0);
        assert_eq!(it.precision[20], 100.0 / 199.0);
        assert_eq!(it.precision[21], 0.0);
    }

    #[test]
    fn scans_drawn_twice_count_twice() {
        let once: Vec<(f64, bool)> = (0..60).map(|it| (f64::from(-it), it % 3 != 0)).collect();
        let twice: Vec<(f64, bool)> = once.iter().flat_map(|it| [*it, *it]).collect();
        let of_drawn = curve(&matches(&once, 50), &[2; 60]);
        assert_eq!(of_drawn, curve(&matches(&twice, 100), &[1; 120]));
    }
}
