//! Average precision as av2 computes it, for several draws of scans at once.

use std::ops::Range;

use super::drawn_scans::{Times, add};
use super::ranked_classes::RankedClass;
use super::recall_grid::{N_RECALLS, n_to_pass, on_line, recall_at};
use crate::vocabulary::protocol::PAIR_DISTANCES_M;

/// Average precision at each of [`PAIR_DISTANCES_M`] in each draw: the mean over recalls of the best precision at that
/// recall or a higher one.
pub(super) fn average_precisions<const N: usize>(
    class: &RankedClass,
    times: &[Times<N>],
    n_annotations: &[f64; N],
) -> [[f64; N]; PAIR_DISTANCES_M.len()] {
    let mut of_distances: [BestPrecisions<N>; PAIR_DISTANCES_M.len()] =
        std::array::from_fn(|_| BestPrecisions::new(n_annotations));
    let n_all = class.go_through(times, |finder, n_times, n_before| {
        for (distance, precisions) in of_distances.iter_mut().enumerate() {
            if finder.finds_at(distance) {
                precisions.find(n_times, n_before);
            }
        }
    });
    of_distances.map(|it| it.means(&n_all))
}

/// Best precisions at one distance so far, while going through the ranking.
struct BestPrecisions<const N: usize> {
    n_annotations: [f64; N],
    n_found: [f64; N],
    // Number of detections up to and including the last that found something.
    n_all_when_found: [f64; N],
    // Number to be found for the next recall, and the best precision since the last recall.
    n_needed: [f64; N],
    best: [f64; N],
    passed: [Vec<PassedRecalls>; N],
}

/// Recalls that are passed when a detection finds something.
struct PassedRecalls {
    recalls: Range<usize>,
    /// Recall with this detection.
    recall: f64,
    /// Recall and precision at the find before it; `None` if a false detection stands between, or there is none.
    follows: Option<[f64; 2]>,
    /// Best precision from there on.
    best: f64,
}

impl<const N: usize> BestPrecisions<N> {
    fn new(n_annotations: &[f64; N]) -> Self {
        Self {
            n_annotations: *n_annotations,
            n_found: [0.0; N],
            n_all_when_found: [0.0; N],
            n_needed: n_annotations.map(|it| n_to_pass(0, it)),
            best: [0.0; N],
            passed: std::array::from_fn(|_| Vec::new()),
        }
    }

    /// Counts a detection that finds something, after `n_before` detections.
    #[inline(always)]
    fn find(&mut self, n_times: &Times<N>, n_before: &[f64; N]) {
        add(&mut self.n_found, n_times);
        if self
            .n_found
            .iter()
            .zip(&self.n_needed)
            .map(|(found, needed)| u32::from(found >= needed))
            .sum::<u32>()
            > 0
        {
            self.pass(n_times, n_before);
        }
        for draw in 0..N {
            let n_all = n_before[draw] + n_times[draw];
            // Before the first detection it is NaN, which is not above the best.
            let precision = self.n_found[draw] / n_all;
            self.best[draw] = if precision > self.best[draw] { precision } else { self.best[draw] };
            self.n_all_when_found[draw] =
                if n_times[draw] > 0.0 { n_all } else { self.n_all_when_found[draw] };
        }
    }

    /// Notes the recalls that the newest find passes.
    fn pass(&mut self, n_times: &Times<N>, n_before: &[f64; N]) {
        let (n_found, n_needed) = (self.n_found, self.n_needed);
        for draw in (0..N).filter(|it| n_found[*it] >= n_needed[*it]) {
            let recall = n_found[draw] / self.n_annotations[draw];
            let first = self.end_last(draw);
            let mut end = first;
            while end < N_RECALLS && recall_at(end) < recall {
                end += 1;
            }
            let n_found_before = n_found[draw] - n_times[draw];
            let follows = n_found_before > 0.0 && n_before[draw] == self.n_all_when_found[draw];
            let before =
                || [n_found_before / self.n_annotations[draw], n_found_before / self.n_all_when_found[draw]];
            let follows = follows.then(before);
            self.passed[draw].push(PassedRecalls { recalls: first..end, recall, follows, best: 0.0 });
            self.n_needed[draw] = n_to_pass(end, self.n_annotations[draw]);
        }
    }

    /// Sets the best precision of the recalls passed last, and returns the first recall that is not passed yet.
    fn end_last(&mut self, draw: usize) -> usize {
        let best = std::mem::take(&mut self.best[draw]);
        self.passed[draw].last_mut().map_or(0, |last| {
            last.best = best;
            last.recalls.end
        })
    }

    /// Mean over recalls in each draw, after all `n_all` detections.
    fn means(mut self, n_all: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|draw| {
            let next = self.end_last(draw);
            let mut best = 0.0_f64;
            for it in self.passed[draw].iter_mut().rev() {
                best = best.max(it.best);
                it.best = best;
            }
            let mut sum = 0.0;
            for it in &self.passed[draw] {
                it.recalls.clone().for_each(|index| sum += it.at(index));
            }
            let reached = self.n_found[draw] / self.n_annotations[draw];
            if n_all[draw] > 0.0 && next < N_RECALLS && recall_at(next) == reached {
                sum += self.n_found[draw] / n_all[draw];
            }
            sum / N_RECALLS as f64
        })
    }
}

impl PassedRecalls {
    /// Best precision at the recall of this index. After a false detection it is that of the later detections.
    fn at(&self, index: usize) -> f64 {
        match self.follows {
            Some([recall, precision]) if precision > self.best => {
                on_line(recall_at(index), [recall, precision], [self.recall, self.best])
            }
            _ => self.best,
        }
    }
}
