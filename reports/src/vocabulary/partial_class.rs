//! The classes that a partly seen object can have.

use serde::{Deserialize, Serialize};

use super::class::AnnotationClass;

/// What an object is, of which a part has been seen. Paper: BG section 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartialClass {
    /// Trunk and crown of a tree.
    Tree,
    /// Passenger car or van.
    Car,
    /// Pole, lamp post, traffic light, sign or bollard.
    Pole,
    /// Person on foot.
    Pedestrian,
    /// None of these: fences, hedges, street furniture, trucks, cyclists and the like.
    Other,
}

impl PartialClass {
    /// All, in the order in which tables list them.
    pub const ALL: [Self; 5] = [Self::Tree, Self::Car, Self::Pole, Self::Pedestrian, Self::Other];

    /// Those that are learnt, in the order of [`Self::ALL`].
    pub const LEARNT: [Self; 4] = [Self::Tree, Self::Car, Self::Pole, Self::Pedestrian];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::Car => "car",
            Self::Pole => "pole",
            Self::Pedestrian => "pedestrian",
            Self::Other => "other",
        }
    }

    /// What an object is that people annotate as `class`.
    pub fn of_annotation(class: AnnotationClass) -> Self {
        match class {
            AnnotationClass::Tree => Self::Tree,
            AnnotationClass::Car | AnnotationClass::Van => Self::Car,
            AnnotationClass::Pole => Self::Pole,
            AnnotationClass::Pedestrian => Self::Pedestrian,
            AnnotationClass::Truck
            | AnnotationClass::Bus
            | AnnotationClass::SittingPerson
            | AnnotationClass::Cyclist
            | AnnotationClass::ParkedCycle
            | AnnotationClass::Tram
            | AnnotationClass::Trailer
            | AnnotationClass::Hedge
            | AnnotationClass::Fence
            | AnnotationClass::StreetFurniture
            | AnnotationClass::Misc => Self::Other,
        }
    }

    /// The class of this name; `None` if there is none.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

impl std::fmt::Display for PartialClass {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn classes_are_read_by_the_names_they_are_written_with() {
        check_names(&PartialClass::ALL, PartialClass::name);
        assert_eq!(PartialClass::from_name("pedestrian"), Some(PartialClass::Pedestrian));
        assert_eq!(PartialClass::from_name("Tree"), None);
    }

    #[test]
    fn everything_but_none_of_these_is_learnt() {
        assert!(
            PartialClass::ALL.into_iter().filter(|it| *it != PartialClass::Other).eq(PartialClass::LEARNT)
        );
    }
}
