//! Rain: light it takes away, drops that look like things, and wet ground that mirrors.
//!
//! The model is simple on purpose. Light fades exponentially on its way through rain (Beer and Lambert), there and back,
//! and how fast is a power law of the rain rate: 1.076 R^0.67 dB/km with R in mm/h, which Carbonneau and Wisely give for
//! optical links through the open air. Light fades because drops scatter it: the same power law says how often a pulse meets
//! a drop, and of these drops only near ones send back enough to be taken for a thing. Wet ground is dark, and where water
//! covers it, it mirrors by Schlick's approximation of Fresnel's law: little from above, nearly everything when met flat.

use parry3d::math::Vector;

use super::portable_math;
use super::scene::{GROUND_LEAF, Hit, Mirror, chance, spot_number};

/// Rain of a certain rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rain {
    mm_per_h: f32,
    /// Share of light that is scattered away per metre.
    extinction_per_m: f32,
    /// Share of the ground that is covered with water, 0 to 1.
    covered_share: f32,
}

/// Rain rates that occur, in millimetres per hour: from drizzle to a cloudburst.
pub const RAIN_RATES_MM_PER_H: std::ops::RangeInclusive<f32> = 0.1..=150.0;

/// The range at which the chance that a drop is taken for a thing has fallen to 37 %, in metres.
const DROP_FADING_M: f32 = 4.0;
/// Reflectivity of soaked ground over that of dry ground: the rest of the light is lost inside.
const WET_BRIGHTNESS: f32 = 0.65;
/// Share of light that water mirrors when met at a right angle.
const MIRRORED_FROM_ABOVE: f32 = 0.02;
/// Share of the ground that water covers in the heaviest rain, and the rate at which half of that is covered.
const MOST_COVERED: f32 = 0.25;
const HALF_COVERED_MM_PER_H: f32 = 20.0;

/// A drop that looks like a thing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drop {
    /// Its range in metres.
    pub range_m: f32,
    /// Its brightness, as intensity.
    pub intensity: f32,
}

impl Rain {
    /// Rain of this rate in millimetres per hour, within [`RAIN_RATES_MM_PER_H`].
    pub fn new(mm_per_h: f32) -> Self {
        let rate = f64::from(mm_per_h.clamp(*RAIN_RATES_MM_PER_H.start(), *RAIN_RATES_MM_PER_H.end()));
        let db_per_km = 1.076 * portable_math::exp(0.67 * portable_math::ln(rate));
        let extinction_per_m = (db_per_km * std::f64::consts::LN_10 / 10.0 / 1000.0) as f32;
        let rate = rate as f32;
        let covered_share = MOST_COVERED * rate / (rate + HALF_COVERED_MM_PER_H);
        Self { mm_per_h: rate, extinction_per_m, covered_share }
    }

    /// Its rate in millimetres per hour.
    pub fn mm_per_h(&self) -> f32 {
        self.mm_per_h
    }

    /// `hit` as it looks through the rain.
    pub fn dimmed(&self, hit: Hit) -> Hit {
        let there_and_back = portable_math::exp(f64::from(-2.0 * self.extinction_per_m * hit.range_m));
        Hit { reflectivity: hit.reflectivity * there_and_back as f32, ..hit }
    }

    /// The echo of a drop that a pulse meets within `free_m`, if it meets one that is noticed; both chances are in 0 to 1.
    ///
    /// Drops are met at the rate of the extinction e, and noticed with a chance that falls with the range r as
    /// exp(−r/d): so a pulse gives such an echo with the chance e/(e + 1/d), at ranges that fall off as
    /// exp(−(e + 1/d) r).
    pub fn drop(&self, free_m: f32, [met, where_met]: [f32; 2]) -> Option<Drop> {
        let rate_per_m = self.extinction_per_m + 1.0 / DROP_FADING_M;
        let share = self.extinction_per_m / rate_per_m;
        if met >= share {
            return None;
        }
        let range_m = (-portable_math::ln(f64::from(where_met.max(f32::MIN_POSITIVE)))) as f32 / rate_per_m;
        // The rest of the chance says how large the drop is.
        let intensity = (1.0 + 4.0 * met / share).round() / 100.0;
        (range_m < free_m).then_some(Drop { range_m, intensity })
    }

