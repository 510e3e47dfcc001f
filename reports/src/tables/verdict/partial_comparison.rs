//! Two results of `scanbench partial` side by side, two methods of one, and what a gate says of them.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::{Fixed, fixed_decimals};
use crate::run_folder::partial_archive::PartialArchive;
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::sheet::{Listing, Part, Sheet, Tabular};
use crate::uncertainty::bootstrap::N_RESAMPLES;
use crate::verdicts::comparability::NotComparable;
use crate::verdicts::finding::Finding;
use crate::verdicts::partial_difference::{
    ChangedPrediction, CurveName, PartialDifference, changed_predictions, check_comparable_results,
    check_same_parts, differences, rows_of_curves,
};
use crate::verdicts::partial_verdict::PartialVerdict;

/// What was compared with what, and the result.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialComparison {
    /// In words.
    pub title: String,
    /// Curve by curve, metric by metric, step by step.
    pub differences: Vec<PartialDifference>,
    /// How often the predicted class of an object changed; `None` where two methods are compared, whose classes are expected
    /// to differ.
    pub n_changed_predictions: Option<usize>,
}

impl PartialComparison {
    /// Compares two results on the same parts of the same objects.
    ///
    /// # Errors
    ///
    /// [`NotComparable`] if they are of other parts or objects, or the later one lacks a method.
    pub fn of_results(before: &PartialArchive, after: &PartialArchive) -> Result<Self, NotComparable> {
        check_comparable_results(before, after)?;
        let later = rows_of_curves(after);
        let of_curves = rows_of_curves(before);
        let found = of_curves.iter().flat_map(|(name, rows)| differences(name, rows, &later[name]));
        Ok(Self {
            title: format!("Two results on the same objects. {}", after.manifest.title()),
            differences: found.collect(),
            n_changed_predictions: Some(changed_predictions(before, after).len()),
        })
    }

    /// Compares method `second` of `archive` with method `first`: where both saw the same objects and were
    /// trained on the same. If there is no such pair, they may be trained on anything.
    ///
    /// # Errors
    ///
    /// [`NotComparable`] if they did not see the same parts.
    pub fn of_methods(archive: &PartialArchive, first: &str, second: &str) -> Result<Self, NotComparable> {
        let curves = rows_of_curves(archive);
        let mut pairs: Vec<(&CurveName, &CurveName)> = Vec::new();
        for name in curves.keys().filter(|it| it.method == first) {
            let of_same = |it: &&CurveName| {
                it.method == second && (&it.data, &it.direction) == (&name.data, &name.direction)
            };
            pairs.extend(curves.keys().filter(of_same).map(|it| (name, it)));
        }
        let is_alike = |it: &(&CurveName, &CurveName)| it.0.trained_on == it.1.trained_on;
        if pairs.iter().any(is_alike) {
            pairs.retain(is_alike);
        }
        let mut found = Vec::new();
        for (one, other) in pairs {
            let name = CurveName {
                method: format!("{second} − {first}"),
                trained_on: if one.trained_on == other.trained_on {
                    one.trained_on.clone()
                } else {
                    format!("{} − {}", other.trained_on, one.trained_on)
                },
                ..one.clone()
            };
            let [before, after] = [one, other].map(|it| &curves[it]);
            check_same_parts(before, after)
                .map_err(|reason| NotComparable { reasons: vec![format!("{}: {reason}", name.method)] })?;
            found.extend(differences(&name, before, after));
        }
        let title = format!(
            "A: {first}, B: {second}, difference B − A, on the same objects. {}",
            archive.manifest.title()
        );
        Ok(Self { title, differences: found, n_changed_predictions: None })
    }
}

impl Tabular for PartialComparison {
    fn sheet(&self) -> Sheet {
        let lines: Vec<(&PartialDifference, Option<Finding>)> =
            self.differences.iter().map(|it| (it, None)).collect();
        let about = self.n_changed_predictions.map(|n| match n {
            0 => "No prediction changed.".to_owned(),
            n => format!("Predictions changed {n} times (counted per object, step and method)."),
        });
        let sentences = [about_numbers()].into_iter().chain(about).collect();
        // Two results come one after the other, two methods do not.
        let sides = if self.n_changed_predictions.is_some() { RESULTS } else { ["A", "B"] };
        Sheet::of(format!("{} Rates in %.", self.title), grid(&lines, sides), sentences)
            .labelled("comparison")
    }
}

fn about_numbers() -> String {
    format!(
        "95 %: of the difference, from a paired bootstrap of {N_RESAMPLES} resamples of objects, each with all its steps."
    )
}

/// The names of two results.
const RESULTS: [&str; 2] = ["before", "after"];

