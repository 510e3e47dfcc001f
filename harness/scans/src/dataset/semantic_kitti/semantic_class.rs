//! Classes of the numbers in SemanticKITTI's labels, and how their points are treated.

use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::class_traits::ClassGroup;

/// Treatment of the points of a label.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SemanticClass {
    /// Each instance is an object. Points of instance 0 belong to objects that were labelled without separating them.
    Object(AnnotationClass),
    /// A pole or sign. Real labels do not separate one from another: connected points become an object.
    Upright,
    /// Road, pavement, ground, buildings: no object.
    Background,
    /// Unlabelled, or something that may or may not be an object of its own: vegetation, trunks, fences, other structures
    /// and objects, whose labels do not separate one from another.
    Unscorable,
    /// As `Unscorable`, for a class whose instances are objects in converted data sets.
    UnscorableUnlessInstance(AnnotationClass),
}

/// The class of the lower 16 bits of a label; `None` if they are not in the format.
///
/// Moving objects have numbers of their own, which are treated like those of resting ones.
pub fn semantic_class(number: u16) -> Option<SemanticClass> {
    use AnnotationClass as Class;
    Some(match number {
        0 | 1 | 52 => SemanticClass::Unscorable,
        51 => SemanticClass::UnscorableUnlessInstance(Class::Fence),
        70 => SemanticClass::UnscorableUnlessInstance(Class::Hedge),
        71 => SemanticClass::UnscorableUnlessInstance(Class::Tree),
        99 => SemanticClass::UnscorableUnlessInstance(Class::StreetFurniture),
        10 | 252 => SemanticClass::Object(Class::Car),
        11 | 15 => SemanticClass::Object(Class::ParkedCycle),
        13 | 257 => SemanticClass::Object(Class::Bus),
        16 | 256 => SemanticClass::Object(Class::Tram),
        18 | 258 => SemanticClass::Object(Class::Truck),
        20 | 259 => SemanticClass::Object(Class::Misc),
        30 | 254 => SemanticClass::Object(Class::Pedestrian),
        31 | 32 | 253 | 255 => SemanticClass::Object(Class::Cyclist),
        40 | 44 | 48 | 49 | 50 | 60 | 72 => SemanticClass::Background,
        80 | 81 => SemanticClass::Upright,
        _ => return None,
    })
}

/// The label of points that are not judged.
pub const UNLABELED_NUMBER: u16 = 0;

/// The label of points of no object, if nothing more is known about them: *other ground*.
pub const BACKGROUND_NUMBER: u16 = 49;

/// The number for objects of `class`.
///
/// Vans become cars, trailers *other vehicle*, street furniture *other object*, hedges *vegetation*, trees *trunk*.
pub fn number_of(class: AnnotationClass) -> u16 {
    use AnnotationClass as Class;
    match class {
        Class::Car | Class::Van => 10,
        Class::ParkedCycle => 11,
        Class::Bus => 13,
        Class::Tram => 16,
        Class::Truck => 18,
        Class::Own(_) => match class.group() {
            Some(ClassGroup::Vehicle) => 20,
            Some(ClassGroup::Person) => 30,
            Some(ClassGroup::Cycle) => 11,
            None => 99,
        },
        Class::Trailer | Class::ConstructionVehicle | Class::Animal | Class::Misc => 20,
        Class::Pedestrian | Class::SittingPerson => 30,
        Class::Cyclist => 31,
        Class::Fence => 51,
        Class::Hedge => 70,
        Class::Tree => 71,
        Class::Pole => 80,
        Class::StreetFurniture => 99,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_is_what_it_is_at_rest() {
        for (at_rest, moving) in
            [(10, 252), (31, 253), (30, 254), (32, 255), (16, 256), (13, 257), (18, 258), (20, 259)]
        {
            assert_eq!(semantic_class(moving), semantic_class(at_rest), "{moving}");
            assert!(matches!(semantic_class(moving), Some(SemanticClass::Object(_))));
        }
    }

    #[test]
    fn the_format_has_34_numbers() {
        let known = (0..=u16::MAX).filter(|&number| semantic_class(number).is_some()).count();
        assert_eq!(known, 34);
        assert_eq!(semantic_class(50), Some(SemanticClass::Background));
        assert_eq!(semantic_class(52), Some(SemanticClass::Unscorable));
        assert_eq!(semantic_class(UNLABELED_NUMBER), Some(SemanticClass::Unscorable));
        assert_eq!(semantic_class(BACKGROUND_NUMBER), Some(SemanticClass::Background));
    }

    #[test]
    fn every_class_has_a_number_that_the_format_knows() {
        for class in AnnotationClass::ALL {
            assert!(semantic_class(number_of(class)).is_some(), "{class:?}");
        }
        assert_eq!(
            semantic_class(number_of(AnnotationClass::Bus)),
            Some(SemanticClass::Object(AnnotationClass::Bus))
        );
    }
}
