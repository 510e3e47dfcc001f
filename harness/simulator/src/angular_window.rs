//! The directions in which an object may be seen.

use parry3d::math::Vector;

use super::portable_math;
use super::solid::PlacedSolid;
use super::world::sine_and_cosine;

/// The directions in which an object may be seen.
#[derive(Debug, Clone, Copy)]
pub struct AngularWindow {
    middle_rad: f64,
    half_width_rad: f64,
    least_rise: f32,
    greatest_rise: f32,
}

impl AngularWindow {
    /// The window in which `solids` may be seen from the origin.
    pub fn of(solids: &[PlacedSolid]) -> Self {
        Self::around(solids.iter().flat_map(|solid| solid.bounds().vertices()))
    }

    /// The window in which everything between `corners`, at least one, may be seen from the origin.
    pub fn around(corners: impl Iterator<Item = Vector> + Clone) -> Self {
        let n_corners = corners.clone().count() as f32;
        let center = corners.clone().sum::<Vector>() / n_corners;
        let middle_rad = portable_math::atan2(f64::from(center.y), f64::from(center.x));
        let (sine, cosine) = sine_and_cosine(middle_rad);
        let mut window = Self { middle_rad, half_width_rad: 0.0, least_rise: 1.0, greatest_rise: -1.0 };
        for corner in corners.clone() {
            let ahead = corner.x * cosine + corner.y * sine;
            let aside = corner.y * cosine - corner.x * sine;
            let off_rad = portable_math::atan2(f64::from(aside), f64::from(ahead)).abs();
            window.half_width_rad = window.half_width_rad.max(off_rad);
            let rise = corner.z / corner.length().max(1e-3);
            window.least_rise = window.least_rise.min(rise);
            window.greatest_rise = window.greatest_rise.max(rise);
        }
        // Beams start up to a hand above the origin, and an edge may rise a little above both of its ends.
        let nearest_m = corners.map(Vector::length).fold(f32::INFINITY, f32::min);
        let slack = 0.01 + 0.25 / nearest_m.max(0.5);
        window.least_rise -= slack;
        window.greatest_rise += slack;
        window
    }

    /// Whether pulses that rise `rise` on each unit of their way may lie in the window.
    pub fn may_meet(&self, rise: f32) -> bool {
        (self.least_rise..=self.greatest_rise).contains(&rise)
    }

    /// The firings of a beam, of `n_firings` in a turn that begins behind and goes clockwise, that fall into the window.
    pub fn firings(&self, n_firings: usize) -> impl ExactSizeIterator<Item = usize> + use<> {
        let firings_per_rad = n_firings as f64 / std::f64::consts::TAU;
        let middle = (std::f64::consts::PI - self.middle_rad) * firings_per_rad;
        let half = (self.half_width_rad * firings_per_rad + 1.0).min(n_firings as f64 / 2.0);
        let first = (middle - half).floor() as i64;
        let count = (2.0 * half) as usize;
        (0..count).map(move |step| (first + step as i64).rem_euclid(n_firings as i64) as usize)
    }
}