fn grid(lines: &[(&PartialDifference, Option<Finding>)], [first, second]: [&'static str; 2]) -> Grid {
    let texts = ["data set", "seen from", "method", "trained on", "metric"].map(Column::left);
    let numbers = ["step", first, second, "difference", "95 %"].map(Column::number);
    let has_finding = lines.iter().any(|it| it.1.is_some());
    let finding = has_finding.then(|| Column::left("finding"));
    let line = |(it, finding): &(&PartialDifference, Option<Finding>)| {
        let CurveName { data, direction, method, trained_on } = &it.curve;
        let texts = [data, direction, method, trained_on].into_iter().map(|it| Cell::new(it.clone()));
        let percent = |share: f64| Cell::new(fixed_decimals(100.0 * share, 1));
        let interval = it.interval.map_or_else(
            || Cell::new("–"),
            |it| Cell::interval(it.ends.map(signed_percent).join(" to "), it.blocks),
        );
        let numbers = [
            Cell::new(it.metric.in_words()),
            Cell::new(it.step.to_string()),
            percent(it.before),
            percent(it.after),
            Cell::new(signed_percent(it.difference())),
            interval,
        ];
        let finding = finding.map(|it| Cell::new(it.in_words()));
        Line { kind: LineKind::Dataset, cells: texts.chain(numbers).chain(finding).collect() }
    };
    Grid {
        columns: texts.into_iter().chain(numbers).chain(finding).collect(),
        lines: lines.iter().map(line).collect(),
    }
}

fn signed_percent(share: f64) -> String {
    let text = fixed_decimals(100.0 * share, 1);
    if text.starts_with('-') { text.replacen('-', "−", 1) } else { format!("+{text}") }
}

/// A verdict, with all of its numbers or only those beyond their tolerance.
#[derive(Debug, Clone, Copy)]
pub struct PartialSummary<'a> {
    /// The verdict.
    pub verdict: &'a PartialVerdict,
    /// How much of it.
    pub extent: SummaryExtent,
}

/// How much of a verdict is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SummaryExtent {
    /// Numbers beyond their tolerance, and the first objects whose predicted class changed.
    Brief,
    /// The same without the conclusion: a result is accepted because it changed.
    Accept,
    /// Everything.
    Full,
}

/// Objects that are named in a brief summary.
const MOST_NAMED: usize = 5;

impl Tabular for PartialSummary<'_> {
    fn sheet(&self) -> Sheet {
        let PartialVerdict { title, findings, drift, tolerances } = self.verdict;
        let is_full = self.extent == SummaryExtent::Full;
        let shown: Vec<(&PartialDifference, Option<Finding>)> = findings
            .iter()
            .filter(|it| is_full || it.1 != Finding::Pass || -it.0.worsening() > tolerances.of(it.0.metric))
            .map(|(difference, finding)| (difference, Some(*finding)))
            .collect();
        let n_of = |finding| self.verdict.n(finding);
        let lead = vec![
            match self.extent {
                SummaryExtent::Accept => title.clone(),
                SummaryExtent::Brief | SummaryExtent::Full => {
                    format!("{}. {title}", self.verdict.conclusion().in_words())
                }
            },
            format!(
                "{} numbers: {} worse, {} inconclusive, {} passed. Predictions changed: {}.",
                findings.len(),
                n_of(Finding::Regression),
                n_of(Finding::Inconclusive),
                n_of(Finding::Pass),
                drift.len()
            ),
        ];
        let n_named = if is_full { drift.len() } else { drift.len().min(MOST_NAMED) };
        let entries = drift[..n_named].iter().map(|it| (name_of(&it.curve), vec![change_text(it)]));
        let listing =
            (n_named > 0).then(|| Listing { entries: entries.collect(), in_full: "gate.json lists all" });
        let parts = if shown.is_empty() {
            Vec::new()
        } else {
            vec![Part { title: Some("Rates in %.".to_owned()), grid: grid(&shown, RESULTS) }]
        };
        Sheet { lead, listing, ..Sheet::of_parts(parts, vec![about_numbers()]) }
    }
}

fn name_of(CurveName { data, direction, method, trained_on }: &CurveName) -> String {
    format!("{method} trained on {trained_on}, {data} from {direction}")
}

fn change_text(it: &ChangedPrediction) -> String {
    format!("{} at step {}: {}, and now {}", it.object, it.step, it.before.name(), it.after.name())
}

