//! Numbers under protocols of others held to tolerances, one by one.

use crate::numbers::tally::Tally;
use crate::protocols::drawn_scans::DrawnScans;
use crate::protocols::protocol_tally::ProtocolTally;
use crate::verdicts::finding::Finding;
use crate::verdicts::gated_metrics::{GatedMetric, Missing, judged};
use crate::verdicts::protocol_differences::{ProtocolPair, ProtocolSide, pairs};
use crate::verdicts::rule_problems::{RuleProblem, RuleProblems};
use crate::verdicts::tolerances::{Tolerances, names_meant};
use crate::vocabulary::metric::Direction;
use crate::vocabulary::protocol::Protocol;

/// Every number that `tolerances` are about, protocol by protocol and detector by detector, over all data sets of `tally` of one origin together.
///
/// # Errors
///
/// [`RuleProblems`] with the rules that decide about nothing.
pub(super) fn gated_protocols(
    tally: &Tally,
    [before, after]: [&ProtocolTally; 2],
    tolerances: &Tolerances,
) -> Result<Vec<GatedMetric>, RuleProblems> {
    let mut gated = Vec::new();
    if tolerances.protocols.is_empty() {
        return Ok(gated);
    }
    let judged: Vec<_> = judged(tally).into_iter().map(|(it, on)| (DrawnScans::of(tally, &it), on)).collect();
    let asked = |it: &Protocol| tolerances.protocols.iter().any(|rule| rule.protocol == *it);
    let protocols = Protocol::ALL.into_iter().filter(asked);
    for (protocol, (scans, on)) in protocols.flat_map(|protocol| judged.iter().map(move |it| (protocol, it)))
    {
        for detector in tally.detectors() {
            let sides = [before, after].map(|it| ProtocolSide::of(it, protocol, detector, scans));
            let pairs = match &sides {
                [Some(before), Some(after)] => pairs(before, after, scans),
                // Whoever is missing on one side has no number there.
                [Some(only), None] | [None, Some(only)] => {
                    let is_there = [sides[0].is_some(), sides[1].is_some()];
                    let alone = pairs(only, only, scans).into_iter();
                    alone.map(|it| ProtocolPair { is_there, difference: None, ..it }).collect()
                }
                [None, None] => continue,
            };
            let of_pair = |it| {
                let gated = gated_number(it, (protocol, detector), tolerances)?;
                Some(GatedMetric { on: on.clone(), ..gated })
            };
            gated.extend(pairs.into_iter().filter_map(of_pair));
        }
    }
    RuleProblems::check(tolerances.path(), void_rules(tolerances, &gated))?;
    Ok(gated)
}

/// `None` if no rule is about it, it has no better way, or neither side has the number.
fn gated_number(
    pair: ProtocolPair,
    (protocol, detector): (Protocol, &str),
    tolerances: &Tolerances,
) -> Option<GatedMetric> {
    let ProtocolPair { class, metric, is_there, difference } = pair;
    let mut rules = tolerances.protocols.iter();
    let rule_idx = rules.position(|it| it.is_about((protocol, detector), &class, &metric.id()))?;
    let difference = match (difference, is_there) {
        (Some(difference), _) => Ok(difference),
        (None, [true, _]) => Err(Missing::InRun),
        (None, [false, true]) => Err(Missing::InBaseline),
        (None, [false, false]) => return None,
    };
    if metric.direction() == Direction::Neither {
        return None;
    }
    let tolerance = tolerances.protocols[rule_idx].tolerance(difference.as_ref().map_or(0.0, |it| it.before));
    let finding = difference
        .as_ref()
        .map_or(Finding::Incomparable, |it| Finding::of(it.worsening(), it.sure_worsening(), tolerance));
    let (task, detector) = (protocol.name().to_owned(), detector.to_owned());
    Some(GatedMetric {
        on: None,
        task,
        detector,
        slice: class,
        metric,
        rule_idx,
        difference,
        tolerance,
        finding,
    })
}

/// Metrics and classes of rules that no number was held to.
fn void_rules(tolerances: &Tolerances, gated: &[GatedMetric]) -> Vec<RuleProblem> {
    let mut problems = Vec::new();
    for (rule_idx, rule) in tolerances.protocols.iter().enumerate() {
        let of_rule = || gated.iter().filter(|it| it.rule_idx == rule_idx && it.task == rule.protocol.name());
        for metric in &rule.metrics {
            for class in &rule.classes {
                let is_held =
                    |it: &GatedMetric| names_meant(metric, &it.metric.id()) && names_meant(class, &it.slice);
                if !of_rule().any(is_held) {
                    let what = format!(
                        "the rule has no effect on {metric:?} of {class:?}: neither run has it, or an earlier rule applies"
                    );
                    problems.push(RuleProblem { place: rule.place(rule_idx), what });
                }
            }
        }
    }
    problems
}
