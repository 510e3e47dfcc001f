//! Objects as aircraft scan them: strips of parallel pulses from high above, each as wide as a hand is long, and with
//! several echoes.

use std::f64::consts::TAU;

use detector::PointCloud;
use parry3d::math::Vector;
use parry3d::query::Ray;
use rand::{Rng as _, RngExt};
use rand_chacha::ChaCha8Rng;
use scans::object_cloud::growing_cloud::Moment;

use super::drawn_object::{ObjectNumber, StreamUse};
use super::lone_object::LoneObject;
use crate::portable_math;
use crate::scan::gaussian;
use crate::scene::Pulse;

/// Number of strips that overlap where an object stands.
const N_STRIPS: std::ops::Range<u32> = 1..4;
/// More strips are flown until the object has this many points: such clouds have no labels of objects with fewer.
const LEAST_POINTS: usize = 100;
/// Number of strips at most.
const MOST_STRIPS: u32 = 24;
/// The greatest angle of a pulse off the vertical, in degrees.
const MOST_OFF_VERTICAL_DEG: f64 = 20.0;
/// Distance between the pulses of a strip on the ground, in metres.
const SPACINGS_M: std::ops::Range<f32> = 0.18..0.35;
/// Radius of the spot that a pulse lights, in metres.
const SPOT_RADIUS_M: f32 = 0.15;
/// Number of positions in which a spot is looked at.
const RAYS_PER_PULSE: u32 = 4;
/// Number of echoes of a pulse at most.
const MOST_ECHOES: usize = 4;
/// Echoes that follow each other more closely are one, in metres.
const ECHO_LENGTH_M: f32 = 0.7;
/// The share of light among leaves that goes on.
const GOES_ON: f64 = 0.5;
/// Standard deviation of a range, in metres.
const RANGE_SIGMA_M: f32 = 0.03;
/// Standard deviation of a position along either axis of the ground plan, in metres.
const PLAN_SIGMA_M: f32 = 0.06;

/// The points of `object`, number `number`, and a moment after each strip, without the distance of the aircraft.
pub fn scanned_from_the_air(object: &LoneObject, number: ObjectNumber) -> (PointCloud, Vec<Moment>) {
    let mut rng = number.random_stream(StreamUse::Viewpoint);
    let n_strips = rng.random_range(N_STRIPS);
    let (mut cloud, mut moments) = (PointCloud::default(), Vec::new());
    for strip in 0..MOST_STRIPS {
        if strip >= n_strips && cloud.len() >= LEAST_POINTS {
            break;
        }
        let toward = direction(&mut rng);
        let mut pulses = number.random_stream(StreamUse::Pulses { scan: strip, beam: 0 });
        fly(object, toward, rng.random_range(SPACINGS_M), &mut pulses, &mut cloud);
        moments.push(Moment { n_points: cloud.len(), time_s: f64::from(strip), distance_m: None });
    }
    (cloud, moments)
}

/// Downward, somewhat off the vertical.
fn direction(rng: &mut ChaCha8Rng) -> Vector {
    let off_rad = rng.random_range(0.0..MOST_OFF_VERTICAL_DEG).to_radians();
    let (sine, cosine) = portable_math::sin_cos(rng.random_range(0.0..TAU));
    let (aside, down) = portable_math::sin_cos(off_rad);
    Vector::from([aside * cosine, aside * sine, -down].map(|it| it as f32))
}

/// Adds the points of one strip.
fn fly(object: &LoneObject, toward: Vector, spacing_m: f32, rng: &mut ChaCha8Rng, cloud: &mut PointCloud) {
    // A pulse that meets the top has its spot on the ground farther on.
    let slant_m = object.top_m() * (toward.x * toward.x + toward.y * toward.y).sqrt() / -toward.z;
    let n_to_a_side = ((object.reach_m() + slant_m + SPOT_RADIUS_M) / spacing_m).ceil() as i32;
    let begin_m = 2.0 * object.top_m() + 10.0;
    for row in -n_to_a_side..=n_to_a_side {
        for column in -n_to_a_side..=n_to_a_side {
            let mut position = |it: i32| (it as f32 + rng.random_range(-0.5_f32..0.5)) * spacing_m;
            let spot = Vector::new(position(row), position(column), 0.0);
            let axis = Ray::new(spot + toward * (begin_m / toward.z), toward);
            for (range_m, intensity) in echoes(object, &axis, rng) {
                let measured = axis.point_at(range_m + gaussian(rng) * RANGE_SIGMA_M);
                let aside = Vector::new(gaussian(rng), gaussian(rng), 0.0) * PLAN_SIGMA_M;
                cloud.push((measured + aside).into(), intensity);
            }
        }
    }
}

