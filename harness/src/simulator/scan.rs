//! One turn of the sensor in the street.

use parry3d::math::{Pose, Vector};
use parry3d::query::Ray;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

use super::ground::Ground;
use super::portable_math;
use super::scene::{Hit, Pulse, Scene};
use super::sensor::{CarrierRoof, SensorModel};
use detector::PointCloud;

/// What surrounds the sensor during a turn.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    /// Roads and pavement.
    pub ground: &'a Ground,
    /// What never moves.
    pub standing: &'a Scene,
    /// What moves, where it is now.
    pub moving: &'a Scene,
    /// Where the sensor is.
    pub world_from_sensor: Pose,
}

/// What a turn of the sensor yields.
#[derive(Debug, Clone)]
pub struct Turn {
    /// The points, beam by beam from the top, in each beam from behind clockwise.
    pub cloud: PointCloud,
    /// For every point, the object it lies on.
    pub objects: Vec<Option<u32>>,
    /// For every pulse, beam by beam, where it ended, whether or not it came back.
    pub ends: Vec<PulseEnd>,
}

/// Where a pulse went and ended.
#[derive(Debug, Clone, Copy)]
pub struct PulseEnd {
    /// Where it came from and its direction, a unit vector, in the sensor frame.
    pub ray: Ray,
    /// Where it ended, in metres; infinite if nowhere.
    pub range_m: f32,
    /// The object it ended on.
    pub object_idx: Option<u32>,
}

/// How one beam differs from its description, for a whole drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamError {
    range_m: f32,
    elevation_deg: f32,
    azimuth_deg: f32,
}

/// Draws the errors of all beams of `sensor`.
pub fn beam_errors(sensor: &SensorModel, rng: &mut ChaCha8Rng) -> Vec<BeamError> {
    let draw = |_| BeamError {
        range_m: gaussian(rng) * sensor.beam_range_error_sigma_m,
        elevation_deg: gaussian(rng) * sensor.beam_elevation_error_sigma_deg,
        azimuth_deg: gaussian(rng) * sensor.beam_azimuth_error_sigma_deg,
    };
    (0..sensor.n_beams()).map(draw).collect()
}

/// Sends all pulses of one turn. `beam_rng` gives every beam its own dice, so that beams do not depend on each other.
pub fn turn(
    sensor: &SensorModel,
    errors: &[BeamError],
    surroundings: &Surroundings<'_>,
    beam_rng: impl Fn(u32) -> ChaCha8Rng,
) -> Turn {
    let n_pulses = (sensor.n_beams() * sensor.n_firings_per_turn) as usize;
    let mut turn = Turn {
        cloud: PointCloud::with_capacity(n_pulses),
        objects: Vec::with_capacity(n_pulses),
        ends: Vec::with_capacity(n_pulses),
    };
    for ((beam, error), beam_idx) in sensor.beams().zip(errors).zip(0..) {
        let mut rng = beam_rng(beam_idx);
        let elevation_rad = f64::from(beam.elevation_deg + error.elevation_deg).to_radians();
        let (rise, level) = portable_math::sin_cos(elevation_rad);
        let origin = Vector::Z * beam.origin_height_m;
        for firing in 0..sensor.n_firings_per_turn {
            let turned = (f64::from(firing) + 0.5) / f64::from(sensor.n_firings_per_turn);
            let azimuth_rad = std::f64::consts::PI - turned * std::f64::consts::TAU
                + f64::from(error.azimuth_deg).to_radians();
            let (sine, cosine) = portable_math::sin_cos(azimuth_rad);
            let direction = Vector::new((level * cosine) as f32, (level * sine) as f32, rise as f32);
            let ray = Ray::new(origin, direction);
            let hit = first_hit(sensor, surroundings, &ray, rng.next_u32());
            turn.ends.push(PulseEnd {
                ray,
                range_m: hit.map_or(f32::INFINITY, |it| it.range_m),
                object_idx: hit.and_then(|it| it.object_idx),
            });
            let Some(hit) = hit else { continue };
            let measured_m = hit.range_m + error.range_m + gaussian(&mut rng) * sensor.range_noise_sigma_m;
            if is_detected(sensor, &hit, rng.random()) && measured_m >= sensor.min_range_m {
                turn.cloud.push(ray.point_at(measured_m).into(), intensity(&hit, gaussian(&mut rng)));
                turn.objects.push(hit.object_idx);
            }
        }
    }
    turn
}

