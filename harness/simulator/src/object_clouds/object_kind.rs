//! An object of each class.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::partial_class::PartialClass;

use super::person_kind::any_person;
use super::pole_kind::any_pole;
use super::tree_kind::any_tree;
use crate::fleet::TOWN;
use crate::furniture_shape::{advertising_column, bench, bin, fence, mail_box};
use crate::object_shape::ObjectShape;
use crate::person_shape::parked_bicycle;
use crate::vegetation_shape::{bush, hedge, shrub};

/// Draws an object of `class`.
pub fn any_object(class: PartialClass, rng: &mut ChaCha8Rng) -> ObjectShape {
    match class {
        PartialClass::Tree => any_tree(rng),
        PartialClass::Car => TOWN.parked(rng),
        PartialClass::Pole => any_pole(rng),
        PartialClass::Pedestrian => any_person(rng),
        PartialClass::Other => any_other(rng),
    }
}

/// Fences and hedges above all, and other things on pavements.
fn any_other(rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(2.0_f32..12.0);
    match rng.random_range(0..100_u32) {
        0..35 => fence(length_m, rng),
        35..65 => hedge(length_m, rng),
        65..75 => bush(rng),
        75..80 => shrub(rng),
        80..85 => bin(rng),
        85..89 => mail_box(rng),
        89..93 => bench(rng),
        93..97 => advertising_column(rng),
        _ => parked_bicycle(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use reports::vocabulary::class::AnnotationClass;

    #[test]
    fn objects_are_of_the_class_that_was_asked_for() {
        let mut rng = ChaCha8Rng::from_seed([4; 32]);
        for class in PartialClass::ALL {
            for _ in 0..100 {
                let found = any_object(class, &mut rng).class;
                let is_expected = match class {
                    PartialClass::Tree => found == AnnotationClass::Tree,
                    PartialClass::Car => matches!(found, AnnotationClass::Car | AnnotationClass::Van),
                    PartialClass::Pole => found == AnnotationClass::Pole,
                    PartialClass::Pedestrian => found == AnnotationClass::Pedestrian,
                    PartialClass::Other => PartialClass::of_annotation(found) == PartialClass::Other,
                };
                assert!(is_expected, "{class}: {found:?}");
            }
        }
    }
}
