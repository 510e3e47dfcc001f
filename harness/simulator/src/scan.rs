//! One turn of the sensor in the street.

use parry3d::math::Vector;
use parry3d::query::Ray;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

use super::portable_math;
use super::pulse_path::{Surroundings, first_hit};
use super::rain::{Drop, Rain};
use super::scene::Hit;
use super::sensor::{Beam, SensorModel};
use detector::PointCloud;

/// Result of a turn of the sensor.
#[derive(Debug, Clone, Default)]
pub struct Turn {
    /// The points, beam by beam from the top, in each beam from behind clockwise.
    pub cloud: PointCloud,
    /// For every point, the object it lies on.
    pub objects: Vec<Option<u32>>,
    /// For every point, in which of the surroundings it was seen.
    pub moments: Vec<usize>,
    /// For every pulse that was sent, beam by beam, where it ended, whether or not it came back.
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

/// Sends all pulses of one turn, an equal part of them in each of `surroundings`, in turn: one is enough if nothing moves
/// meanwhile. `beam_rng` gives every beam a random stream of its own, so that beams do not depend on each other.
pub fn turn(
    sensor: &SensorModel,
    errors: &[BeamError],
    surroundings: &[Surroundings<'_>],
    beam_rng: impl Fn(u32) -> ChaCha8Rng,
) -> Turn {
    part_of_turn(sensor, errors, surroundings, |_| 0..sensor.n_firings_per_turn as usize, beam_rng)
}

/// As [`turn`], but sends only the pulses that `firings` returns for a beam that rises this much on each unit of its way.
pub fn part_of_turn<Firings: IntoIterator<Item = usize>>(
    sensor: &SensorModel,
    errors: &[BeamError],
    surroundings: &[Surroundings<'_>],
    firings: impl Fn(f32) -> Firings,
    beam_rng: impl Fn(u32) -> ChaCha8Rng,
) -> Turn {
    let mut turn = Turn::default();
    let mut beam_of_point = Vec::new();
    for ((beam, error), beam_idx) in sensor.beams().zip(errors).zip(0..) {
        let mut rng = beam_rng(beam_idx);
        let way = BeamWay::new(sensor, beam, error);
        let mut previous: Option<(usize, PulseEnd)> = None;
        for firing in firings(way.rise as f32) {
            let ray = way.ray(firing);
            let moment = firing * surroundings.len() / sensor.n_firings_per_turn as usize;
            let hit = first_hit(sensor, &surroundings[moment], &ray, rng.next_u32());
            let end = PulseEnd {
                ray,
                range_m: hit.map_or(f32::INFINITY, |it| it.range_m),
                object_idx: hit.and_then(|it| it.object_idx),
            };
            let neighbor = previous.filter(|(before, _)| before + 1 == firing).map(|(_, end)| end);
            let echo = hit.and_then(|hit| echo(sensor, neighbor.as_ref(), &hit, &mut rng));
            let drop =
                surroundings[moment].rain.and_then(|rain| drop_echo(sensor, rain, end.range_m, &mut rng));
            let echo = drop.or(echo);
            if let Some(echo) = echo {
                let measured_m = (echo.range_m + error.range_m).max(0.0);
                turn.cloud.push(ray.point_at(measured_m).into(), echo.intensity);
                turn.objects.push(echo.object_idx);
                turn.moments.push(moment);
                beam_of_point.push(beam_idx as u16);
            }
            turn.ends.push(end);
            previous = Some((firing, end));
        }
    }
    turn.cloud.set_ring(beam_of_point);
    turn
}

/// The ways of a beam's pulses in the sensor frame, from behind clockwise.
struct BeamWay {
    origin: Vector,
    rise: f64,
    level: f64,
    first_rad: f64,
    n_firings: f64,
}

impl BeamWay {
    fn new(sensor: &SensorModel, beam: Beam, error: &BeamError) -> Self {
        let elevation_rad = f64::from(beam.elevation_deg + error.elevation_deg).to_radians();
        let (rise, level) = portable_math::sin_cos(elevation_rad);
        let first_rad = std::f64::consts::PI + f64::from(error.azimuth_deg).to_radians();
        let n_firings = f64::from(sensor.n_firings_per_turn);
        Self { origin: Vector::Z * beam.origin_height_m, rise, level, first_rad, n_firings }
    }

    fn ray(&self, firing: usize) -> Ray {
        let turned = (firing as f64 + 0.5) / self.n_firings;
        let (sine, cosine) = portable_math::sin_cos(self.first_rad - turned * std::f64::consts::TAU);
        let toward = [self.level * cosine, self.level * sine, self.rise].map(|it| it as f32);
        Ray::new(self.origin, Vector::from(toward))
    }
}

/// Echo of a pulse, as the sensor measures it.
#[derive(Debug, Clone, Copy)]
struct Echo {
    range_m: f32,
    intensity: f32,
    object_idx: Option<u32>,
}

/// The echo of `hit`, if it is noticed; `previous` is where the pulse before it ended.
fn echo(sensor: &SensorModel, previous: Option<&PulseEnd>, hit: &Hit, rng: &mut ChaCha8Rng) -> Option<Echo> {
    if !is_detected(sensor, hit, rng.random()) {
        return None;
    }
    let noise_m = gaussian(rng) * sensor.range_noise_sigma_m;
    let intensity = intensity(hit, gaussian(rng));
    let mixed_m = mixed_range_m(sensor, previous, hit, rng.random());
    // A point in the air between two things lies on neither.
    let in_the_air = mixed_m.is_some_and(|mixed_m| (mixed_m - hit.range_m).abs() > LABEL_TOLERANCE_M);
    let object_idx = if in_the_air { None } else { hit.object_idx };
    let range_m = mixed_m.unwrap_or(hit.range_m) + noise_m;
    (range_m >= sensor.min_range_m).then_some(Echo { range_m, intensity, object_idx })
}

/// The echo of a drop of rain before `free_m`, where the pulse ends, if one is noticed: it belongs to no object.
fn drop_echo(sensor: &SensorModel, rain: Rain, free_m: f32, rng: &mut ChaCha8Rng) -> Option<Echo> {
    let Drop { range_m, intensity } = rain.drop(free_m, [rng.random(), rng.random()])?;
    (range_m >= sensor.min_range_m).then_some(Echo { range_m, intensity, object_idx: None })
}

/// How far from the surface of an object a mixed echo still counts as one of its points, in metres.
const LABEL_TOLERANCE_M: f32 = 0.03;

/// Surfaces whose ranges differ by this much, in metres, give one echo in between if a beam straddles their edge:
/// nearer ones cannot be distinguished anyway, those farther apart give two echoes, of which one is reported.
const MIXING_M: std::ops::Range<f32> = 0.2..1.5;

/// The range between this hit and the one before, if the beam straddles the edge between them.
///
/// `chance` is in 0 to 1. The width of the beam covers a share of the step from one firing to the next.
fn mixed_range_m(sensor: &SensorModel, previous: Option<&PulseEnd>, hit: &Hit, chance: f32) -> Option<f32> {
    // The parts of one object are not distinguished: its leaves and pales are finer than any beam.
    let previous = previous.filter(|it| it.object_idx.is_none() || it.object_idx != hit.object_idx)?;
    let previous_m = previous.range_m;
    let step_deg = 360.0 / sensor.n_firings_per_turn as f32;
    let straddling = sensor.beam_divergence_deg / step_deg;
    let is_edge = MIXING_M.contains(&(previous_m - hit.range_m).abs());
    (is_edge && chance < straddling).then(|| previous_m + chance / straddling * (hit.range_m - previous_m))
}

/// Whether a hit is strong enough to be noticed; `chance` is in 0 to 1.
fn is_detected(sensor: &SensorModel, hit: &Hit, chance: f32) -> bool {
    let ratio = overlap(sensor, hit.range_m) * hit.signal_per_m2() / sensor.half_detected_signal_per_m2;
    // Falls from nearly 1 to nearly 0 within a factor of four about the half.
    let probability = ratio * ratio / (1.0 + ratio * ratio);
    chance < probability * (1.0 - sensor.random_loss)
}

/// The share of the lit spot that the receiver sees at `range_m`: next to nothing before the housing, all of it from afar.
fn overlap(sensor: &SensorModel, range_m: f32) -> f32 {
    let (range_m2, near_m2) = (range_m * range_m, sensor.near_field_m * sensor.near_field_m);
    let range_m4 = range_m2 * range_m2;
    // A hit at the very sensor is not seen, however wide the near field.
    if range_m4 == 0.0 { 0.0 } else { range_m4 / (range_m4 + near_m2 * near_m2) }
}

/// Intensity that the sensor reports: 0 to 0.99, in hundredths.
fn intensity(hit: &Hit, noise: f32) -> f32 {
    let exact = hit.reflectivity * (0.7 + 0.3 * hit.cos_incidence) * (1.0 + 0.1 * noise);
    (exact.clamp(0.0, 0.99) * 100.0).round() / 100.0
}

/// A nearly normal number of mean 0 and variance 1 within ±3.5: the scaled sum of four even ones, because the exact
/// distribution needs functions that round differently from machine to machine.
pub fn gaussian(rng: &mut ChaCha8Rng) -> f32 {
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
        let hit = Hit { range_m, cos_incidence: 0.8, reflectivity, object_idx: None, mirror: None };
        let sensor = SensorModel::hdl_64e_s2();
        let n = (0..1000).filter(|chance| is_detected(&sensor, &hit, *chance as f32 / 1000.0)).count();
        assert!(expected.contains(&(n as f32 / 1000.0)), "{n}");
    }

    #[test]
    fn the_receiver_sees_half_of_the_spot_at_the_end_of_the_near_field() {
        let sensor = SensorModel { near_field_m: 15.0, ..SensorModel::hdl_64e_s2() };
        assert_eq!(overlap(&sensor, 15.0), 0.5);
        assert!(overlap(&sensor, 3.0) < 0.01 && overlap(&sensor, 60.0) > 0.99);
        assert_eq!(overlap(&SensorModel { near_field_m: 0.0, ..sensor }, 0.5), 1.0);
    }

    #[test]
    fn black_paint_is_lost_when_met_flat_or_near() {
        check_share_detected(12.0, 0.002, 0.5..0.9);
        check_share_detected(5.0, 0.002, 0.0..0.3);
    }

    #[test]
    fn near_things_are_nearly_always_detected() {
        check_share_detected(10.0, 0.3, 0.96..1.0);
    }

    #[test]
    fn dark_things_far_away_are_often_lost() {
        check_share_detected(100.0, 0.015, 0.2..0.6);
    }

    #[test]
    fn what_sends_nothing_back_is_never_detected() {
        check_share_detected(10.0, 0.0, 0.0..0.0001);
    }

    #[track_caller]
    fn check_mixed(ranges_m: [f32; 2], chance: f32, expected_m: Option<f32>) {
        let end = |range_m| PulseEnd { ray: Ray::new(Vector::ZERO, Vector::X), range_m, object_idx: None };
        let hit = Hit {
            range_m: ranges_m[1],
            cos_incidence: 1.0,
            reflectivity: 0.3,
            object_idx: None,
            mirror: None,
        };
        let found = mixed_range_m(&SensorModel::hdl_64e_s2(), Some(&end(ranges_m[0])), &hit, chance);
        assert_eq!(found, expected_m);
    }

    #[test]
    fn a_beam_that_straddles_an_edge_reports_a_range_in_between() {
        check_mixed([10.0, 11.0], 0.0, Some(10.0));
        let found = mixed_range_m(
            &SensorModel::hdl_64e_s2(),
            Some(&PulseEnd { ray: Ray::new(Vector::ZERO, Vector::X), range_m: 10.0, object_idx: None }),
            &Hit { range_m: 11.0, cos_incidence: 1.0, reflectivity: 0.3, object_idx: None, mirror: None },
            0.2,
        );
        assert!(found.is_some_and(|range_m| (10.1..10.9).contains(&range_m)), "{found:?}");
    }

    #[test]
    fn echoes_of_far_apart_surfaces_do_not_mix() {
        check_mixed([10.0, 15.0], 0.0, None);
        check_mixed([10.0, 10.1], 0.0, None);
    }

    #[test]
    fn most_beams_do_not_straddle_an_edge() {
        check_mixed([10.0, 11.0], 0.9, None);
    }
}