fn first_hit(sensor: &SensorModel, surroundings: &Surroundings<'_>, ray: &Ray, dice: u32) -> Option<Hit> {
    if sensor.carrier_roof.is_some_and(|roof| is_shaded(&roof, ray)) {
        return None;
    }
    let pose = &surroundings.world_from_sensor;
    let pulse = Pulse { ray: Ray::new(*pose * ray.origin, pose.rotation * ray.dir), dice };
    let ground = surroundings.ground.cast(&pulse.ray, sensor.max_range_m).map(|hit| Hit {
        range_m: hit.range_m,
        cos_incidence: (-pulse.ray.dir.dot(hit.normal)).clamp(0.0, 1.0),
        reflectivity: hit.reflectivity,
        object_idx: None,
    });
    [surroundings.standing, surroundings.moving].into_iter().fold(ground, |nearest, scene| {
        let within_m = nearest.map_or(sensor.max_range_m, |hit| hit.range_m);
        scene.cast(&pulse, within_m).or(nearest)
    })
}

/// Whether a pulse (sensor frame) meets the roof of the car that carries the sensor.
fn is_shaded(roof: &CarrierRoof, ray: &Ray) -> bool {
    if ray.dir.z >= 0.0 {
        return false;
    }
    let at_roof = ray.point_at((roof.depth_below_sensor_m + ray.origin.z) / -ray.dir.z);
    (-roof.rear_m..roof.front_m).contains(&at_roof.x) && at_roof.y.abs() < roof.half_width_m
}

/// Whether a hit is strong enough to be noticed; `chance` is in 0 to 1.
fn is_detected(sensor: &SensorModel, hit: &Hit, chance: f32) -> bool {
    let signal_per_m2 = hit.reflectivity * hit.cos_incidence / (hit.range_m * hit.range_m);
    let ratio = signal_per_m2 / sensor.half_detected_signal_per_m2;
    // Falls from nearly 1 to nearly 0 within a factor of four about the half.
    let probability = ratio * ratio / (1.0 + ratio * ratio);
    chance < probability * (1.0 - sensor.random_loss)
}

/// What the sensor reports as intensity, in hundredths of 0 to 1.
fn intensity(hit: &Hit, noise: f32) -> f32 {
    let exact = hit.reflectivity * (0.4 + 0.6 * hit.cos_incidence) * (1.0 + 0.1 * noise);
    (exact.clamp(0.0, 0.99) * 100.0).round() / 100.0
}

/// A nearly normal number of mean 0 and variance 1 within ±3.5: the scaled sum of four even ones, because the exact
/// distribution needs functions that round differently from machine to machine.
fn gaussian(rng: &mut ChaCha8Rng) -> f32 {
    let bits = rng.next_u64();
    let sum: u64 = (0..4).map(|part| (bits >> (16 * part)) & 0xffff).sum();
    (sum as f32 / 65_535.0 - 2.0) * 3.0_f32.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn noise_has_mean_0_and_variance_1() {
        let mut rng = ChaCha8Rng::from_seed([1; 32]);
        let draws: Vec<f32> = (0..40_000).map(|_| gaussian(&mut rng)).collect();
        let mean = draws.iter().sum::<f32>() / draws.len() as f32;
        let variance = draws.iter().map(|it| it * it).sum::<f32>() / draws.len() as f32;
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.03, "{mean} {variance}");
    }

    #[track_caller]
    fn check_share_detected(range_m: f32, reflectivity: f32, expected: std::ops::Range<f32>) {
        let hit = Hit { range_m, cos_incidence: 0.8, reflectivity, object_idx: None };
        let sensor = SensorModel::hdl_64e_s2();
        let n = (0..1000).filter(|chance| is_detected(&sensor, &hit, *chance as f32 / 1000.0)).count();
        assert!(expected.contains(&(n as f32 / 1000.0)), "{n}");
    }

    #[test]
    fn near_things_are_nearly_always_detected() {
        check_share_detected(10.0, 0.3, 0.96..1.0);
    }

    #[test]
    fn dark_things_far_away_are_often_lost() {
        check_share_detected(100.0, 0.03, 0.2..0.6);
    }

    #[test]
    fn what_sends_nothing_back_is_never_detected() {
        check_share_detected(10.0, 0.0, 0.0..0.0001);
    }

    #[test]
    fn steep_beams_ahead_meet_the_own_roof() {
        let roof = SensorModel::hdl_64e_s2().carrier_roof.unwrap();
        let is_shaded = |toward| is_shaded(&roof, &Ray::new(Vector::ZERO, toward));
        assert!(is_shaded(Vector::new(0.9, 0.0, -0.43)));
        assert!(!is_shaded(Vector::new(0.0, 0.9, -0.43)));
        assert!(!is_shaded(Vector::new(1.0, 0.0, 0.1)));
    }
}
