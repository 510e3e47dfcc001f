//! Numbers of partly seen objects held to tolerances, one by one.

use crate::numbers::blocks::BlockCount;
use crate::run_folder::run_archive::RunArchive;
use crate::verdicts::gated_metrics::{GatedMetric, void_rules};
use crate::verdicts::partial_differences::{PartialDifference, differences_of_results};
use crate::verdicts::rule_problems::{RuleProblems, RuleTable};
use crate::verdicts::tolerances::{GatedSubject, Tolerances};
use crate::vocabulary::study::Study;

/// Every number that `tolerances` are about, curve by curve, metric by metric, step by step; and the objects that most of
/// them are of, if there are any.
///
/// # Errors
///
/// [`RuleProblems`] with the problems of the file, and with its rules that decide about nothing.
pub(super) fn gated_objects(
    [before, after]: [&RunArchive; 2],
    tolerances: &Tolerances,
) -> Result<(Vec<GatedMetric>, Option<BlockCount>), RuleProblems> {
    let differences = differences_of_results(&before.objects, &after.objects);
    let blocks = differences.iter().map(|it| it.blocks).max_by_key(|it| it.n_blocks);
    let gated = differences.into_iter().filter_map(|it| {
        let PartialDifference { on, detector, slice, difference, .. } = it;
        let subject = GatedSubject { task: Study::Partial.name(), detector: &detector, part: &slice };
        let (metric, value) = (difference.metric.clone(), difference.before);
        let rule_idx = tolerances.rule_about(&metric, subject)?;
        let tolerance = tolerances.quality[rule_idx].tolerance(&metric, value);
        Some(GatedMetric::new(subject, Some(&on), &metric, Ok(difference), rule_idx, tolerance))
    });
    let gated: Vec<GatedMetric> = gated.collect();
    let void = void_rules(&tolerances.quality, RuleTable::Quality, &gated, str::to_owned);
    // Sizes for all steps stand in no line, and may cover numbers that are not judged here.
    let void = void.into_iter().filter(|it| it.position.line.is_some());
    RuleProblems::check(tolerances.path(), tolerances.problems.iter().cloned().chain(void))?;
    Ok((gated, blocks))
}
