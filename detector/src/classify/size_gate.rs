//! Vehicles by their size alone.

use serde::Deserialize;

use crate::detection::DetectedClass;
use crate::oriented_box::OrientedBox;

/// The sizes of [`size_gate`], in metres. All bounds are inclusive.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SizeGateParams {
    /// Fewest points of a vehicle.
    pub min_points: usize,
    /// Shortest length; the box may show one end of the vehicle only.
    pub min_length_m: f32,
    /// Longest length.
    pub max_length_m: f32,
    /// Widest width.
    pub max_width_m: f32,
    /// Lowest height of the seen part.
    pub min_height_m: f32,
    /// Highest height of the seen part.
    pub max_height_m: f32,
}

/// Classifies every object with the size of the visible part of a vehicle as a vehicle, and all others as objects.
///
/// It ignores shape: a stretch of hedge passes. All detectors share it, so that they are compared by the clusters they give
/// it, and it gives no score.
pub fn size_gate(n_points: usize, bounding_box: &OrientedBox, params: &SizeGateParams) -> DetectedClass {
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
    let fits = n_points >= params.min_points
        && (params.min_length_m..=params.max_length_m).contains(&length_m)
        && width_m <= params.max_width_m
        && (params.min_height_m..=params.max_height_m).contains(&height_m);
    if fits { DetectedClass::Vehicle } else { DetectedClass::Object }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;

    #[track_caller]
    fn check(length_width_height_m: [f32; 3], expected: DetectedClass) {
        let params = HierarchicalParams::shipped().vehicle_size;
        let it = OrientedBox { center_m: [9.0, 0.0, -1.0], length_width_height_m, yaw_rad: 0.3 };
        assert_eq!(size_gate(500, &it, &params), expected, "{length_width_height_m:?}");
        assert_eq!(size_gate(1, &it, &params), DetectedClass::Object);
    }

    #[test]
    fn cars_and_the_ends_of_cars_are_vehicles() {
        check([4.3, 1.8, 1.3], DetectedClass::Vehicle);
        check([1.8, 0.4, 1.2], DetectedClass::Vehicle);
    }

    #[test]
    fn people_poles_and_walls_are_objects() {
        check([0.6, 0.5, 1.6], DetectedClass::Object);
        check([0.2, 0.2, 2.8], DetectedClass::Object);
        check([25.0, 0.5, 2.0], DetectedClass::Object);
    }
}
