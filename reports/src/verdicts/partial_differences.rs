//! Differences between two results of `scanbench partial`, or between two methods of one, step by step.

use std::collections::BTreeMap;

use crate::numbers::blocks::BlockCount;
use crate::partial_study::object_draws::ObjectDraws;
use crate::rows::partial_row::PartialRow;
use crate::verdicts::paired_difference::PairedDifference;
use crate::vocabulary::metric::{Metric, PartialMetric};

/// A method, the objects that it saw, and from which end.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct CurveName {
    /// Data set.
    pub data: String,
    /// From which end objects are seen.
    pub direction: String,
    /// The method.
    pub method: String,
    /// Its training data.
    pub trained_on: String,
}

/// A number of two curves, at one step.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialDifference {
    /// The objects, and from which end they are seen.
    pub on: String,
    /// The method and its training data.
    pub detector: String,
    /// The step, as a part of all that is judged.
    pub slice: String,
    /// The numbers.
    pub difference: PairedDifference,
    /// The objects that were drawn from.
    pub blocks: BlockCount,
}

impl CurveName {
    /// The name of the curve that a row belongs to.
    pub fn of(row: &PartialRow) -> Self {
        let [data, direction, method, trained_on] =
            [&row.data, &row.direction, &row.method, &row.trained_on].map(String::clone);
        Self { data, direction, method, trained_on }
    }

    /// The objects, and from which end they are seen.
    pub fn on(&self) -> String {
        format!("{} from {}", self.data, self.direction)
    }

    /// The method and its training data.
    pub fn detector(&self) -> String {
        format!("{} trained on {}", self.method, self.trained_on)
    }
}

/// The rows of each curve, by its name.
pub type RowsOfCurves<'a> = BTreeMap<CurveName, Vec<&'a PartialRow>>;

/// `rows`, curve by curve.
pub fn rows_of_curves(rows: &[PartialRow]) -> RowsOfCurves<'_> {
    let mut curves: RowsOfCurves<'_> = BTreeMap::new();
    for row in rows {
        curves.entry(CurveName::of(row)).or_default().push(row);
    }
    curves
}

/// The differences of all curves of `before` that `after` has, too.
pub fn differences_of_results(before: &[PartialRow], after: &[PartialRow]) -> Vec<PartialDifference> {
    let later = rows_of_curves(after);
    let of_curves = rows_of_curves(before);
    let of_both = of_curves.iter().filter_map(|(name, rows)| Some((name, rows, later.get(name)?)));
    of_both.flat_map(|(name, before, after)| differences(name, before, after)).collect()
}

/// The differences of method `second` from method `first`: where both saw the same objects and were trained on the same. If
/// there is no such pair, they may be trained on anything.
///
/// # Errors
///
/// Why they did not see the same parts, in words.
pub fn differences_of_methods(
    rows: &[PartialRow],
    first: &str,
    second: &str,
) -> Result<Vec<PartialDifference>, String> {
    let curves = rows_of_curves(rows);
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
        let method = format!("{second} − {first}");
        let trained_on = if one.trained_on == other.trained_on {
            one.trained_on.clone()
        } else {
            format!("{} − {}", other.trained_on, one.trained_on)
        };
        let [before, after] = [one, other].map(|it| &curves[it]);
        check_same_parts(before, after).map_err(|reason| format!("{method}: {reason}"))?;
        found.extend(differences(&CurveName { method, trained_on, ..one.clone() }, before, after));
    }
    Ok(found)
}

/// The differences of two curves of the same parts: every metric at every step.
fn differences(curve: &CurveName, before: &[&PartialRow], after: &[&PartialRow]) -> Vec<PartialDifference> {
    let draws = [before, after].map(|it| ObjectDraws::of(&curve.data, it));
    let mut steps: Vec<u32> = before.iter().map(|it| it.step).collect();
    steps.sort_unstable();
    steps.dedup();
    let difference = |of: PartialMetric, step: u32| {
        let [Some(before), Some(after)] = draws.each_ref().map(|it| it.value(of, step)) else { return None };
        let [resampled_before, resampled_after] = draws.each_ref().map(|it| it.resampled(of, step));
        let of_draws = resampled_before.into_iter().zip(resampled_after);
        let blocks = draws[0].blocks(of);
        let (metric, values) = (Metric::Partial(of), [before, after]);
        let difference = PairedDifference::new(&metric, values, of_draws, Some(blocks));
        let (on, detector, slice) = (curve.on(), curve.detector(), format!("step {step}"));
        Some(PartialDifference { on, detector, slice, difference, blocks })
    };
    // Where all objects are of known classes, nothing can be rejected.
    let has_strangers = draws[0].value(PartialMetric::StrangersRejected, steps.first().copied().unwrap_or(0));
    let metrics = PartialMetric::ALL.into_iter();
    let metrics = metrics.filter(|it| *it == PartialMetric::MeanRecall || has_strangers.is_some());
    let difference = &difference;
    metrics.flat_map(|metric| steps.iter().filter_map(move |&step| difference(metric, step))).collect()
}

