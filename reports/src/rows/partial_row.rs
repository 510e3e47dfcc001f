//! `partial.csv`: the predicted classes of partly seen objects.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::vocabulary::partial_class::PartialClass;

/// The predicted class of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Predicted {
    /// A tree.
    Tree,
    /// A car.
    Car,
    /// A pole.
    Pole,
    /// A person on foot.
    Pedestrian,
    /// None of these.
    NoneOfThese,
    /// Too little was seen to predict a class.
    NotJudged,
}

impl Predicted {
    /// All, in the order in which tables list them.
    pub const ALL: [Self; 6] =
        [Self::Tree, Self::Car, Self::Pole, Self::Pedestrian, Self::NoneOfThese, Self::NotJudged];

    /// The name used in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::Car => "car",
            Self::Pole => "pole",
            Self::Pedestrian => "pedestrian",
            Self::NoneOfThese => "none of these",
            Self::NotJudged => "not judged",
        }
    }
}

impl From<PartialClass> for Predicted {
    /// The right prediction for an object of this class.
    fn from(class: PartialClass) -> Self {
        match class {
            PartialClass::Tree => Self::Tree,
            PartialClass::Car => Self::Car,
            PartialClass::Pole => Self::Pole,
            PartialClass::Pedestrian => Self::Pedestrian,
            PartialClass::Other => Self::NoneOfThese,
        }
    }
}

/// A partly seen object: its class, and how much of it had been seen.
#[derive(Debug, Clone, PartialEq)]
pub struct SeenPart<'a> {
    /// Data set.
    pub data: &'a str,
    /// The object, unique in its data set.
    pub object: &'a str,
    /// From which end it is seen: `below`, `above`, or `drive` as it was driven toward.
    pub direction: &'a str,
    /// Number of the step, from 1.
    pub step: u32,
    /// Its class.
    pub class: PartialClass,
    /// Number of points that had been seen.
    pub n_points: usize,
    /// The share of all its points that had been seen.
    pub share_of_points: f64,
}

/// Values for each of [`PartialClass::ALL`]; `None` for classes that the method does not know.
pub type OfClasses = [Option<f64>; 5];

/// The answer of a method for a part of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Its predicted class.
    pub predicted: Predicted,
    /// L1 distance to each class; all `None` for methods without distances, and where there is nothing to judge by.
    pub errors: OfClasses,
    /// The chance of each class.
    pub chances: OfClasses,
}

row! {
    /// A row of `partial.csv`.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct PartialRow {
        pub(crate) data: String,
        pub(crate) object: String,
        pub(crate) direction: String,
        pub(crate) step: u32,
        pub(crate) method: String,
        pub(crate) trained_on: String,
        pub(crate) true_class: PartialClass,
        pub(crate) predicted: Predicted,
        n_points: usize,
        share_of_points: Fixed<4>,
        error_tree: Option<Fixed<5>>,
        error_car: Option<Fixed<5>>,
        error_pole: Option<Fixed<5>>,
        error_pedestrian: Option<Fixed<5>>,
        error_other: Option<Fixed<5>>,
        chance_tree: Option<Fixed<5>>,
        chance_car: Option<Fixed<5>>,
        chance_pole: Option<Fixed<5>>,
        chance_pedestrian: Option<Fixed<5>>,
        chance_other: Option<Fixed<5>>,
    }
}

impl PartialRow {
    /// The row with the answer of `method`, trained on `trained_on` clouds, for `part`.
    pub fn new(part: &SeenPart<'_>, method: &str, trained_on: &str, answer: &Answer) -> Self {
        let [error_tree, error_car, error_pole, error_pedestrian, error_other] =
            answer.errors.map(|it| it.map(Fixed));
        let [chance_tree, chance_car, chance_pole, chance_pedestrian, chance_other] =
            answer.chances.map(|it| it.map(Fixed));
        Self {
            data: part.data.to_owned(),
            object: part.object.to_owned(),
            direction: part.direction.to_owned(),
            step: part.step,
            method: method.to_owned(),
            trained_on: trained_on.to_owned(),
            true_class: part.class,
            predicted: answer.predicted,
            n_points: part.n_points,
            share_of_points: Fixed(part.share_of_points),
            error_tree,
            error_car,
            error_pole,
            error_pedestrian,
            error_other,
            chance_tree,
            chance_car,
            chance_pole,
            chance_pedestrian,
            chance_other,
        }
    }

    /// The row with the answer of another method for the same part.
    pub fn predicted_by(&self, method: &str, trained_on: &str, answer: &Answer) -> Self {
        let part = SeenPart {
            data: &self.data,
            object: &self.object,
            direction: &self.direction,
            step: self.step,
            class: self.true_class,
            n_points: self.n_points,
            share_of_points: self.share_of_points.0,
        };
        Self::new(&part, method, trained_on, answer)
    }

    /// The method.
    pub fn method(&self) -> &str {
        &self.method
    }

    /// Whether both are of the same data set, and from the same method trained on the same clouds.
    pub fn is_of_same_answers(&self, other: &Self) -> bool {
        (&self.data, &self.method, &self.trained_on) == (&other.data, &other.method, &other.trained_on)
    }

    /// How many points had been seen.
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// L1 distance to each class.
    pub fn errors(&self) -> OfClasses {
        [self.error_tree, self.error_car, self.error_pole, self.error_pedestrian, self.error_other]
            .map(|it| it.map(|it| it.0))
    }

    /// The chance of each class.
    pub fn chances(&self) -> OfClasses {
        [self.chance_tree, self.chance_car, self.chance_pole, self.chance_pedestrian, self.chance_other]
            .map(|it| it.map(|it| it.0))
    }

    /// Whether the predicted class is the true one.
    pub fn is_right(&self) -> bool {
        self.predicted == Predicted::from(self.true_class)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::files::csv_rows::to_csv_bytes;

    /// A row of our method.
    pub(crate) fn row(
        class: PartialClass,
        object: &str,
        step: u32,
        predicted: Predicted,
        errors: [f64; 4],
    ) -> PartialRow {
        let part = SeenPart {
            data: "street",
            object,
            direction: "below",
            step,
            class,
            n_points: 9,
            share_of_points: 0.5,
        };
        let [a, b, c, d] = errors.map(Some);
        let chances = [Some(0.7), Some(0.1), Some(0.1), Some(0.1), None];
        PartialRow::new(&part, "graphs", "parts", &Answer { predicted, errors: [a, b, c, d, None], chances })
    }

    #[test]
    fn a_row_comes_back_from_its_file() {
        let rows = [row(PartialClass::Tree, "tree-1", 3, Predicted::NotJudged, [0.5, 1.0, 1.25, 2.0])];
        let text = String::from_utf8(to_csv_bytes(&rows).unwrap()).unwrap();
        let expected = "street,tree-1,below,3,graphs,parts,tree,not-judged,9,0.5000,\
                        0.50000,1.00000,1.25000,2.00000,,0.70000,0.10000,0.10000,0.10000,\n";
        assert!(text.ends_with(expected), "{text}");
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        assert_eq!(reader.deserialize::<PartialRow>().next().unwrap().unwrap(), rows[0]);
    }

    #[test]
    fn what_is_none_of_these_is_right_for_others_alone() {
        assert!(row(PartialClass::Other, "fence", 1, Predicted::NoneOfThese, [1.0; 4]).is_right());
        assert!(!row(PartialClass::Car, "car", 1, Predicted::NoneOfThese, [1.0; 4]).is_right());
    }
}
