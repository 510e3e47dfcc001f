//! Findings about objects of which more and more is seen, in sentences.

use std::collections::BTreeMap;

use crate::partial_study::partial_curves::{ClassAtStep, PartialCurve};
use crate::rows::partial_row::Predicted;
use crate::run_folder::partial_entry::{PartialEntry, PartialSet};
use crate::vocabulary::partial_class::PartialClass;

/// Changes of the mean of recalls up to this do not count.
const SAME: f64 = 0.02;

/// Whether more points help `method`, as a heading.
pub(crate) fn partial_heading(curves: &[PartialCurve], method: &str) -> &'static str {
    let of_method = curves.iter().filter(|it| it.method == method);
    // How much better the last step is than the first, and than the best.
    let ends: Option<Vec<[f64; 2]>> = of_method
        .map(|curve| {
            let recalls: Vec<f64> = curve.steps.iter().filter_map(|it| it.mean_recall).collect();
            let best = recalls.iter().copied().reduce(f64::max)?;
            Some([recalls.last()? - recalls[0], recalls.last()? - best])
        })
        .collect();
    match ends.as_deref() {
        None | Some([]) => "Recall over the steps",
        Some(ends) if ends.iter().all(|it| it[0] > SAME && it[1] >= -SAME) => "Recall rises as more is seen",
        Some(ends) if ends.iter().all(|it| it[0] < -SAME) => "Recall falls as more is seen",
        Some(ends) if ends.iter().all(|it| it[0].abs() <= SAME) => "Recall does not change as more is seen",
        Some(_) => "Recall does not always rise as more is seen",
    }
}

/// How many objects of each class of `data` were judged.
pub(crate) fn judged_objects(curves: &[PartialCurve], data: &str) -> BTreeMap<PartialClass, u64> {
    let step = curves.iter().find(|it| it.data == data).and_then(|it| it.steps.last());
    step.map_or_else(BTreeMap::new, |it| {
        it.classes.iter().map(|(class, it)| (*class, it.n_objects)).collect()
    })
}

/// The most frequent mistake of `method` when all is seen, objects that were not judged, and classes not learned.
pub fn partial_findings(partial: &PartialEntry, curves: &[PartialCurve], method: &str) -> Vec<String> {
    let confusions = curves.iter().filter(|it| it.method == method).filter_map(confusion);
    confusions.chain(partial.sets.iter().flat_map(|it| about_objects(it, curves))).collect()
}

fn confusion(curve: &PartialCurve) -> Option<String> {
    let step = curve.steps.last()?;
    let of_class = |(class, at_step): (&PartialClass, &ClassAtStep)| {
        let predicted = Predicted::ALL
            .into_iter()
            .zip(at_step.predicted)
            .filter(|(predicted, _)| *predicted != Predicted::from(*class));
        predicted
            .map(|(predicted, n)| {
                (n as f64 / at_step.n_objects as f64, n, at_step.n_objects, *class, predicted)
            })
            .collect()
    };
    let all = step.classes.iter().flat_map(|it| -> Vec<_> { of_class(it) });
    // The first of those that are equal.
    let most = all.reduce(|most, it| if it.0 > most.0 { it } else { most })?;
    let PartialCurve { data, direction, trained_on, .. } = curve;
    let mistake = match most {
        (_, 0, ..) => "every object is right".to_owned(),
        (_, n, of, class, Predicted::NotJudged) => {
            format!("the most frequent fault: {n} of {of} {} show too little to be judged", several(class))
        }
        (_, n, of, class, predicted) => {
            format!(
                "the most frequent mistake: {n} of {of} {} are classified as {}",
                several(class),
                taken_for(predicted)
            )
        }
    };
    Some(format!("{data} from {direction} ({trained_on}), when all is seen, {mistake}."))
}

