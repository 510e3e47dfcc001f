//! Precision and errors over recall, as nuscenes-devkit computes them, for several draws of scans at once.

use super::drawn_scans::{Times, add};
use super::ranked_classes::{Finder, RankedClass};
use super::recall_grid::{N_RECALLS, n_to_pass, on_line, recall_at};
use crate::rows::ranked_box_row::PairErrors;
use crate::vocabulary::protocol::PAIR_DISTANCES_M;

/// Precision up to this value counts as 0, and recalls up to it do not count.
const LEAST_PRECISION: f64 = 0.1;
/// The first recall that counts: 0.11.
const FIRST_RECALL: usize = 11;

/// Number of errors: of position, size, heading, velocity and attribute.
pub(super) const N_ERRORS: usize = 5;

/// Precision and score at each recall; 0 at recalls that are not reached.
#[derive(Debug, Clone)]
pub(super) struct RecallCurve {
    precisions: [f64; N_RECALLS],
    scores: [f64; N_RECALLS],
}

/// Curves of each draw at each of [`PAIR_DISTANCES_M`]; `None` for a draw in which nothing is found. A detection of a scan
/// that is drawn several times counts as often at once.
pub(super) fn recall_curves<const N: usize>(
    class: &RankedClass,
    times: &[Times<N>],
    n_annotations: &[f64; N],
) -> [Vec<Option<RecallCurve>>; PAIR_DISTANCES_M.len()] {
    let mut of_distances: [Curves<N>; PAIR_DISTANCES_M.len()] =
        std::array::from_fn(|_| Curves::new(n_annotations));
    let n_all = class.go_through(times, |finder, n_times, n_before| {
        for (distance, curves) in of_distances.iter_mut().enumerate() {
            if finder.finds_at(distance) {
                add(&mut curves.n_found, n_times);
                if curves.passes() {
                    curves.pass(class, times, finder, n_before);
                }
            }
        }
    });
    of_distances.map(|it| it.closed(class, times, &n_all))
}

/// Curves at one distance so far, while going through the ranking.
struct Curves<const N: usize> {
    of_draws: Vec<RecallCurve>,
    n_annotations: [f64; N],
    n_found: [f64; N],
    // First recall that is not passed yet, and the number to be found for it.
    next: [usize; N],
    n_needed: [f64; N],
}

impl<const N: usize> Curves<N> {
    fn new(n_annotations: &[f64; N]) -> Self {
        Self {
            of_draws: vec![RecallCurve { precisions: [0.0; N_RECALLS], scores: [0.0; N_RECALLS] }; N],
            n_annotations: *n_annotations,
            n_found: [0.0; N],
            next: [0; N],
            n_needed: n_annotations.map(|it| n_to_pass(0, it)),
        }
    }

    /// Whether any draw found enough for its next recall.
    #[inline(always)]
    fn passes(&self) -> bool {
        self.n_found.iter().zip(&self.n_needed).map(|(found, needed)| u32::from(found >= needed)).sum::<u32>()
            > 0
    }

    /// Takes the values at recalls between the detections before `finder` and `finder` itself.
    fn pass(&mut self, class: &RankedClass, times: &[Times<N>], finder: &Finder, n_before: &[f64; N]) {
        let n_times = class.times_of(finder.index, times);
        let (n_found, n_needed) = (self.n_found, self.n_needed);
        for draw in (0..N).filter(|it| n_found[*it] >= n_needed[*it]) {
            let n_found_before = n_found[draw] - n_times[draw];
            let from = (n_before[draw] > 0.0).then(|| {
                let score = class.last_score(finder.index as usize, times, draw);
                self.point(draw, n_found_before, n_before[draw], score)
            });
            let n_all = n_before[draw] + n_times[draw];
            let to = self.point(draw, n_found[draw], n_all, class.score(finder.index));
            let next = &mut self.next[draw];
            while *next < N_RECALLS && recall_at(*next) < to[0] {
                self.of_draws[draw].take(*next, from.unwrap_or(to), to);
                *next += 1;
            }
            self.n_needed[draw] = n_to_pass(*next, self.n_annotations[draw]);
        }
    }

    /// Recall, precision and score when `n_found` of `n_all` detections have found something.
    fn point(&self, draw: usize, n_found: f64, n_all: f64, score: f64) -> [f64; 3] {
        [n_found / self.n_annotations[draw], n_found / n_all, score]
    }

    /// Curves after the whole ranking; a recall that is reached exactly has the values at the end of the ranking.
    fn closed(
        mut self,
        class: &RankedClass,
        times: &[Times<N>],
        n_all: &[f64; N],
    ) -> Vec<Option<RecallCurve>> {
        for (draw, n_all) in n_all.iter().enumerate() {
            let next = self.next[draw];
            let last = self.point(draw, self.n_found[draw], *n_all, 0.0);
            if self.n_found[draw] > 0.0 && next < N_RECALLS && recall_at(next) == last[0] {
                let score = class.last_score(class.n_detections(), times, draw);
                let last = [last[0], last[1], score];
                self.of_draws[draw].take(next, last, last);
            }
        }
        self.of_draws
            .into_iter()
            .zip(self.n_found)
            .map(|(it, n_found)| (n_found > 0.0).then_some(it))
            .collect()
    }
}

impl RecallCurve {
    /// Takes the values at one recall from the line between two points.
    fn take(&mut self, index: usize, from: [f64; 3], to: [f64; 3]) {
        let at = |axis: usize| {
            if from == to {
                to[axis]
            } else {
                on_line(recall_at(index), [from[0], from[axis]], [to[0], to[axis]])
            }
        };
        (self.precisions[index], self.scores[index]) = (at(1), at(2));
    }

