//! The difference of two results of `scanbench partial`, or of two methods of one result.

use std::collections::BTreeMap;

use crate::numbers::blocks::Interval;
use crate::partial_study::object_draws::{ObjectDraws, PartialMetric};
use crate::rows::partial_row::{PartialRow, Predicted};
use crate::run_folder::partial_archive::PartialArchive;
use crate::uncertainty::bootstrap::Distribution;
use crate::verdicts::comparability::NotComparable;

/// A number of a method before and after, or of one method and of another.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialDifference {
    /// What it is of.
    pub curve: CurveName,
    /// The step.
    pub step: u32,
    /// What was measured.
    pub metric: PartialMetric,
    /// The share that is compared with.
    pub before: f64,
    /// The share that is compared.
    pub after: f64,
    /// How sure `after` - `before` is: both are of the same resamples of objects. `None` where there are too few.
    pub interval: Option<Interval>,
}

/// A method, the objects that it saw, and from which end.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct CurveName {
    /// Data set.
    pub data: String,
    /// From which end objects are seen.
    pub direction: String,
    /// The method.
    pub method: String,
    /// What it was trained on.
    pub trained_on: String,
}

/// An object whose predicted class changed.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedPrediction {
    /// The method that predicted both.
    pub curve: CurveName,
    /// The object.
    pub object: String,
    /// The step.
    pub step: u32,
    /// The class predicted before.
    pub before: Predicted,
    /// The class predicted now.
    pub after: Predicted,
}

impl CurveName {
    fn of(row: &PartialRow) -> Self {
        Self {
            data: row.data.clone(),
            direction: row.direction.clone(),
            method: row.method.clone(),
            trained_on: row.trained_on.clone(),
        }
    }
}

impl PartialDifference {
    /// `after` - `before`.
    pub fn difference(&self) -> f64 {
        self.after - self.before
    }

    /// How much worse it has become: positive is worse.
    pub fn worsening(&self) -> f64 {
        self.metric.sign_of_worse() * self.difference()
    }

    /// How much worse it has become at least. `None` where nothing is sure.
    pub fn sure_worsening(&self) -> Option<f64> {
        let interval = self.interval.filter(|it| !it.blocks.are_too_few())?;
        interval.ends.map(|it| self.metric.sign_of_worse() * it).into_iter().reduce(f64::min)
    }
}

/// The rows of each curve, by its name.
pub type RowsOfCurves<'a> = BTreeMap<CurveName, Vec<&'a PartialRow>>;

/// The rows of `archive`, curve by curve.
pub fn rows_of_curves(archive: &PartialArchive) -> RowsOfCurves<'_> {
    let mut curves: RowsOfCurves<'_> = BTreeMap::new();
    for row in &archive.rows {
        curves.entry(CurveName::of(row)).or_default().push(row);
    }
    curves
}

