//! Meanings of the numbers of SemanticKITTI's labels for the scores.
//!
//! A label has the number of its class in the lower half and that of its instance in the upper. Source of the numbers:
//! semantic-kitti-api, `config/semantic-kitti.yaml`.

use reports::vocabulary::ground_definition::GroundDefinition;
use reports::vocabulary::thing_class::ThingClass;

/// The class of a label.
pub fn class_number(label: u32) -> u16 {
    label as u16
}

/// The instance of a label, 0 for none.
pub fn instance_number(label: u32) -> u16 {
    (label >> 16) as u16
}

/// Whether points of this class are left out of all scores of instances: unlabelled points, outliers, other structures and
/// objects, and numbers that the format does not have.
///
/// Source: number 0 of `learning_map`.
pub fn is_left_out(number: u16) -> bool {
    !matches!(
        number,
        10 | 11 | 13 | 15 | 16 | 18 | 20 | 30..=32 | 40 | 44 | 48..=51 | 60 | 70..=72 | 80 | 81 | 252..=259
    )
}

/// The class of things of a number; `None` if it is no thing. Moving things have the class of resting ones.
///
/// Source: numbers 1 to 8 of `learning_map`.
pub fn thing_class(number: u16) -> Option<ThingClass> {
    Some(match number {
        10 | 252 => ThingClass::Car,
        11 => ThingClass::Bicycle,
        15 => ThingClass::Motorcycle,
        18 | 258 => ThingClass::Truck,
        13 | 16 | 20 | 256 | 257 | 259 => ThingClass::OtherVehicle,
        30 | 254 => ThingClass::Person,
        31 | 253 => ThingClass::Bicyclist,
        32 | 255 => ThingClass::Motorcyclist,
        _ => return None,
    })
}

/// Whether a class is the surface of the ground, in all definitions.
pub fn is_surface(number: u16) -> bool {
    matches!(number, 40 | 44 | 48 | 49 | 60 | 72)
}

/// Vegetation below this is ground for Patchwork, in metres above the sensor: at a quarter of the height of KITTI's sensor
/// above the road.
const LOW_VEGETATION_M: f64 = -1.73 * 3.0 / 4.0;

/// Whether a point `z_m` metres above the sensor is ground by its label; `None` if it is left out.
///
/// Sources: `ground_classes` and `outlier_classes` in `utils.hpp` of Patchwork; `groundLabels` and `nonGroundLabels` in
/// `eval_groundpoint_classifier.py` of `GroundGrid`; `evaluateGroundPoints` of `continuous_clustering`.
pub fn is_ground(definition: GroundDefinition, number: u16, z_m: f32) -> Option<bool> {
    match (definition, number) {
        (_, 0) | (GroundDefinition::Patchwork, 1) | (GroundDefinition::GroundGrid, 1 | 70) => None,
        (GroundDefinition::Patchwork, 70) => Some(f64::from(z_m) < LOW_VEGETATION_M),
        _ => Some(is_surface(number)),
    }
}

/// Whether `continuous_clustering` leaves points of this class out of its clusters of true labels: ground and unlabelled
/// points.
pub fn is_in_no_cluster(number: u16) -> bool {
    number == 0 || is_surface(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scans::dataset::semantic_kitti::semantic_class::semantic_class;

    #[test]
    fn of_the_34_numbers_4_are_left_out_and_18_are_things() {
        let known: Vec<u16> = (0..=u16::MAX).filter(|&number| semantic_class(number).is_some()).collect();
        let left_out: Vec<u16> = known.iter().copied().filter(|&number| is_left_out(number)).collect();
        assert_eq!(left_out, [0, 1, 52, 99]);
        let unknown = (0..=u16::MAX).filter(|number| !known.contains(number));
        assert!(unknown.into_iter().all(|number| is_left_out(number) && thing_class(number).is_none()));
        let things = known.iter().filter(|number| thing_class(**number).is_some());
        assert_eq!(things.clone().count(), 18);
        assert!(things.into_iter().all(|&number| !is_left_out(number)));
    }

    #[test]
    fn definitions_differ_in_vegetation_and_outliers() {
        let of = |number, z_m| GroundDefinition::ALL.map(|it| is_ground(it, number, z_m));
        assert_eq!(of(0, -2.0), [None, None, None]);
        assert_eq!(of(1, -2.0), [None, None, Some(false)]);
        assert_eq!(of(70, -1.5), [Some(true), None, Some(false)]);
        assert_eq!(of(70, -1.25), [Some(false), None, Some(false)]);
        assert_eq!(of(72, 3.0), [Some(true); 3]);
        assert_eq!(of(50, -2.0), [Some(false); 3]);
        assert_eq!(of(258, -2.0), [Some(false); 3]);
    }
}
