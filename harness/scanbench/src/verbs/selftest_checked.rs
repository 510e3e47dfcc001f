//! A check of `scanbench selftest`, and whether it is passed.

use evaluation::matching::criterion::Criterion;
use evaluation::matching::outcome::{AnnotationOutcome, Assignment};
use evaluation::metrics::counts::{Counts, FalseDetections};
use reports::rows::counts::Counts as Scored;
use reports::vocabulary::task::Task;

/// One data set, task and criterion.
pub struct Checked {
    /// Id of the data set.
    pub dataset: String,
    /// The task.
    pub task: Task,
    /// The criterion.
    pub criterion: Criterion,
    /// The way that the detections came on; `None` if they did not leave the program.
    pub through: Option<&'static str>,
    /// What became of annotations and detections.
    pub counts: Counts,
    /// Whether false detections are known.
    pub false_detections: FalseDetections,
    /// The most that a pair may cost.
    pub most_cost: f64,
    /// The most that a pair costs.
    pub largest_cost: f64,
}

impl Checked {
    fn scored(&self) -> Scored {
        self.counts.scored(self.false_detections)
    }

    /// Whether all is found, nothing is false, and no pair costs too much.
    pub fn is_perfect(&self) -> bool {
        let scored = self.scored();
        let rates = [scored.recall(), scored.precision(), scored.f_rate()];
        let known = if self.false_detections == FalseDetections::Known { 3 } else { 1 };
        // Unknowable detections would be false ones if they were known.
        rates[..known].iter().all(|&rate| rate == Some(1.0))
            && self.counts.n_unknowable == 0
            && self.largest_cost <= self.most_cost
    }
}

impl std::fmt::Display for Checked {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let scored = self.scored();
        let rate = |value: Option<f64>| value.map_or("undefined".to_owned(), |value| value.to_string());
        write!(
            formatter,
            "{:<6} {}, {} by {}{}: recall {}, precision {}, F-rate {} over {} annotations, largest cost {}",
            if self.is_perfect() { "ok" } else { "FAILED" },
            self.dataset,
            self.task.name(),
            self.criterion.name(),
            self.through.map_or_else(String::new, |it| format!(", through {it}")),
            rate(scored.recall()),
            rate(scored.precision()),
            rate(scored.f_rate()),
            scored.no(),
            self.largest_cost,
        )
    }
}

/// The most that a pair of `assignment` costs.
pub fn largest_cost(assignment: &Assignment) -> f64 {
    let cost = |it: &AnnotationOutcome| match it {
        AnnotationOutcome::Matched { cost, .. } => *cost,
        _ => 0.0,
    };
    assignment.annotations.iter().map(cost).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A check on five annotations that all were found, changed by `change`.
    #[track_caller]
    fn check(change: impl FnOnce(&mut Checked), expected_perfect: bool) {
        let mut checked = Checked {
            dataset: "drawn".to_owned(),
            task: Task::Objects,
            criterion: Criterion::POINTS,
            through: None,
            counts: Counts { n_annotations: 5, n_matched: 5, ..Counts::default() },
            false_detections: FalseDetections::Known,
            most_cost: 0.0,
            largest_cost: 0.0,
        };
        change(&mut checked);
        assert_eq!(checked.is_perfect(), expected_perfect, "{checked}");
        assert_eq!(checked.to_string().starts_with("ok "), expected_perfect, "{checked}");
    }

    #[test]
    fn all_found_and_nothing_else_at_no_cost_is_perfect() {
        check(|_| {}, true);
        check(|it| it.counts.n_ignored_annotations = 3, true);
        check(|it| it.false_detections = FalseDetections::Unknowable, true);
    }

    #[test]
    fn anything_less_is_not() {
        check(|it| it.counts.n_matched = 4, false);
        check(|it| it.counts.n_false = 1, false);
        check(|it| it.largest_cost = 1e-9, false);
        check(|it| it.counts.n_unknowable = 1, false);
        check(|it| it.counts = Counts::default(), false);
    }

    #[test]
    fn where_false_detections_are_unknowable_a_miss_is_still_one() {
        let unknowable = |n_matched, n_unknowable| {
            move |it: &mut Checked| {
                it.false_detections = FalseDetections::Unknowable;
                it.counts.n_matched = n_matched;
                it.counts.n_unknowable = n_unknowable;
            }
        };
        check(unknowable(4, 0), false);
        check(unknowable(5, 1), false);
    }
}
