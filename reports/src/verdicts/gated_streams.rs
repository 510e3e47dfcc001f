//! Rates of runs as they stream, held to tolerances.

use crate::numbers::tally::Tally;
use crate::uncertainty::sample::Question;
use crate::verdicts::gated_metrics::{GatedMetric, Sides, judged, void_rules};
use crate::verdicts::rule_problems::{RuleProblem, RuleProblems, RuleTable};
use crate::verdicts::tolerances::{StreamRule, Tolerances};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;

/// Moments of a baseline and of a run, as a rule asks for them.
#[derive(Debug, Clone)]
pub struct StreamPair {
    /// Of the baseline.
    pub before: Tally,
    /// Of the run.
    pub after: Tally,
}

/// Every number that the rules about streams are about; `streams` are in the order of the rules.
///
/// # Errors
///
/// [`RuleProblems`] with the rules that decide about nothing.
pub(super) fn gated_streams(
    streams: &[StreamPair],
    tolerances: &Tolerances,
) -> Result<Vec<GatedMetric>, RuleProblems> {
    let mut gated = Vec::new();
    let mut problems: Vec<RuleProblem> = Vec::new();
    for (rule_idx, (rule, pair)) in tolerances.streams.iter().zip(streams).enumerate() {
        let of_rule = of_rule(rule, pair);
        if of_rule.is_empty() {
            let void = void_rules(
                std::slice::from_ref(&rule.rule),
                |_| RuleTable::Streaming(0),
                &of_rule,
                str::to_owned,
            );
            let named = void.into_iter().take(1).map(|mut it| {
                it.position.table = RuleTable::Streaming(rule_idx);
                it
            });
            problems.extend(named);
        }
        gated.extend(of_rule.into_iter().map(|it| GatedMetric { rule_idx, ..it }));
    }
    RuleProblems::check(tolerances.path(), problems)?;
    Ok(gated)
}

fn of_rule(StreamRule { rule, lateness, .. }: &StreamRule, pair: &StreamPair) -> Vec<GatedMetric> {
    let draws = pair.before.draw();
    let sides = Sides { before: &pair.before, after: &pair.after, draws: &draws };
    let mut gated = Vec::new();
    for (dataset, on) in judged(&pair.before) {
        for &task in pair.before.tasks() {
            for detector in pair.before.detectors() {
                let question = Question { dataset: &dataset, task, detector, slice: Slice::All };
                let is_known =
                    |it: &Tally| it.counts(&dataset, task, detector).is_some_and(|it| it.fo().is_some());
                let metric = if is_known(&pair.before) { Metric::FRate } else { Metric::Recall };
                let of_metric = sides.held(std::slice::from_ref(rule), &[metric], &question, on.as_deref());
                let named = of_metric
                    .into_iter()
                    .map(|it| GatedMetric { task: format!("{}, {}", it.task, lateness.in_words()), ..it });
                gated.extend(named);
            }
        }
    }
    gated
}