/// Checks that two curves are of the same parts of the same objects.
///
/// # Errors
///
/// Why they are not, in words.
pub fn check_same_parts(before: &[&PartialRow], after: &[&PartialRow]) -> Result<(), String> {
    let parts = |rows: &[&PartialRow]| -> BTreeMap<(String, u32), (usize, &'static str)> {
        let part = |it: &&PartialRow| ((it.object.clone(), it.step), (it.n_points(), it.true_class.name()));
        rows.iter().map(part).collect()
    };
    let (before, after) = (parts(before), parts(after));
    if let Some((object, step)) = before.keys().find(|it| !after.contains_key(*it)) {
        return Err(format!("step {step} of {object} is only in the earlier one"));
    }
    if let Some((object, step)) = after.keys().find(|it| !before.contains_key(*it)) {
        return Err(format!("step {step} of {object} is only in the later one"));
    }
    let changed = before.iter().find(|(part, facts)| after.get(*part) != Some(*facts));
    changed.map_or(Ok(()), |((object, step), (n_points, class))| {
        Err(format!("{object} at step {step} was a {class} of {n_points} points, and is not any more"))
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::rows::partial_row::Predicted;
    use crate::rows::partial_row::tests::row;
    use crate::vocabulary::partial_class::PartialClass;

    /// Forty trees and forty poles at one step; of each class the first `n_right` are right.
    pub(crate) fn rows(n_right: usize) -> Vec<PartialRow> {
        let classes = [(PartialClass::Tree, Predicted::Pole), (PartialClass::Pole, Predicted::Tree)];
        let rows = classes.into_iter().flat_map(|(class, wrong)| {
            (0..40).map(move |it| {
                let predicted = if it < n_right { class.into() } else { wrong };
                row(class, &format!("{class}-{it:02}"), 1, predicted, [1.0; 4])
            })
        });
        rows.collect()
    }

    fn difference(before: &[PartialRow], after: &[PartialRow]) -> PairedDifference {
        let [only] = &differences_of_results(before, after)[..] else { panic!("one metric at one step") };
        only.difference.clone()
    }

    #[test]
    fn ten_of_eighty_that_are_lost_are_a_sure_loss() {
        let lost = difference(&rows(40), &rows(35));
        assert_eq!((lost.before, lost.after), (1.0, 0.875));
        let [low, high] = lost.interval.unwrap().ends;
        // Of eighty, ten are lost: √(0.125 · 0.875 / 80) is 0.037.
        assert!(
            (low + 0.125 + 0.0725).abs() < 0.015 && (high + 0.125 - 0.0725).abs() < 0.015,
            "{low} {high}"
        );
        assert!(lost.sure_worsening().unwrap() > 0.03 && lost.worsening() == 0.125);
        let same = difference(&rows(35), &rows(35));
        assert_eq!((same.difference(), same.interval.unwrap().ends), (0.0, [0.0, 0.0]));
    }

    #[test]
    fn two_methods_are_compared_where_they_saw_the_same() {
        let mut both = rows(40);
        let mut others = rows(30);
        for it in &mut others {
            "extents".clone_into(&mut it.method);
        }
        both.extend(others);
        let found = differences_of_methods(&both, "graphs", "extents").unwrap();
        let [only] = &found[..] else { panic!("{found:?}") };
        assert_eq!(
            (only.detector.as_str(), only.difference.difference()),
            ("extents − graphs trained on parts", -0.25)
        );
        both.pop();
        let error = differences_of_methods(&both, "graphs", "extents").unwrap_err();
        assert!(error.contains("step 1 of pole-39 is only in the earlier one"), "{error}");
    }
}
