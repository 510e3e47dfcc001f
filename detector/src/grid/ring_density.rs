//! How densely points lie, ring by ring around the sensor.

use std::f64::consts::PI;

use crate::point_cloud::PointCloud;
use crate::portable_math::single;

/// Rings are a metre wide; the first begins this far from the sensor, in metres.
pub const FIRST_RING_M: usize = 1;
/// The last ring ends here, in metres.
pub const LAST_RING_END_M: usize = 80;
/// Number of rings.
pub const N_RINGS: usize = LAST_RING_END_M - FIRST_RING_M;

/// Number of points in every ring, by distance on the ground plan.
///
/// Paper: HG section 4.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RingCounts([u64; N_RINGS]);

impl RingCounts {
    /// Counts the points of `cloud`; those nearer or farther, or not finite, are in no ring.
    pub fn of(cloud: &PointCloud) -> Self {
        let mut counts = [0; N_RINGS];
        for (&x_m, &y_m) in cloud.x_m().iter().zip(cloud.y_m()) {
            let range_m = single::hypot(x_m, y_m);
            // NaN is in no range.
            if (FIRST_RING_M as f32..LAST_RING_END_M as f32).contains(&range_m) {
                counts[range_m as usize - FIRST_RING_M] += 1;
            }
        }
        Self(counts)
    }

    /// Counts that were made elsewhere, from the innermost ring out.
    pub fn from_n_points(n_points: [u64; N_RINGS]) -> Self {
        Self(n_points)
    }

    /// The points of each ring, from the innermost out.
    pub fn n_points(&self) -> &[u64; N_RINGS] {
        &self.0
    }
}

/// Area of ring `ring_idx` in square metres, counted from 0 for the innermost.
pub fn ring_area_m2(ring_idx: usize) -> f64 {
    let from_m = (FIRST_RING_M + ring_idx) as f64;
    PI * ((from_m + 1.0).powi(2) - from_m.powi(2))
}

/// The middle of ring `ring_idx` in metres.
pub fn ring_middle_m(ring_idx: usize) -> f64 {
    (FIRST_RING_M + ring_idx) as f64 + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts_of(positions_m: &[[f32; 3]]) -> RingCounts {
        RingCounts::of(&positions_m.iter().copied().collect())
    }

    #[test]
    fn points_belong_to_the_ring_they_lie_in_whatever_their_height() {
        let counts = counts_of(&[
            [0.99, 0.0, 0.0],
            [1.0, 0.0, 5.0],
            [-1.5, 0.0, 0.0],
            [3.0, 4.0, -1.0],
            [0.0, 79.9, 0.0],
            [80.0, 0.0, 0.0],
            [f32::NAN, 2.0, 0.0],
        ]);
        let occupied: Vec<_> = counts.n_points().iter().enumerate().filter(|(_, n)| **n > 0).collect();
        assert_eq!(occupied, [(0, &2), (4, &1), (78, &1)]);
    }

    #[test]
    fn rings_tile_the_disc() {
        let sum_m2: f64 = (0..N_RINGS).map(ring_area_m2).sum();
        assert!((sum_m2 - PI * (80.0_f64.powi(2) - 1.0)).abs() < 1e-9);
        assert_eq!((ring_middle_m(0), ring_middle_m(N_RINGS - 1)), (1.5, 79.5));
    }
}
