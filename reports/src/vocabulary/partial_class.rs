//! The classes that a partly seen object can have.

use super::class::AnnotationClass;
use super::named::named;

named! {
    /// What an object is, of which a part has been seen. Paper: BG section 4.
    pub enum PartialClass {
        /// Trunk and crown of a tree.
        Tree = "tree",
        /// Passenger car or van.
        Car = "car",
        /// Pole, lamp post, traffic light, sign or bollard.
        Pole = "pole",
        /// Person on foot.
        Pedestrian = "pedestrian",
        /// None of these: fences, hedges, street furniture, trucks, cyclists and the like.
        Other = "other",
    }
}

impl PartialClass {
    /// The learnt classes, in the order of [`Self::ALL`].
    pub const LEARNT: [Self; 4] = [Self::Tree, Self::Car, Self::Pole, Self::Pedestrian];

    /// The class of an object that is annotated as `class`.
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
            | AnnotationClass::ConstructionVehicle
            | AnnotationClass::Animal
            | AnnotationClass::Hedge
            | AnnotationClass::Fence
            | AnnotationClass::StreetFurniture
            | AnnotationClass::Misc
            | AnnotationClass::Own(_) => Self::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_but_none_of_these_is_learnt() {
        assert!(
            PartialClass::ALL.into_iter().filter(|it| *it != PartialClass::Other).eq(PartialClass::LEARNT)
        );
    }
}
