//! Objects scanned from all round, as surveyors do.

use std::f64::consts::TAU;

use detector::PointCloud;
use rand::RngExt;
use scans::object_cloud::growing_cloud::Moment;

use super::drawn_object::{ObjectNumber, StreamUse};
use super::lone_object::{LoneObject, Look, level_pose};
use crate::scan::beam_errors;
use crate::sensor::SensorModel;

/// Number of positions that a surveyor scans from.
const N_POSITIONS: std::ops::Range<u32> = 4..8;
/// Their distance from the outline of the object, in metres.
const CLEARANCES_M: std::ops::Range<f32> = 3.0..10.0;

/// The scanner that surveys.
pub fn survey_scanner() -> SensorModel {
    let description = include_str!("../sensors/survey.toml");
    SensorModel::from_toml(description).expect("a test reads the description")
}

/// The points of `object`, number `number`, from positions all round it, registered without error; a moment after each.
pub fn scanned_around(
    object: &LoneObject,
    number: ObjectNumber,
    scanner: &SensorModel,
) -> (PointCloud, Vec<Moment>) {
    let errors = beam_errors(scanner, &mut number.random_stream(StreamUse::Beams));
    let mut rng = number.random_stream(StreamUse::Viewpoint);
    let n_positions = rng.random_range(N_POSITIONS);
    let first_rad = rng.random_range(0.0..TAU);
    let (mut cloud, mut moments) = (PointCloud::default(), Vec::new());
    for scan in 0..n_positions {
        let bearing_rad =
            first_rad + TAU * (f64::from(scan) + rng.random_range(-0.25..0.25)) / f64::from(n_positions);
        let distance_m = object.reach_m() + rng.random_range(CLEARANCES_M);
        let world_from_sensor = level_pose(bearing_rad, distance_m, scanner, &mut rng);
        let look = Look::from(world_from_sensor, scanner, &errors);
        let pulses = |beam| number.random_stream(StreamUse::Pulses { scan, beam });
        object.append_points(&look, |_| true, pulses, &mut cloud);
        let time_s = f64::from(scan) / f64::from(scanner.turns_per_second);
        moments.push(Moment { n_points: cloud.len(), time_s, distance_m: Some(distance_m) });
    }
    (cloud, moments)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::sine_and_cosine;
    use reports::vocabulary::partial_class::PartialClass;

    #[test]
    fn all_sides_of_a_car_are_seen_and_nothing_of_the_road() {
        let number = ObjectNumber { seed: 1, class: PartialClass::Car, number: 0 };
        let drawn = number.draw();
        let object = LoneObject::new(&drawn);
        let (cloud, moments) = scanned_around(&object, number, &survey_scanner());
        assert!((4..8).contains(&moments.len()) && moments.is_sorted_by_key(|it| it.n_points));
        assert_eq!(moments.last().unwrap().n_points, cloud.len());
        let (sine, cosine) = sine_and_cosine(drawn.yaw_rad.into());
        let [length_m, width_m, height_m] = object.extents_m;
        let mut n_by_side = [0; 4];
        for [x_m, y_m, z_m] in cloud.positions_m() {
            let (along_m, across_m) = (cosine * x_m + sine * y_m, cosine * y_m - sine * x_m);
            assert!(along_m.abs() < length_m / 2.0 + 0.06 && across_m.abs() < width_m / 2.0 + 0.06);
            assert!((-0.02..height_m + 0.06).contains(&z_m), "{z_m}");
            let sides = [along_m, -along_m, across_m, -across_m];
            let halves_m = [length_m, length_m, width_m, width_m].map(|it| it / 2.0);
            for (n, (side, half_m)) in n_by_side.iter_mut().zip(sides.into_iter().zip(halves_m)) {
                *n += u32::from(side > half_m - 0.3);
            }
        }
        assert!(n_by_side.iter().all(|n| *n > 30), "{n_by_side:?}");
    }
}