fn about_objects(set: &PartialSet, curves: &[PartialCurve]) -> Vec<String> {
    let judged = judged_objects(curves, &set.judged.id);
    let classes = PartialClass::ALL.into_iter();
    let sentence = |class: PartialClass| {
        let n_of = |objects: &BTreeMap<String, usize>| objects.get(class.name()).copied().unwrap_or(0);
        let (n, of) = (n_of(&set.judged.objects), &set.judged.id);
        match judged.get(&class) {
            None if n > 0 && class == PartialClass::Other => Some(format!(
                "Not judged: {n} objects of {of} that are none of the learned classes, such as fences. --others judges them, too."
            )),
            None if n > 0 => Some(format!("Not judged: the {n} {} of {of}.", several(class))),
            Some(n) if set.learned_from.as_ref().is_some_and(|it| n_of(&it.objects) == 0) => Some(format!(
                "No {class} was there to learn from: all {n} {} of {of} count as wrong.",
                several(class)
            )),
            _ => None,
        }
    };
    let halves = set
        .halves
        .then(|| format!("Every second object of {} was learned from, and not judged.", set.judged.id));
    classes.filter_map(sentence).chain(halves).collect()
}

/// Objects of `class`.
fn several(class: PartialClass) -> &'static str {
    match class {
        PartialClass::Tree => "trees",
        PartialClass::Car => "cars",
        PartialClass::Pole => "poles",
        PartialClass::Pedestrian => "pedestrians",
        PartialClass::Other => "other objects",
    }
}

fn taken_for(predicted: Predicted) -> &'static str {
    match predicted {
        Predicted::Tree => "trees",
        Predicted::Car => "cars",
        Predicted::Pole => "poles",
        Predicted::Pedestrian => "pedestrians",
        Predicted::NoneOfThese | Predicted::NotJudged => predicted.name(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partial_study::partial_curves::tests::rows;
    use crate::rows::partial_row::PartialRow;
    use crate::rows::partial_row::tests::row;
    use crate::run_folder::partial_entry::tests::entry;

    /// Ten trees, of which so many are right at each step.
    fn curves(n_right: &[usize]) -> Vec<PartialCurve> {
        let tree = |step: usize, it: usize| {
            let predicted = if it < n_right[step] { Predicted::Tree } else { Predicted::Car };
            row(PartialClass::Tree, &format!("tree-{it}"), step as u32 + 1, predicted, [1.0; 4])
        };
        let rows = (0..n_right.len()).flat_map(|step| (0..10).map(move |it| tree(step, it)));
        PartialCurve::all(&rows.collect::<Vec<PartialRow>>())
    }

    #[test]
    fn the_heading_follows_the_curve() {
        let heading = |n_right: &[usize]| partial_heading(&curves(n_right), "graphs");
        assert_eq!(heading(&[2, 5, 9]), "Recall rises as more is seen");
        assert_eq!(heading(&[9, 5, 2]), "Recall falls as more is seen");
        assert_eq!(heading(&[5, 9, 5]), "Recall does not change as more is seen");
        assert_eq!(heading(&[2, 9, 5]), "Recall does not always rise as more is seen");
        assert_eq!(partial_heading(&curves(&[1]), "esf"), "Recall over the steps");
    }

    #[test]
    fn the_confusion_that_matters_is_a_sentence() {
        let found = partial_findings(&entry(), &PartialCurve::all(&rows()), "graphs");
        let said = "street from below (parts), when all is seen, the most frequent mistake: 1 of 1 poles are classified as trees.";
        assert_eq!(found, [said]);
        let found = partial_findings(&entry(), &curves(&[1, 10]), "graphs");
        assert_eq!(found[0], "street from below (parts), when all is seen, every object is right.");
        assert_eq!(found[1], "Not judged: the 1 poles of street.");
    }

    #[test]
    fn objects_that_take_no_part_are_said() {
        let mut entry = entry();
        entry.sets[0].judged.objects.insert("other".to_owned(), 50);
        let mut learned_from = entry.sets[0].judged.clone();
        learned_from.objects.remove("pole");
        (entry.sets[0].learned_from, entry.sets[0].halves) = (Some(learned_from), true);
        let found = partial_findings(&entry, &PartialCurve::all(&rows()), "esf");
        assert_eq!(
            found,
            [
                "No pole was there to learn from: all 1 poles of street count as wrong.",
                "Not judged: 50 objects of street that are none of the learned classes, such as fences. --others judges them, too.",
                "Every second object of street was learned from, and not judged.",
            ]
        );
    }
}