/// Ranges, in metres, and intensities of the echoes of a pulse about `axis`, ascending.
fn echoes(object: &LoneObject, axis: &Ray, rng: &mut ChaCha8Rng) -> Vec<(f32, f32)> {
    let mut met = Vec::new();
    for _ in 0..RAYS_PER_PULSE {
        let mut aside = || rng.random_range(-SPOT_RADIUS_M..SPOT_RADIUS_M);
        let offset = Vector::new(aside(), aside(), 0.0);
        let mut flown_m = 0.0;
        while met.len() < MOST_ECHOES * RAYS_PER_PULSE as usize {
            let ray = Ray::new(axis.origin + offset + axis.dir * flown_m, axis.dir);
            let Some(hit) = object.met_by(&Pulse { ray, rng: rng.next_u32() }) else { break };
            flown_m += hit.range_m;
            if hit.reflectivity > 0.0 {
                met.push((flown_m, hit.reflectivity));
            }
            let rest = Ray::new(ray.point_at(hit.range_m), axis.dir);
            if !object.is_among_leaves(&rest) || !rng.random_bool(GOES_ON) {
                break;
            }
        }
    }
    met.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut echoes: Vec<(f32, f32)> = Vec::new();
    for it in met {
        if echoes.len() < MOST_ECHOES && echoes.last().is_none_or(|last| it.0 - last.0 > ECHO_LENGTH_M) {
            echoes.push(it);
        }
    }
    echoes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use crate::object_clouds::drawn_object::DrawnObject;
    use crate::object_shape::ObjectShape;
    use crate::solid::Solid;
    use reports::vocabulary::class::AnnotationClass;
    use reports::vocabulary::partial_class::PartialClass;

    const NUMBER: ObjectNumber = ObjectNumber { seed: 1, class: PartialClass::Other, number: 0 };

    fn lone(material: Material) -> LoneObject {
        let solid = Solid::cuboid([-2.0, -2.0, 1.0], [2.0, 2.0, 5.0]);
        let shape = ObjectShape::new(AnnotationClass::Misc, [(solid, material)]);
        LoneObject::new(&DrawnObject { shape, yaw_rad: 0.0 })
    }

    #[test]
    fn a_block_is_seen_from_above_and_leaves_are_seen_through() {
        let share_within = |material| {
            let (cloud, _) = scanned_from_the_air(&lone(material), NUMBER);
            let n_within = cloud.positions_m().filter(|[x, y, z]| *z < 4.5 && x.abs() < 1.6 && y.abs() < 1.6);
            n_within.count() as f32 / cloud.len() as f32
        };
        assert_eq!(share_within(Material::MASONRY), 0.0);
        assert!(share_within(Material::foliage(0.8)) > 0.3);
    }

    #[test]
    fn a_roof_has_as_many_points_as_pulses_fall_on_it() {
        let mut cloud = PointCloud::default();
        let mut rng = NUMBER.random_stream(StreamUse::Form);
        fly(&lone(Material::MASONRY), -Vector::Z, 0.25, &mut rng, &mut cloud);
        // 4 m by 4 m, and the half of a spot beyond, that is about 4.2 m.
        let expected = 4.2 * 4.2 / (0.25 * 0.25);
        assert!((cloud.len() as f32 / expected - 1.0).abs() < 0.1, "{} points", cloud.len());
        let off_m: Vec<f32> = cloud.z_m().iter().map(|z_m| z_m - 5.0).collect();
        let sigma_m = (off_m.iter().map(|it| it * it).sum::<f32>() / off_m.len() as f32).sqrt();
        assert!((sigma_m - RANGE_SIGMA_M).abs() < 0.006, "{sigma_m}");
    }

    #[test]
    fn small_things_are_flown_over_until_they_are_seen() {
        let number = ObjectNumber { seed: 1, class: PartialClass::Pedestrian, number: 0 };
        let (cloud, moments) = scanned_from_the_air(&LoneObject::new(&number.draw()), number);
        assert!(
            cloud.len() >= LEAST_POINTS && moments.len() > 3,
            "{} points, {} strips",
            cloud.len(),
            moments.len()
        );
        assert_eq!(moments.last().map(|it| it.n_points), Some(cloud.len()));
    }
}
