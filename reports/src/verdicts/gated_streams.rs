//! Rates of runs as they stream, held to tolerances.

use crate::numbers::tally::Tally;
use crate::uncertainty::sample::Question;
use crate::verdicts::gated_metrics::{GatedMetric, Sides, judged};
use crate::verdicts::rule_problems::{RulePosition, RuleProblem, RuleProblems, RuleTable};
use crate::verdicts::suggestion::did_you_mean;
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
        let mut complain = |what: String| {
            let position = RulePosition { line: rule.rule.line, table: RuleTable::Streaming(rule_idx) };
            problems.push(RuleProblem { position, what });
        };
        let detectors = pair.before.detectors();
        for name in rule.rule.detectors.iter().flatten().filter(|it| !detectors.contains(it)) {
            complain(format!(
                "the baseline has no detector {name:?}{}",
                did_you_mean(name, detectors.iter())
            ));
        }
        if of_rule.is_empty() {
            complain("the rule has no effect: the baseline has none of its tasks and detectors".to_owned());
        }
        gated.extend(of_rule.into_iter().map(|it| GatedMetric { rule_idx, ..it }));
    }
    RuleProblems::check(tolerances.path(), problems)?;
    Ok(gated)
}

fn of_rule(stream: &StreamRule, pair: &StreamPair) -> Vec<GatedMetric> {
    let draws = pair.before.draw();
    let sides = Sides { before: &pair.before, after: &pair.after, draws: &draws };
    let mut gated = Vec::new();
    for (dataset, on) in judged(&pair.before) {
        for &task in pair.before.tasks() {
            for detector in pair.before.detectors() {
                let question = Question { dataset: &dataset, task, detector, slice: Slice::All };
                let known = pair.before.counts(&dataset, task, detector);
                // Of a class that is nowhere labelled there is no rate; rules of quality hold its false objects.
                let Some(counts) = known.filter(|it| it.no() > 0) else { continue };
                let metric = if counts.fo().is_some() { Metric::FRate } else { Metric::Recall };
                let of_metric =
                    sides.held(std::slice::from_ref(&stream.rule), &[metric], &question, on.as_deref());
                let named = of_metric
                    .into_iter()
                    .map(|it| GatedMetric { task: format!("{}, {}", it.task, stream.in_words()), ..it });
                gated.extend(named);
            }
        }
    }
    gated
}