    /// The hit of wet ground where dry ground gives `hit`, at `position` in the world with the unit normal `normal`.
    pub fn wet_ground(&self, hit: Hit, position: Vector, normal: Vector) -> Hit {
        let soaked = Hit { reflectivity: hit.reflectivity * WET_BRIGHTNESS, ..hit };
        // Puddles and films are larger than a beam.
        if chance(spot_number(position), GROUND_LEAF) > self.covered_share {
            return soaked;
        }
        let flatness = 1.0 - hit.cos_incidence;
        let fifth_power = flatness * flatness * flatness * flatness * flatness;
        let mirrored = MIRRORED_FROM_ABOVE + (1.0 - MIRRORED_FROM_ABOVE) * fifth_power;
        // Light passes the surface of the water twice, whether it is mirrored or not.
        let share = mirrored * mirrored;
        let entered = (1.0 - mirrored) * (1.0 - mirrored);
        Hit { reflectivity: soaked.reflectivity * entered, mirror: Some(Mirror { normal, share }), ..soaked }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: Hit =
        Hit { range_m: 50.0, cos_incidence: 1.0, reflectivity: 0.4, object_idx: None, mirror: None };

    #[track_caller]
    fn check_transmission(mm_per_h: f32, range_m: f32, expected: f32) {
        let seen = Rain::new(mm_per_h).dimmed(Hit { range_m, ..WALL });
        assert!((seen.reflectivity / WALL.reflectivity - expected).abs() < 0.005, "{seen:?}");
    }

    #[test]
    fn light_fades_with_range_and_rain_rate() {
        // 1.076 dB/km at 1 mm/h, 5.033 at 10, 23.54 at 100: over twice 50 m and twice 100 m.
        check_transmission(1.0, 50.0, 0.9755);
        check_transmission(10.0, 50.0, 0.8906);
        check_transmission(10.0, 100.0, 0.7931);
        check_transmission(100.0, 50.0, 0.5816);
    }

    /// Share of pulses that see a drop, and the mean range of those drops.
    fn drops(rain: Rain, free_m: f32) -> (f32, f32) {
        let chances = (0..400_000).map(|n| [n as f32 / 400_000.0, ((n * 7919 % 1000) as f32 + 0.5) / 1000.0]);
        let ranges_m: Vec<f32> =
            chances.filter_map(|it| rain.drop(free_m, it)).map(|drop| drop.range_m).collect();
        let n = ranges_m.len() as f32;
        (n / 400_000.0, ranges_m.iter().sum::<f32>() / n)
    }

    #[test]
    fn drops_are_seen_near_by_and_the_more_the_heavier_it_rains() {
        let (light, light_range_m) = drops(Rain::new(2.0), 120.0);
        let (heavy, heavy_range_m) = drops(Rain::new(50.0), 120.0);
        assert!((0.001..0.003).contains(&light) && (0.01..0.02).contains(&heavy), "{light} {heavy}");
        assert!((3.5..4.2).contains(&light_range_m), "{light_range_m}");
        assert!((3.5..4.2).contains(&heavy_range_m), "{heavy_range_m}");
    }

    #[test]
    fn drops_behind_a_thing_are_not_seen() {
        let (share, range_m) = drops(Rain::new(50.0), 2.0);
        assert!(share < drops(Rain::new(50.0), 120.0).0 * 0.5 && range_m < 2.0, "{share} {range_m}");
    }

    /// A road met at this cosine at 1,000 positions: share of them that mirror, and of light that the first mirrors.
    fn mirroring(mm_per_h: f32, cos_incidence: f32) -> (f32, f32) {
        let rain = Rain::new(mm_per_h);
        let road = Hit { cos_incidence, ..WALL };
        let mirrors: Vec<f32> = (0..1000)
            .map(|n| rain.wet_ground(road, Vector::new(n as f32, 0.5 * n as f32, 0.0), Vector::Z))
            .inspect(|wet| assert!(wet.reflectivity < 0.7 * road.reflectivity, "wet ground is dark"))
            .filter_map(|wet| wet.mirror.map(|it| it.share))
            .collect();
        (mirrors.len() as f32 / 1000.0, mirrors[0])
    }

    #[test]
    fn the_heavier_it_rains_the_more_of_the_ground_mirrors() {
        let (light, _) = mirroring(2.0, 0.1);
        let (heavy, _) = mirroring(50.0, 0.1);
        assert!((0.005..0.05).contains(&light) && (0.12..0.25).contains(&heavy), "{light} {heavy}");
    }

    #[test]
    fn water_mirrors_when_met_flat() {
        assert!(mirroring(50.0, 0.02).1 > 0.7);
        assert!(mirroring(50.0, 0.9).1 < 0.001);
    }
}
