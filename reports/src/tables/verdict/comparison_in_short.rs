//! A comparison on one screen: its conclusion, the rates that detectors are known by, and what surely differs.

use crate::tables::sheet::{Part, Sheet, Tabular};
use crate::tables::verdict::comparison::{Comparison, NamedDifference};
use crate::verdicts::paired_difference::PairedDifference;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;

/// Lines of the table: with what is around it, it fits on a screen.
const MOST_LINES: usize = 30;

/// A comparison in a few lines.
#[derive(Debug, Clone, Copy)]
pub struct InShort<'a>(pub &'a Comparison);

impl Tabular for InShort<'_> {
    fn sheet(&self) -> Sheet {
        let whole = self.0.sheet();
        let shown = shown(self.0);
        if shown.len() == self.0.differences.len() || self.0.differences.is_empty() {
            return Sheet { lead: lead(self.0), ..whole };
        }
        let grid = self.0.grid_of(&shown);
        let title = Some(format!("{}.", self.0.title));
        let mut lead = lead(self.0);
        lead.push(format!(
            "Shown: {} of them, by which detectors are known or which surely differ; --full shows all.",
            shown.len()
        ));
        Sheet { lead, parts: vec![Part { title, grid }], ..whole }
    }
}

/// The numbers that are shown, in their order: first those that surely differ, the surest of these, then headlines.
fn shown(comparison: &Comparison) -> Vec<&NamedDifference> {
    let mut indices: Vec<usize> = (0..comparison.differences.len()).collect();
    let all = &comparison.differences;
    let rank = |it: &usize| {
        let NamedDifference { difference, is_headline, slice, .. } = &all[*it];
        let is_nothing = difference.before == 0.0 && difference.after == 0.0;
        match (is_sure(difference), *is_headline && !is_nothing) {
            (true, true) => Some(0),
            (false, true) => Some(1),
            (true, false) => Some(2),
            (false, false) => {
                let is_rate = matches!(difference.metric, Metric::Precision | Metric::Recall);
                (is_rate && slice == Slice::All.name().as_str() && difference.difference() != 0.0)
                    .then_some(3)
            }
        }
    };
    indices.retain(|it| rank(it).is_some());
    indices.sort_by(|a, b| rank(a).cmp(&rank(b)).then(sureness(&all[*b]).total_cmp(&sureness(&all[*a]))));
    indices.truncate(MOST_LINES);
    indices.sort_unstable();
    indices.into_iter().map(|it| &all[it]).collect()
}

fn is_sure(difference: &PairedDifference) -> bool {
    difference.is_surely_better() || difference.sure_worsening().is_some_and(|it| it > 0.0)
}

/// The difference over the width of its interval.
fn sureness(named: &NamedDifference) -> f64 {
    let difference = &named.difference;
    let width = difference.interval.map_or(f64::INFINITY, |it| it.ends[1] - it.ends[0]);
    difference.difference().abs() / width.max(f64::MIN_POSITIVE)
}

/// How many numbers differ, and how many surely.
fn lead(comparison: &Comparison) -> Vec<String> {
    let all: Vec<&PairedDifference> = comparison.differences.iter().map(|it| &it.difference).collect();
    let n = |is: &dyn Fn(&PairedDifference) -> bool| all.iter().filter(|it| is(it)).count();
    let n_different = n(&|it| it.difference() != 0.0);
    if n_different == 0 {
        return vec![format!("None of {} numbers differs.", all.len())];
    }
    let (n_better, n_worse) =
        (n(&PairedDifference::is_surely_better), n(&|it| it.sure_worsening().is_some_and(|it| it > 0.0)));
    let subject = if comparison.drift.is_some() { "Afterwards" } else { "Of B" };
    let numbers = if all.len() == 1 { "number" } else { "numbers" };
    let decides = all.iter().any(|it| it.interval.is_some_and(|it| !it.blocks.decide_nothing()));
    vec![if decides {
        format!(
            "{subject} {n_better} of {} {numbers} are surely better and {n_worse} surely worse; {} more differ.",
            all.len(),
            n_different - n_better - n_worse
        )
    } else {
        format!("{n_different} of {} {numbers} differ; these scans are too few to be sure of any.", all.len())
    }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::terminal::Terminal;

    /// A difference of the recall in slice `number`, with an interval of `n_blocks` around it.
    fn named(number: usize, difference: f64, n_blocks: u64) -> NamedDifference {
        let interval = Interval {
            ends: [difference - 0.02, difference + 0.02],
            blocks: BlockCount::of_dataset(n_blocks, BlockKind::Drives),
        };
        NamedDifference {
            task: "objects".to_owned(),
            detector: "grid".to_owned(),
            slice: format!("slice-{number}"),
            is_headline: number < 2,
            difference: PairedDifference {
                metric: Metric::Recall,
                before: 0.5,
                after: 0.5 + difference,
                interval: Some(interval),
                least_effect: None,
            },
        }
    }

    fn printed(differences: Vec<NamedDifference>) -> String {
        let comparison = Comparison {
            title: "Two runs".to_owned(),
            differences,
            unit: "scan",
            drift: Some((0, std::collections::BTreeMap::new())),
            most_changed: None,
            doubts: Vec::new(),
            configuration_changes: Vec::new(),
            new_detectors: Vec::new(),
        };
        Terminal { width: None }.text(&InShort(&comparison))
    }

    #[test]
    fn a_comparison_is_one_screen_with_a_conclusion() {
        let of =
            |n_blocks: u64| (0..200).map(move |it| named(it, if it % 4 == 2 { 0.1 } else { 0.0 }, n_blocks));
        let many = printed(of(12).collect());
        assert!(
            many.starts_with(
                "Afterwards 50 of 200 numbers are surely better and 0 surely worse; 0 more differ.\n"
            ),
            "{many}"
        );
        // Both headlines, and others that surely differ.
        assert!(
            many.contains("slice-0 ") && many.contains("slice-1 ") && many.contains("slice-2 "),
            "{many}"
        );
        assert!(!many.contains("slice-3 ") && many.contains("Shown: 30 of them"), "{many}");
        assert!(many.lines().count() < 50, "{many}");
        let few = printed(of(3).collect());
        assert!(
            few.starts_with("50 of 200 numbers differ; these scans are too few to be sure of any.\n"),
            "{few}"
        );
        assert!(few.contains("slice-1 ") && !few.contains("slice-2 "), "{few}");
        let same = printed((0..3).map(|it| named(it, 0.0, 12)).collect());
        assert!(same.starts_with("None of 3 numbers differs.\n"), "{same}");
    }
}
