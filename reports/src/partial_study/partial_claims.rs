//! Claims of the paper about partial clouds, and whether they hold.

use serde::{Deserialize, Serialize};

use crate::partial_study::partial_curves::{PartialCurve, PartialStep};
use crate::rows::partial_row::Predicted;
use crate::vocabulary::partial_class::PartialClass;

/// A claim of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PartialClaim {
    /// Trees are classified as poles until the crown shows.
    PolesFirst,
    /// From step 5 on every class is nearest to itself on average.
    RightOnAverage,
    /// The more is seen, the better the decision.
    EverBetter,
}

/// Result of a claim on measured rows.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredClaim {
    /// Whether the claim holds; `None` if the rows cannot decide it.
    pub holds: Option<bool>,
    /// The numbers behind this, in words.
    pub number: String,
}

/// First step that counts as late in the claims.
const LATE: u32 = 5;
/// Last step at which only the trunk is seen from below.
const TRUNK_ALONE: u32 = 3;

impl PartialClaim {
    /// All claims, in the order of BG section 4.
    pub const ALL: [Self; 3] = [Self::PolesFirst, Self::RightOnAverage, Self::EverBetter];

    /// The claim in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::PolesFirst => "trees are taken for poles until the crown shows",
            Self::RightOnAverage => "from step 5 on every class is right on average",
            Self::EverBetter => "the more is seen, the better the decision",
        }
    }

    /// Result of the claim on one curve.
    pub fn measured(self, curve: &PartialCurve) -> MeasuredClaim {
        let (holds, number) = match self {
            Self::PolesFirst => trees_are_poles_first(curve),
            Self::RightOnAverage => right_on_average(curve),
            Self::EverBetter => ever_better(curve),
        };
        MeasuredClaim { holds, number }
    }
}

fn trees_are_poles_first(curve: &PartialCurve) -> (Option<bool>, String) {
    let share = |is_asked: &dyn Fn(u32) -> bool| {
        let trees = curve
            .steps
            .iter()
            .filter(|it| is_asked(it.step))
            .filter_map(|it| it.classes.get(&PartialClass::Tree));
        let pole = Predicted::ALL.iter().position(|it| *it == Predicted::Pole)?;
        let (predicted, n) =
            trees.fold((0, 0), |(predicted, n), it| (predicted + it.predicted[pole], n + it.n_objects));
        (n > 0).then(|| predicted as f64 / n as f64)
    };
    let early = share(&|step| step <= TRUNK_ALONE);
    let late = share(&|step| step >= LATE);
    match early.zip(late) {
        Some((early, late)) => (
            Some(early > 0.0 && early > 2.0 * late),
            format!(
                "{:.1} % of trees at steps 1 to {TRUNK_ALONE} and {:.1} % from step {LATE} on are taken for poles",
                100.0 * early,
                100.0 * late
            ),
        ),
        None => (None, "there are no trees at these steps".to_owned()),
    }
}

/// The classes whose mean error to themselves is not the least at a step; `None` if no errors are known.
fn wrong_on_average(step: &PartialStep) -> Option<Vec<PartialClass>> {
    let mut wrong = Vec::new();
    let mut is_known = false;
    for class in PartialClass::LEARNT {
        let Some(at_step) = step.classes.get(&class) else { continue };
        let Some(own) = at_step.mean_error(class) else { continue };
        is_known = true;
        let others = PartialClass::LEARNT.into_iter().filter(|it| *it != class);
        if others.filter_map(|it| at_step.mean_error(it)).any(|it| it <= own) {
            wrong.push(class);
        }
    }
    is_known.then_some(wrong)
}

fn right_on_average(curve: &PartialCurve) -> (Option<bool>, String) {
    let late = curve.steps.iter().filter(|it| it.step >= LATE);
    let wrong: Vec<String> = late
        .clone()
        .filter_map(|it| Some((it.step, wrong_on_average(it)?)))
        .flat_map(|(step, classes)| {
            classes.into_iter().map(move |it| format!("{} at step {step}", it.name()))
        })
        .collect();
    let is_known = late.clone().any(|it| wrong_on_average(it).is_some());
    let number = match (is_known, &wrong[..]) {
        (false, _) => "the method has no errors to classes".to_owned(),
        (true, []) => format!("from step {LATE} on each class is nearest to itself on average"),
        (true, wrong) => format!("{} means are nearest to another class: {}", wrong.len(), wrong.join(", ")),
    };
    (is_known.then_some(wrong.is_empty()), number)
}

fn ever_better(curve: &PartialCurve) -> (Option<bool>, String) {
    let recalls: Vec<f64> = curve.steps.iter().filter_map(|it| it.mean_recall).collect();
    let falls: Vec<f64> = recalls.windows(2).map(|it| it[0] - it[1]).filter(|it| *it > 0.0).collect();
    let largest = falls.iter().copied().fold(0.0, f64::max);
    let number = match recalls[..] {
        [] => "nothing was judged".to_owned(),
        [first, ..] => format!(
            "the mean of recalls goes from {:.1} to {:.1} % and falls {} times, by {:.1} points at most",
            100.0 * first,
            100.0 * recalls[recalls.len() - 1],
            falls.len(),
            100.0 * largest
        ),
    };
    ((recalls.len() > 1).then_some(falls.is_empty()), number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partial_study::partial_curves::tests::rows;
    use crate::rows::partial_row::tests::row;

    fn claims(curve: &PartialCurve) -> [MeasuredClaim; 3] {
        PartialClaim::ALL.map(|it| it.measured(curve))
    }

    #[test]
    fn what_rows_cannot_decide_is_none_and_falls_are_counted() {
        let [trees, average, better] = claims(&PartialCurve::all(&rows())[0]);
        assert_eq!((trees.holds, average.holds, better.holds), (None, None, Some(false)));
        assert!(better.number.contains("falls 1 times, by 25.0 points"), "{}", better.number);
    }

    #[test]
    fn claims_hold_where_numbers_say_so() {
        let tree = |step, predicted, own| row(PartialClass::Tree, "a", step, predicted, [own, 2.0, 1.0, 2.0]);
        let rows =
            [tree(1, Predicted::Pole, 2.0), tree(5, Predicted::Tree, 0.5), tree(6, Predicted::Tree, 0.5)];
        assert_eq!(claims(&PartialCurve::all(&rows)[0]).map(|it| it.holds), [Some(true); 3]);
        let rows = [tree(1, Predicted::Tree, 0.5), tree(5, Predicted::Tree, 1.5)];
        let found = claims(&PartialCurve::all(&rows)[0]);
        assert_eq!(found.each_ref().map(|it| it.holds), [Some(false), Some(false), Some(true)]);
        assert!(found[1].number.contains("tree at step 5"), "{}", found[1].number);
    }
}
