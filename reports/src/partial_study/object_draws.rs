//! Numbers of the partial study over resamples of its objects.

use std::collections::BTreeMap;

use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
use crate::rows::partial_row::{PartialRow, Predicted};
use crate::uncertainty::bootstrap::{Distribution, N_RESAMPLES, Resamples};
use crate::vocabulary::metric::PartialMetric;
use crate::vocabulary::partial_class::PartialClass;

/// The predicted classes of objects at every step, by one method, seen from one end.
#[derive(Debug)]
pub struct ObjectDraws<'a> {
    known: Drawn<'a>,
    strangers: Drawn<'a>,
}

/// The true class of one object, and its predicted class at each step.
type PredictedAt = (PartialClass, BTreeMap<u32, Predicted>);

#[derive(Debug)]
struct Drawn<'a> {
    objects: BTreeMap<&'a str, PredictedAt>,
    resamples: Resamples,
}

impl<'a> ObjectDraws<'a> {
    /// The draws of `rows`, all of one method and direction. They depend on the objects of `data` alone, not on their
    /// predicted classes.
    pub fn of(data: &str, rows: &[&'a PartialRow]) -> Self {
        let is_known = |it: &&PartialRow| PartialClass::LEARNT.contains(&it.true_class);
        let (known, strangers): (Vec<&PartialRow>, Vec<&PartialRow>) =
            rows.iter().copied().partition(is_known);
        Self { known: Drawn::of(data, &known), strangers: Drawn::of(data, &strangers) }
    }

    /// The objects of learnt classes, by name.
    pub fn known(&self) -> impl Iterator<Item = &PredictedAt> {
        self.known.objects.values()
    }

    /// The value of `metric` at `step`; `None` without objects that it counts.
    pub fn value(&self, metric: PartialMetric, step: u32) -> Option<f64> {
        let ratios: Vec<f64> = self
            .terms(metric, step)
            .iter()
            .map(|it| it.iter().fold([0.0, 0.0], |sum: [f64; 2], it| [sum[0] + it[0], sum[1] + it[1]]))
            .map(|[numerator, denominator]| numerator / denominator)
            .collect();
        (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64)
    }

    /// The value of `metric` at `step` in every resample; `None` where a resample lacks a class.
    pub fn resampled(&self, metric: PartialMetric, step: u32) -> Vec<Option<f64>> {
        let of_classes: Vec<Vec<[f64; 2]>> = self
            .terms(metric, step)
            .iter()
            .map(|terms| {
                let mut resampled = vec![[0.0, 0.0]; N_RESAMPLES];
                self.drawn(metric).resamples.add_terms(terms, &mut resampled);
                resampled
            })
            .collect();
        let mean = |resample: usize| {
            let ratio =
                |it: &Vec<[f64; 2]>| (it[resample][1] > 0.0).then(|| it[resample][0] / it[resample][1]);
            let ratios: Option<Vec<f64>> = of_classes.iter().map(ratio).collect();
            ratios.filter(|it| !it.is_empty()).map(|it| it.iter().sum::<f64>() / it.len() as f64)
        };
        (0..N_RESAMPLES).map(mean).collect()
    }

    /// The interval of `metric` at `step` over resamples of objects.
    pub fn interval(&self, metric: PartialMetric, step: u32) -> Option<Interval> {
        let resampled = self.resampled(metric, step);
        Some(Distribution::new(resampled.into_iter(), self.blocks(metric))?.interval())
    }

    /// The objects that are drawn for `metric`, counted.
    pub fn blocks(&self, metric: PartialMetric) -> BlockCount {
        self.drawn(metric).resamples.blocks()
    }

    fn drawn(&self, metric: PartialMetric) -> &Drawn<'a> {
        if metric == PartialMetric::StrangersRejected { &self.strangers } else { &self.known }
    }

