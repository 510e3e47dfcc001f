//! Precision at 41 recalls as the development kit has it.
//!
//! The least scores that it is looked up at are those of detections that are right when all are kept: from the surest down, each is taken
//! that comes nearest to the next of the recalls 0, 1/40, …, 1. So with fewer than 41 annotations there are fewer, and precision is 0 at
//! the rest: annotations fed back do not reach the maximum.

use super::score_events::{Counted, ScoredMatches};

/// Number of recalls.
pub const N_RECALLS: usize = 41;

/// What is looked up.
#[derive(Debug, Clone, PartialEq)]
pub struct OfficialCurve {
    /// The best precision at each recall or beyond; NaN where the makers divide zero by zero.
    pub precision: [f64; N_RECALLS],
    /// The same of the similarity of headings.
    pub similarity: [f64; N_RECALLS],
}

impl OfficialCurve {
    /// Of scans of which each is there so many `times`.
    pub fn of(matches: &ScoredMatches, times: &[u16]) -> Self {
        let (mut precision, mut similarity) = ([0.0; N_RECALLS], [0.0; N_RECALLS]);
        let mut events = matches.events.iter().peekable();
        let mut counted = Counted::default();
        for (place, min_score) in thresholds(matches, times).into_iter().enumerate() {
            while let Some(event) = events.next_if(|it| it.score >= min_score) {
                counted.add(event, times[event.scan as usize]);
            }
            let n_detections = (counted.tp + counted.fp) as f64;
            precision[place] = counted.tp as f64 / n_detections;
            similarity[place] = counted.similarity / n_detections;
        }
        Self { precision: best_from_here(&precision), similarity: best_from_here(&similarity) }
    }
}

/// The least scores, descending; at most [`N_RECALLS`].
fn thresholds(matches: &ScoredMatches, times: &[u16]) -> Vec<f64> {
    let n_annotations = matches.n_annotations(times) as f64;
    let n_hits: u64 = matches.hits.iter().map(|it| u64::from(times[it.scan as usize])).sum();
    let mut thresholds = Vec::with_capacity(N_RECALLS);
    let (mut n_before, mut next_recall) = (0_u64, 0.0);
    for hit in &matches.hits {
        for _ in 0..times[hit.scan as usize] {
            let is_last = n_before + 1 == n_hits;
            let recall = (n_before + 1) as f64 / n_annotations;
            let recall_of_next = if is_last { recall } else { (n_before + 2) as f64 / n_annotations };
            n_before += 1;
            if recall_of_next - next_recall < next_recall - recall && !is_last {
                continue;
            }
            thresholds.push(hit.score);
            // Summed up, as the makers do: a product rounds otherwise.
            next_recall += 1.0 / (N_RECALLS as f64 - 1.0);
        }
    }
    thresholds.truncate(N_RECALLS);
    thresholds
}

/// The largest value at each place or after it. What is no number stays none, and is smaller than every other.
fn best_from_here(values: &[f64; N_RECALLS]) -> [f64; N_RECALLS] {
    let (mut best, mut largest) = (*values, f64::NEG_INFINITY);
    for value in best.iter_mut().rev() {
        largest = largest.max(*value);
        if !value.is_nan() {
            *value = largest;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::averages::Recalls;
    use super::super::score_events::{Hit, ScoreEvent};
    use super::*;

    /// Detections of these scores, right or false, one a scan, of `n` annotations.
    fn matches(scored: &[(f64, bool)], n: u32) -> ScoredMatches {
        let mut matches = ScoredMatches { annotations: vec![(0, n)], ..ScoredMatches::default() };
        for (&(score, is_right), scan) in scored.iter().zip(0..) {
            if is_right {
                matches.hits.push(Hit { score, scan });
            }
            let (tp, fp) = (i32::from(is_right), i32::from(!is_right));
            let similarity = f64::from(tp);
            matches.events.push(ScoreEvent { score, scan, tp, fp, similarity });
        }
        matches.sort();
        matches
    }

    #[test]
    fn one_of_one_is_one_recall_of_41() {
        let curve = OfficialCurve::of(&matches(&[(0.9, true)], 1), &[1]);
        assert_eq!(curve.precision[..2], [1.0, 0.0]);
        assert_eq!(curve.average_precision(Recalls::R11), Some(1.0 / 11.0));
        assert_eq!(curve.average_precision(Recalls::R40), Some(0.0));
    }

    #[test]
    fn forty_one_of_forty_one_is_all() {
        for (n, r40) in [(40, 39.0 / 40.0), (41, 1.0), (100, 1.0)] {
            let all: Vec<(f64, bool)> = (0..n).map(|it| (f64::from(it), true)).collect();
            let curve = OfficialCurve::of(&matches(&all, n), &vec![1; all.len()]);
            assert_eq!(curve.average_precision(Recalls::R40), Some(r40), "{n}");
        }
    }

    #[test]
    fn a_hundred_of_two_hundred_is_half() {
        // Every other detection is false; so is precision a half from the second on.
        let half: Vec<(f64, bool)> = (0..200).map(|it| (f64::from(-it), it % 2 == 0)).collect();
        let curve = OfficialCurve::of(&matches(&half, 200), &[1; 200]);
        // Recall 0 is the first detection; recall 0.5 is the last that is right, of 199.
        assert_eq!(curve.precision[0], 1.0);
        assert_eq!(curve.precision[20], 100.0 / 199.0);
        assert_eq!(curve.precision[21], 0.0);
    }

    #[test]
    fn scans_drawn_twice_count_twice() {
        let once: Vec<(f64, bool)> = (0..60).map(|it| (f64::from(-it), it % 3 != 0)).collect();
        let twice: Vec<(f64, bool)> = once.iter().flat_map(|it| [*it, *it]).collect();
        let of_drawn = OfficialCurve::of(&matches(&once, 50), &[2; 60]);
        assert_eq!(of_drawn, OfficialCurve::of(&matches(&twice, 100), &[1; 120]));
    }
}