/// `gate.json` of partial clouds: a verdict for programs.
pub fn partial_verdict_json(verdict: &PartialVerdict) -> String {
    let curve = |it: &CurveName| serde_json::json!({"data": it.data, "direction": it.direction, "method": it.method, "trained_on": it.trained_on});
    let findings = verdict.findings.iter().map(|(it, finding)| {
        serde_json::json!({
            "curve": curve(&it.curve), "step": it.step, "metric": it.metric.id(), "before": it.before, "after": it.after,
            "difference": it.difference(), "difference_interval_95": it.interval.map(|it| it.ends), "finding": finding.name(),
        })
    });
    let drift = verdict.drift.iter().map(|it| {
        serde_json::json!({
            "curve": curve(&it.curve), "object": it.object, "step": it.step, "before": it.before, "after": it.after,
        })
    });
    let record = serde_json::json!({
        "schema": crate::files::archive::SCHEMA,
        "conclusion": verdict.conclusion().name(),
        "numbers": findings.collect::<Vec<_>>(),
        "drift": drift.collect::<Vec<_>>(),
    });
    format!("{record:#}\n")
}

row! {
    /// `comparison.csv` of partial clouds: one row for every difference.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct PartialDifferenceRow {
        data: String,
        direction: String,
        method: String,
        trained_on: String,
        metric: String,
        step: u32,
        before: Fixed<6>,
        after: Fixed<6>,
        difference: Fixed<6>,
        low: Option<Fixed<6>>,
        high: Option<Fixed<6>>,
        few_blocks: Option<bool>,
    }
}

impl PartialDifferenceRow {
    /// The rows of a comparison, in the order of its table.
    pub fn all(comparison: &PartialComparison) -> Vec<Self> {
        comparison.differences.iter().map(Self::of).collect()
    }

    fn of(it: &PartialDifference) -> Self {
        let CurveName { data, direction, method, trained_on } = it.curve.clone();
        Self {
            data,
            direction,
            method,
            trained_on,
            metric: it.metric.id().to_owned(),
            step: it.step,
            before: Fixed(it.before),
            after: Fixed(it.after),
            difference: Fixed(it.difference()),
            low: it.interval.map(|it| Fixed(it.ends[0])),
            high: it.interval.map(|it| Fixed(it.ends[1])),
            few_blocks: it.interval.map(|it| it.blocks.are_too_few()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::to_csv_bytes;
    use crate::files::texts::check_holds;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::markdown::Markdown;
    use crate::verdicts::partial_difference::tests::archive;
    use crate::verdicts::partial_verdict::{PartialTolerances, judge_partial};

    #[test]
    fn two_results_stand_side_by_side_with_the_interval_of_their_difference() {
        let comparison = PartialComparison::of_results(&archive(40), &archive(35)).unwrap();
        let text = Markdown.text(&comparison);
        check_holds(&text, &["(simulated)", "−12.5", "mean of recalls", "10 times (counted per object"]);
        let rows = String::from_utf8(to_csv_bytes(&PartialDifferenceRow::all(&comparison)).unwrap()).unwrap();
        assert!(
            rows.contains("street,below,graphs,parts,mean_recall,1,1.000000,0.875000,-0.125000,-0."),
            "{rows}"
        );
    }

    #[test]
    fn two_methods_are_compared_where_they_saw_the_same() {
        let mut both = archive(40);
        let other = archive(30).rows.into_iter().map(|mut it| {
            it.method = "extents".to_owned();
            it
        });
        both.rows.extend(other);
        let comparison = PartialComparison::of_methods(&both, "graphs", "extents").unwrap();
        let [only] = &comparison.differences[..] else { panic!("{comparison:?}") };
        assert_eq!((only.curve.method.as_str(), only.difference()), ("extents − graphs", -0.25));
        both.rows.pop();
        let error = PartialComparison::of_methods(&both, "graphs", "extents").unwrap_err().to_string();
        assert!(error.contains("step 1 of pole-39 is only in the earlier one"), "{error}");
    }

    #[test]
    fn a_verdict_names_what_is_worse_and_which_predictions_changed() {
        let verdict = judge_partial(&archive(40), &archive(30), &PartialTolerances::built_in()).unwrap();
        let brief = Markdown.text(&PartialSummary { verdict: &verdict, extent: SummaryExtent::Brief });
        check_holds(&brief, &["FAILED: worse", "1 worse", "tree-30 at step 1: tree, and now pole", "−25.0"]);
        assert!(!brief.contains("pole-39"), "{brief}");
        let full = Markdown.text(&PartialSummary { verdict: &verdict, extent: SummaryExtent::Full });
        assert!(full.contains("tree-39"), "{full}");
        let json: serde_json::Value = serde_json::from_str(&partial_verdict_json(&verdict)).unwrap();
        assert_eq!(
            (json["conclusion"].as_str(), json["drift"].as_array().unwrap().len()),
            (Some("regression"), 20)
        );
        let same = judge_partial(&archive(40), &archive(40), &PartialTolerances::built_in()).unwrap();
        let text = Markdown.text(&PartialSummary { verdict: &same, extent: SummaryExtent::Brief });
        assert!(text.contains("PASSED") && !text.contains("mean of recalls"), "{text}");
    }
}
