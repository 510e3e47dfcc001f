//! How a method classifies objects as more and more of them is seen.

use std::collections::BTreeMap;

use crate::numbers::blocks::Interval;
use crate::partial_study::object_draws::ObjectDraws;
use crate::rows::partial_row::{PartialRow, Predicted};
use crate::vocabulary::metric::PartialMetric;
use crate::vocabulary::partial_class::PartialClass;

/// The objects of one class at one step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ClassAtStep {
    /// Number of objects.
    pub n_objects: u64,
    /// Number of objects that were classified as each of [`Predicted::ALL`].
    pub predicted: [u64; 6],
    /// Sum of the errors to each of [`PartialClass::ALL`], and the number of objects in it.
    errors: [(f64, u64); 5],
}

/// All objects at one step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PartialStep {
    /// Number of the step.
    pub step: u32,
    /// The classes of the objects at this step.
    pub classes: BTreeMap<PartialClass, ClassAtStep>,
    /// The mean of the recalls of the learnt classes.
    pub mean_recall: Option<f64>,
    /// Its interval over objects.
    pub within: Option<Interval>,
    /// Shares classified as none of the learnt classes: of objects of no learnt class and of others; `None` without either.
    pub rejected: Option<[Share; 2]>,
}

/// A share of objects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// The share.
    pub value: f64,
    /// Its interval over objects.
    pub within: Option<Interval>,
}

/// Everything about one method on one data set, seen from one end.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialCurve {
    /// Data set.
    pub data: String,
    /// The end from which objects are seen.
    pub direction: String,
    /// The method.
    pub method: String,
    /// Training data of the method.
    pub trained_on: String,
    /// Steps, ascending.
    pub steps: Vec<PartialStep>,
    /// Mean share of the steps after which an object is right and stays so, over the objects right at the last step.
    pub right_and_kept_from: Option<f64>,
    /// The share of objects of learnt classes that are right at the last step.
    pub right_in_the_end: Option<f64>,
    /// Mean chance, share that was right and number, in bins of the chance of the predicted class: ten less the empty ones.
    pub calibration: Vec<(f64, f64, u64)>,
}

impl ClassAtStep {
    /// The share whose predicted class is right.
    pub fn recall(&self, class: PartialClass) -> Option<f64> {
        let n_right = self.predicted[index_of(Predicted::from(class))];
        (self.n_objects > 0).then(|| n_right as f64 / self.n_objects as f64)
    }

    /// The mean error to `class`.
    pub fn mean_error(&self, class: PartialClass) -> Option<f64> {
        let (sum, n) = self.errors[class_idx(class)];
        (n > 0).then(|| sum / n as f64)
    }

    /// Whether every object had enough points to be judged.
    pub fn are_all_judged(&self) -> bool {
        self.predicted[index_of(Predicted::NotJudged)] == 0
    }

    fn add(&mut self, row: &PartialRow) {
        self.n_objects += 1;
        self.predicted[index_of(row.predicted)] += 1;
        for (sum, error) in self.errors.iter_mut().zip(row.errors()) {
            if let Some(error) = error {
                *sum = (sum.0 + error, sum.1 + 1);
            }
        }
    }
}

fn index_of(predicted: Predicted) -> usize {
    Predicted::ALL.iter().position(|it| *it == predicted).expect("all are listed")
}

fn class_idx(class: PartialClass) -> usize {
    PartialClass::ALL.iter().position(|it| *it == class).expect("all are listed")
}

impl PartialCurve {
    /// The curves of `rows`, in the order of their first row.
    pub fn all(rows: &[PartialRow]) -> Vec<Self> {
        let key = |row: &PartialRow| {
            [&row.data, &row.direction, &row.method, &row.trained_on].map(String::as_str).map(str::to_owned)
        };
        let mut groups: Vec<([String; 4], Vec<&PartialRow>)> = Vec::new();
        let mut index_of_group: BTreeMap<[String; 4], usize> = BTreeMap::new();
        for row in rows {
            let index = *index_of_group.entry(key(row)).or_insert_with(|| {
                groups.push((key(row), Vec::new()));
                groups.len() - 1
            });
            groups[index].1.push(row);
        }
        groups.into_iter().map(|(names, rows)| Self::of(names, &rows)).collect()
    }

    fn of([data, direction, method, trained_on]: [String; 4], rows: &[&PartialRow]) -> Self {
        let mut steps: BTreeMap<u32, PartialStep> = BTreeMap::new();
        for row in rows {
            let step = steps
                .entry(row.step)
                .or_insert_with(|| PartialStep { step: row.step, ..PartialStep::default() });
            step.classes.entry(row.true_class).or_default().add(row);
        }
        let mut steps: Vec<PartialStep> = steps.into_values().collect();
        let draws = ObjectDraws::of(&data, rows);
        for step in &mut steps {
            let share = |metric| {
                let value = draws.value(metric, step.step)?;
                Some(Share { value, within: draws.interval(metric, step.step) })
            };
            let recall = share(PartialMetric::MeanRecall);
            step.mean_recall = recall.map(|it| it.value);
            step.within = recall.and_then(|it| it.within);
            let strangers = share(PartialMetric::StrangersRejected);
            step.rejected =
                strangers.zip(share(PartialMetric::KnownRejected)).map(|(one, other)| [one, other]);
        }
        let (right_and_kept_from, right_in_the_end) = kept(&draws, &steps);
        let calibration = calibration(rows);
        Self {
            data,
            direction,
            method,
            trained_on,
            steps,
            right_and_kept_from,
            right_in_the_end,
            calibration,
        }
    }