    /// For each class that the metric is a mean over: numerator and denominator for every object, in their order.
    fn terms(&self, metric: PartialMetric, step: u32) -> Vec<Vec<[f64; 2]>> {
        let objects = &self.drawn(metric).objects;
        let of = |counts: &dyn Fn(PartialClass) -> bool,
                  is_right: &dyn Fn(PartialClass, Predicted) -> bool| {
            let term = |(class, predicted_at): &PredictedAt| match predicted_at.get(&step) {
                Some(&predicted) if counts(*class) => [f64::from(u8::from(is_right(*class, predicted))), 1.0],
                _ => [0.0, 0.0],
            };
            objects.values().map(term).collect::<Vec<[f64; 2]>>()
        };
        let is_none = |_: PartialClass, predicted: Predicted| predicted == Predicted::NoneOfThese;
        let of_groups = match metric {
            PartialMetric::MeanRecall => PartialClass::LEARNT
                .map(|class| of(&|it| it == class, &|it, predicted| predicted == Predicted::from(it)))
                .to_vec(),
            PartialMetric::StrangersRejected | PartialMetric::KnownRejected => vec![of(&|_| true, &is_none)],
        };
        of_groups.into_iter().filter(|it| it.iter().any(|it| it[1] > 0.0)).collect()
    }
}

impl<'a> Drawn<'a> {
    fn of(data: &str, rows: &[&'a PartialRow]) -> Self {
        let mut objects: BTreeMap<&str, PredictedAt> = BTreeMap::new();
        for row in rows {
            let object = objects.entry(&row.object).or_insert_with(|| (row.true_class, BTreeMap::new()));
            object.1.insert(row.step, row.predicted);
        }
        let blocks = BlockCount::of_dataset(objects.len() as u64, BlockKind::Objects);
        Self { resamples: Resamples::draw(data, blocks), objects }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::partial_row::tests::row;
    use proptest::prelude::*;

    fn object(class: PartialClass, number: usize, predicted: Predicted) -> PartialRow {
        row(class, &format!("{class}-{number}"), 1, predicted, [1.0; 4])
    }

    #[test]
    fn shares_of_strangers_and_of_known_objects_are_counted_separately() {
        use PartialClass::{Other, Pole, Tree};
        let rows = [
            object(Tree, 1, Predicted::Tree),
            object(Tree, 2, Predicted::NoneOfThese),
            object(Pole, 1, Predicted::Pole),
            object(Pole, 2, Predicted::Tree),
            object(Other, 1, Predicted::NoneOfThese),
            object(Other, 2, Predicted::Car),
            object(Other, 3, Predicted::NoneOfThese),
        ];
        let draws = ObjectDraws::of("street", &rows.iter().collect::<Vec<_>>());
        let value = |metric| draws.value(metric, 1).unwrap();
        assert_eq!(value(PartialMetric::MeanRecall), 0.5);
        assert!((value(PartialMetric::StrangersRejected) - 2.0 / 3.0).abs() < 1e-12);
        assert_eq!(value(PartialMetric::KnownRejected), 0.25);
        assert_eq!(draws.value(PartialMetric::MeanRecall, 2), None);
        assert_eq!(draws.blocks(PartialMetric::StrangersRejected).n_blocks, 3);
        let none = ObjectDraws::of("street", &[]);
        assert!(
            PartialMetric::ALL
                .iter()
                .all(|it| none.value(*it, 1).is_none() && none.interval(*it, 1).is_none())
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20))]
        #[test]
        fn numbers_lie_in_their_intervals_and_between_0_and_1(predicted in prop::collection::vec(0_usize..6, 12..40)) {
            let classes = [PartialClass::Tree, PartialClass::Other];
            let rows: Vec<PartialRow> = predicted
                .iter()
                .enumerate()
                .map(|(it, predicted)| object(classes[it % 2], it, Predicted::ALL[*predicted]))
                .collect();
            let draws = ObjectDraws::of("street", &rows.iter().collect::<Vec<_>>());
            for metric in PartialMetric::ALL {
                let value = draws.value(metric, 1).unwrap();
                let [low, high] = draws.interval(metric, 1).unwrap().ends;
                prop_assert!(0.0 <= low && low <= value && value <= high && high <= 1.0, "{low} {value} {high}");
            }
        }
    }
}