/// The differences of two curves of the same parts: every metric at every step.
pub fn differences(
    curve: &CurveName,
    before: &[&PartialRow],
    after: &[&PartialRow],
) -> Vec<PartialDifference> {
    let draws = [before, after].map(|it| ObjectDraws::of(&curve.data, it));
    let mut steps: Vec<u32> = before.iter().map(|it| it.step).collect();
    steps.sort_unstable();
    steps.dedup();
    let difference = |metric: PartialMetric, step: u32| {
        let [Some(before), Some(after)] = draws.each_ref().map(|it| it.value(metric, step)) else {
            return None;
        };
        let [resampled_before, resampled_after] = draws.each_ref().map(|it| it.resampled(metric, step));
        let of_resamples = resampled_before.into_iter().zip(resampled_after);
        let of_resamples = of_resamples.map(|(before, after)| Some(after? - before?));
        let distribution = Distribution::new(of_resamples, draws[0].blocks(metric));
        let interval = distribution.as_ref().map(Distribution::interval);
        Some(PartialDifference { curve: curve.clone(), step, metric, before, after, interval })
    };
    // Nothing is rejected, and nothing can be, where all objects are of known classes.
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

/// Checks that `after` judges what `before` did: the same parts of the same objects, with all its methods.
///
/// # Errors
///
/// [`NotComparable`] with everything that differs.
pub fn check_comparable_results(
    before: &PartialArchive,
    after: &PartialArchive,
) -> Result<(), NotComparable> {
    let facts = |it: &PartialArchive| {
        it.manifest
            .sets
            .iter()
            .map(|it| (it.judged.id.clone(), it.judged.simulation.clone()))
            .collect::<Vec<_>>()
    };
    let (curves_before, curves_after) = (rows_of_curves(before), rows_of_curves(after));
    let mut reasons = Vec::new();
    if facts(before) != facts(after) {
        reasons.push("the objects that are judged are not the same".to_owned());
        return Err(NotComparable { reasons });
    }
    for (name, rows) in &curves_before {
        let CurveName { data, direction, method, trained_on } = name;
        let named = format!("{method} trained on {trained_on}, {data} from {direction}");
        match curves_after.get(name) {
            None => reasons.push(format!("only the earlier one has {named}")),
            Some(theirs) => {
                reasons.extend(check_same_parts(rows, theirs).err().map(|it| format!("{named}: {it}")));
            }
        }
    }
    if curves_before.is_empty() {
        reasons.push("the earlier one has no rows".to_owned());
    }
    if reasons.is_empty() { Ok(()) } else { Err(NotComparable { reasons }) }
}

/// The objects whose predicted class differs between curves of the two results.
pub fn changed_predictions(before: &PartialArchive, after: &PartialArchive) -> Vec<ChangedPrediction> {
    let later = rows_of_curves(after);
    let mut changed = Vec::new();
    for (curve, rows) in rows_of_curves(before) {
        let predicted: BTreeMap<(&str, u32), Predicted> = later
            .get(&curve)
            .into_iter()
            .flatten()
            .map(|it| ((it.object.as_str(), it.step), it.predicted))
            .collect();
        changed.extend(rows.iter().filter_map(|row| {
            let after = *predicted.get(&(row.object.as_str(), row.step))?;
            let (curve, object, step) = (curve.clone(), row.object.clone(), row.step);
            (after != row.predicted).then_some(ChangedPrediction {
                curve,
                object,
                step,
                before: row.predicted,
                after,
            })
        }));
    }
    changed
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::rows::partial_row::tests::row;
    use crate::run_folder::partial_manifest::tests::manifest;
    use crate::vocabulary::partial_class::PartialClass;

    /// Forty trees and forty poles at one step; of each class the first `n_right` are right.
    pub(crate) fn archive(n_right: usize) -> PartialArchive {
        let classes = [(PartialClass::Tree, Predicted::Pole), (PartialClass::Pole, Predicted::Tree)];
        let rows = classes.into_iter().flat_map(|(class, wrong)| {
            (0..40).map(move |it| {
                let predicted = if it < n_right { class.into() } else { wrong };
                row(class, &format!("{class}-{it:02}"), 1, predicted, [1.0; 4])
            })
        });
        PartialArchive { manifest: manifest(), rows: rows.collect() }
    }

    fn difference(before: &PartialArchive, after: &PartialArchive) -> PartialDifference {
        let (before, after) = (rows_of_curves(before), rows_of_curves(after));
        let (name, rows) = before.first_key_value().unwrap();
        let [only] = &differences(name, rows, &after[name])[..] else { panic!("one metric at one step") };
        only.clone()
    }

    #[test]
    fn ten_of_eighty_that_are_lost_are_a_sure_loss() {
        let lost = difference(&archive(40), &archive(35));
        assert_eq!((lost.before, lost.after), (1.0, 0.875));
        let [low, high] = lost.interval.unwrap().ends;
        // Of eighty, ten are lost: √(0.125 · 0.875 / 80) is 0.037.
        assert!(
            (low + 0.125 + 0.0725).abs() < 0.015 && (high + 0.125 - 0.0725).abs() < 0.015,
            "{low} {high}"
        );
        assert!(lost.sure_worsening().unwrap() > 0.03 && lost.worsening() == 0.125);
        let same = difference(&archive(35), &archive(35));
        assert_eq!((same.difference(), same.interval.unwrap().ends), (0.0, [0.0, 0.0]));
    }

    #[test]
    fn every_object_whose_predicted_class_changed_is_named() {
        let changed = changed_predictions(&archive(40), &archive(39));
        let names: Vec<&str> = changed.iter().map(|it| it.object.as_str()).collect();
        assert_eq!(names, ["tree-39", "pole-39"]);
        assert_eq!(
            (changed[0].before, changed[0].after, changed[0].step),
            (Predicted::Tree, Predicted::Pole, 1)
        );
        assert!(changed_predictions(&archive(3), &archive(3)).is_empty());
    }

    #[test]
    fn other_objects_parts_and_methods_cannot_be_compared() {
        let check = |change: &dyn Fn(&mut PartialArchive), message: &str| {
            let mut after = archive(40);
            change(&mut after);
            let error = check_comparable_results(&archive(40), &after).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        };
        assert_eq!(check_comparable_results(&archive(40), &archive(3)), Ok(()));
        check(
            &|it| it.manifest.sets[0].judged.id = "another".to_owned(),
            "objects that are judged are not the same",
        );
        check(&|it| it.rows.truncate(79), "step 1 of pole-39 is only in the earlier one");
        check(
            &|it| it.rows.iter_mut().for_each(|it| it.method = "other".to_owned()),
            "only the earlier one has graphs",
        );
        check(
            &|it| it.rows[0].true_class = PartialClass::Car,
            "tree-00 at step 1 was a tree of 9 points, and is not any more",
        );
        let mut before = archive(40);
        before.rows.clear();
        assert!(check_comparable_results(&before, &archive(40)).is_err());
    }
}
