//! Numbers under protocols of others held to tolerances, one by one.

use crate::numbers::tally::Tally;
use crate::protocols::drawn_scans::DrawnScans;
use crate::protocols::protocol_tally::ProtocolTally;
use crate::verdicts::gated_metrics::{GatedMetric, Missing, judged, void_rules};
use crate::verdicts::protocol_differences::{ProtocolPair, ProtocolSide, pairs};
use crate::verdicts::rule_problems::{RuleProblems, RuleTable};
use crate::verdicts::tolerances::{GatedSubject, Tolerances};
use crate::vocabulary::metric::Direction;
use crate::vocabulary::protocol::Protocol;

/// Every number that `tolerances` are about, protocol by protocol and detector by detector, over all data sets of `tally` of
/// one origin together.
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
    let asked = |it: &Protocol| tolerances.protocols.iter().any(|rule| rule.is_within(it.name()));
    for protocol in Protocol::ALL.into_iter().filter(asked) {
        for ((scans, on), detector) in
            judged.iter().flat_map(|it| tally.detectors().iter().map(move |detector| (it, detector)))
        {
            let sides = [before, after].map(|it| ProtocolSide::of(it, protocol, detector, scans));
            let pairs = match &sides {
                [Some(before), Some(after)] => pairs(before, after, scans),
                // A detector that is missing on one side has no number there.
                [Some(only), None] | [None, Some(only)] => {
                    let is_there = [sides[0].is_some(), sides[1].is_some()];
                    let alone = pairs(only, only, scans).into_iter();
                    alone.map(|it| ProtocolPair { is_there, difference: None, ..it }).collect()
                }
                [None, None] => continue,
            };
            gated.extend(pairs.into_iter().filter_map(|it| {
                let subject = GatedSubject { task: protocol.name(), detector, part: &it.class };
                gated_number(&it, subject, on.as_deref(), tolerances)
            }));
        }
    }
    let named = |metric: &str| format!("{metric:?}");
    let problems = void_rules(&tolerances.protocols, RuleTable::Protocol, &gated, named);
    RuleProblems::check(tolerances.path(), problems)?;
    Ok(gated)
}

/// The gated number; `None` if no rule is about it, it has no better way, or neither side has the number.
fn gated_number(
    ProtocolPair { metric, is_there, difference, .. }: &ProtocolPair,
    subject: GatedSubject<'_>,
    on: Option<&str>,
    tolerances: &Tolerances,
) -> Option<GatedMetric> {
    let rule_idx = tolerances.protocols.iter().position(|it| it.is_about(&metric.id(), subject))?;
    if *is_there == [false; 2] || metric.direction() == Direction::Neither {
        return None;
    }
    let difference = difference.clone().ok_or_else(|| Missing::of(*is_there));
    let before = difference.as_ref().map_or(0.0, |it| it.before);
    let tolerance = tolerances.protocols[rule_idx].tolerance(metric, before);
    Some(GatedMetric::new(subject, on, metric, difference, rule_idx, tolerance))
}