    /// Average precision.
    pub(super) fn average_precision(&self) -> f64 {
        let counted = &self.precisions[FIRST_RECALL..];
        let sum: f64 =
            counted.iter().map(|it| (it - LEAST_PRECISION).max(0.0) / (1.0 - LEAST_PRECISION)).sum();
        sum / counted.len() as f64
    }

    /// Scores at which errors are looked up, from recall 0.11 to the highest reached; empty if that is lower.
    fn looked_up(&self) -> &[f64] {
        let last = self.scores.iter().rposition(|it| *it != 0.0).unwrap_or(0);
        if last < FIRST_RECALL { &[] } else { &self.scores[FIRST_RECALL..=last] }
    }
}

/// Errors of each draw: for each error the mean over detections up to a recall, averaged over recalls from 0.11 to the
/// highest; 1 if the highest is lower. `curves` are those at the distance of errors.
pub(super) fn mean_errors<const N: usize>(
    class: &RankedClass,
    times: &[Times<N>],
    curves: &[Option<RecallCurve>],
) -> [[f64; N_ERRORS]; N] {
    let found: Vec<(u32, &PairErrors)> = class.errors().collect();
    let mut lookups: [Lookup<'_>; N] = std::array::from_fn(|draw| Lookup::of(curves[draw].as_ref()));
    let mut next = lookups.each_ref().map(Lookup::next);
    let mut running = RunningErrors { sums: [[0.0; N]; N_ERRORS], counts: [[0.0; N]; N_ERRORS] };
    for (index_of_found, (index, errors)) in found.iter().enumerate() {
        let (score, n_times) = (class.score(*index), class.times_of(*index, times));
        let is_asked = |(next, n): (&f64, &f64)| u32::from(score <= *next) * u32::from(*n > 0.0);
        if next.iter().zip(n_times).map(is_asked).sum::<u32>() == 0 {
            running.add(errors, n_times);
            continue;
        }
        let before = running.clone();
        running.add(errors, n_times);
        let looked_up = next;
        for draw in (0..N).filter(|it| score <= looked_up[*it] && n_times[*it] > 0.0) {
            let is_there = |(index, _): &&(u32, &PairErrors)| class.times_of(*index, times)[draw] > 0.0;
            let from = found[..index_of_found].iter().rfind(is_there);
            let from = from.map(|(index, _)| (class.score(*index), before.means(draw)));
            lookups[draw].take(from, (score, running.means(draw)));
            next[draw] = lookups[draw].next();
        }
    }
    std::array::from_fn(|draw| lookups[draw].closed(&running.means(draw), running.are_known(draw)))
}

/// Sums of errors up to some detection.
#[derive(Debug, Clone)]
struct RunningErrors<const N: usize> {
    sums: [[f64; N]; N_ERRORS],
    counts: [[f64; N]; N_ERRORS],
}

impl<const N: usize> RunningErrors<N> {
    #[inline(always)]
    fn add(&mut self, errors: &PairErrors, n_times: &Times<N>) {
        let PairErrors { translation_m, scale, orientation_rad, velocity_m_per_s, attribute } = *errors;
        let errors = [Some(translation_m), Some(scale), Some(orientation_rad), velocity_m_per_s, attribute];
        for (kind, error) in errors.into_iter().enumerate() {
            if let Some(error) = error {
                add(&mut self.sums[kind], &n_times.map(|it| it * error));
                add(&mut self.counts[kind], n_times);
            }
        }
    }

    /// Mean errors of a draw; 0 for an error without values.
    fn means(&self, draw: usize) -> [f64; N_ERRORS] {
        std::array::from_fn(|kind| {
            let count = self.counts[kind][draw];
            if count > 0.0 { self.sums[kind][draw] / count } else { 0.0 }
        })
    }

    /// Whether any detection of a draw has each error.
    fn are_known(&self, draw: usize) -> [bool; N_ERRORS] {
        self.counts.map(|it| it[draw] > 0.0)
    }
}

/// Scores at which the errors of one draw are looked up, and the sums of the errors there so far.
struct Lookup<'a> {
    scores: &'a [f64],
    n_taken: usize,
    sums: [f64; N_ERRORS],
}

impl<'a> Lookup<'a> {
    fn of(curve: Option<&'a RecallCurve>) -> Self {
        Self { scores: curve.map_or(&[], RecallCurve::looked_up), n_taken: 0, sums: [0.0; N_ERRORS] }
    }

    /// Next score to look up; NaN if there is none.
    fn next(&self) -> f64 {
        self.scores.get(self.n_taken).copied().unwrap_or(f64::NAN)
    }

    /// Takes the means at all scores down to that of `to`, from the line between `from` and `to`: `to` is the first
    /// detection whose score is not above them, `from` the detection before it.
    fn take(&mut self, from: Option<(f64, [f64; N_ERRORS])>, (to_score, to): (f64, [f64; N_ERRORS])) {
        while to_score <= self.next() {
            let score = self.next();
            for (kind, sum) in self.sums.iter_mut().enumerate() {
                *sum += match from {
                    Some((from_score, from)) if score > to_score => {
                        on_line(score, [to_score, to[kind]], [from_score, from[kind]])
                    }
                    _ => to[kind],
                };
            }
            self.n_taken += 1;
        }
    }

    /// Means over all scores; a score below every detection has the means of all. An error that is never known is 1.
    fn closed(&self, of_all: &[f64; N_ERRORS], are_known: [bool; N_ERRORS]) -> [f64; N_ERRORS] {
        std::array::from_fn(|kind| {
            if self.scores.is_empty() || !are_known[kind] {
                return 1.0;
            }
            let rest = self.scores[self.n_taken..].iter();
            rest.fold(self.sums[kind], |sum, _| sum + of_all[kind]) / self.scores.len() as f64
        })
    }
}