    /// The first step at which every object of `class` had enough points to be judged.
    pub fn first_step_all_judged(&self, class: PartialClass) -> Option<u32> {
        let is_whole = |it: &&PartialStep| it.classes.get(&class).is_some_and(ClassAtStep::are_all_judged);
        self.steps.iter().find(is_whole).map(|it| it.step)
    }
}

/// [`PartialCurve::right_and_kept_from`] and [`PartialCurve::right_in_the_end`].
fn kept(draws: &ObjectDraws<'_>, steps: &[PartialStep]) -> (Option<f64>, Option<f64>) {
    let n_steps = steps.len() as f64;
    let (mut kept_from, mut n_objects) = (Vec::new(), 0_u64);
    for (class, predicted_at) in draws.known() {
        n_objects += 1;
        let n_kept = predicted_at.values().rev().take_while(|&&it| it == Predicted::from(*class)).count();
        kept_from.extend((n_kept > 0).then(|| (predicted_at.len() - n_kept + 1) as f64 / n_steps));
    }
    let mean = (!kept_from.is_empty()).then(|| kept_from.iter().sum::<f64>() / kept_from.len() as f64);
    (mean, (n_objects > 0).then(|| kept_from.len() as f64 / n_objects as f64))
}

/// Number of bins of chances.
const N_BINS: usize = 10;

/// [`PartialCurve::calibration`] of `rows`.
fn calibration(rows: &[&PartialRow]) -> Vec<(f64, f64, u64)> {
    let mut bins = [(0.0, 0.0, 0_u64); N_BINS];
    for row in rows.iter().filter(|it| it.predicted != Predicted::NotJudged) {
        let Some(chance) = row.chances().into_iter().flatten().reduce(f64::max) else { continue };
        let bin = &mut bins[((chance * N_BINS as f64) as usize).min(N_BINS - 1)];
        *bin = (bin.0 + chance, bin.1 + f64::from(u8::from(row.is_right())), bin.2 + 1);
    }
    let there = bins.into_iter().filter(|it| it.2 > 0);
    there.map(|(chance, right, n)| (chance / n as f64, right / n as f64, n)).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::rows::partial_row::tests::row;

    /// Two trees and a pole in three steps: one tree is taken for a pole first, the other is not judged.
    pub(crate) fn rows() -> Vec<PartialRow> {
        use PartialClass::{Pole, Tree};
        let tree = |object, step, predicted, own| row(Tree, object, step, predicted, [own, 2.0, 1.0, 2.0]);
        vec![
            tree("a", 1, Predicted::Pole, 1.5),
            tree("a", 2, Predicted::Tree, 0.8),
            tree("a", 3, Predicted::Tree, 0.5),
            tree("b", 1, Predicted::NotJudged, 1.5),
            tree("b", 2, Predicted::Pole, 1.0),
            tree("b", 3, Predicted::Tree, 0.5),
            row(Pole, "c", 1, Predicted::Pole, [2.0, 2.0, 0.5, 2.0]),
            row(Pole, "c", 2, Predicted::Pole, [2.0, 2.0, 0.5, 2.0]),
            row(Pole, "c", 3, Predicted::Tree, [2.0, 2.0, 0.5, 2.0]),
        ]
    }

    #[test]
    fn recalls_errors_and_what_is_kept_are_those_of_the_rows() {
        let curves = PartialCurve::all(&rows());
        let [curve] = &curves[..] else { panic!("{curves:?}") };
        let recalls: Vec<Option<f64>> = curve.steps.iter().map(|it| it.mean_recall).collect();
        assert_eq!(recalls, [Some(0.5), Some(0.75), Some(0.5)]);
        let trees = &curve.steps[1].classes[&PartialClass::Tree];
        assert_eq!(trees.predicted, [1, 0, 1, 0, 0, 0]);
        assert!((trees.mean_error(PartialClass::Tree).unwrap() - 0.9).abs() < 1e-9);
        assert_eq!(trees.mean_error(PartialClass::Other), None);
        assert_eq!(curve.first_step_all_judged(PartialClass::Tree), Some(2));
        assert_eq!(curve.first_step_all_judged(PartialClass::Pole), Some(1));
        // Tree a from step 2 of 3, tree b from step 3; the pole is lost.
        assert!((curve.right_and_kept_from.unwrap() - 5.0 / 6.0).abs() < 1e-9);
        assert!((curve.right_in_the_end.unwrap() - 2.0 / 3.0).abs() < 1e-9);
        // Eight were judged, all with a chance of 0.7, and five of them right.
        let [(chance, right, n)] = curve.calibration[..] else { panic!("{:?}", curve.calibration) };
        assert!((chance - 0.7).abs() < 1e-9 && right == 5.0 / 8.0 && n == 8);
        // Of three objects too many draws lack a class.
        assert_eq!(curve.steps[1].within, None);
    }

    #[test]
    fn the_interval_is_over_objects() {
        let predicted = |it: u32| if it.is_multiple_of(4) { Predicted::Pole } else { Predicted::Tree };
        let tree = |it: u32| row(PartialClass::Tree, &format!("tree-{it}"), 1, predicted(it), [1.0; 4]);
        let rows: Vec<PartialRow> = (0..100).map(tree).collect();
        let [low, high] = PartialCurve::all(&rows)[0].steps[0].within.unwrap().ends;
        // Three quarters, with a standard error of √(0.75 · 0.25 / 100).
        assert!((low - 0.66).abs() < 0.02 && (high - 0.84).abs() < 0.02, "{low} {high}");
    }
}
