//! How densely points lie, ring by ring around the sensor.

use std::f64::consts::PI;

use detector::PointCloud;
use reports::curve_pair::{CurveBin, CurvePair, Measured, Sides};

/// Rings are a metre wide; the first begins this far from the sensor, in metres.
const FIRST_RING_M: usize = 1;
/// The last ring ends here, in metres.
const END_M: usize = 80;
/// Nearer the car's own roof matters, farther single walls: the agreement in between is told on its own.
const FOCUS_M: [f64; 2] = [5.0, 50.0];
/// Fewest points of a ring on the right: its density is then known to a tenth.
const LEAST_POINTS: u64 = 100;

/// Number of points of one scan in every ring, by distance on the ground plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RingCounts([u64; END_M - FIRST_RING_M]);

impl RingCounts {
    /// Counts the points of `cloud`; those nearer or farther, or not finite, are in no ring.
    pub fn of(cloud: &PointCloud) -> Self {
        let mut counts = [0; END_M - FIRST_RING_M];
        for (&x_m, &y_m) in cloud.x_m().iter().zip(cloud.y_m()) {
            let range_m = x_m.hypot(y_m);
            // NaN is in no range.
            if (FIRST_RING_M as f32..END_M as f32).contains(&range_m) {
                counts[range_m as usize - FIRST_RING_M] += 1;
            }
        }
        Self(counts)
    }
}

/// Points per square metre and scan in every ring, over all scans together.
pub fn ring_density(counts: &Sides<Vec<RingCounts>>) -> CurvePair {
    let bin = |ring_idx: usize| {
        let from_m = (FIRST_RING_M + ring_idx) as f64;
        let area_m2 = PI * ((from_m + 1.0).powi(2) - from_m.powi(2));
        CurveBin {
            name: format!("{from_m}-{} m", from_m + 1.0),
            ends_m: Some([from_m, from_m + 1.0]),
            measured: counts.as_ref().map(|scans| {
                let n: u64 = scans.iter().map(|it| it.0[ring_idx]).sum();
                let density = n as f64 / (area_m2 * scans.len() as f64);
                Measured { value: (!scans.is_empty()).then_some(density), n }
            }),
        }
    };
    CurvePair {
        statistic: "ring_density",
        title: "point density per scan",
        bins_of: Some("range"),
        focus_m: Some(FOCUS_M),
        unit: "points/m²",
        counted: "points",
        least_n: Sides { left: 0, right: LEAST_POINTS },
        bins: (0..END_M - FIRST_RING_M).map(bin).collect(),
    }
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
        let occupied: Vec<_> = counts.0.iter().enumerate().filter(|(_, n)| **n > 0).collect();
        assert_eq!(occupied, [(0, &2), (4, &1), (78, &1)]);
    }

    #[test]
    fn density_is_points_over_area_and_scans() {
        // The ring from 1 to 2 m covers 3π m².
        let scan = |n| counts_of(&vec![[1.5, 0.0, 0.0]; n]);
        let curves = ring_density(&Sides { left: vec![scan(6), scan(12)], right: vec![scan(99)] });
        let measured = curves.bins[0].measured;
        assert!((measured.left.value.unwrap() - 3.0 / PI).abs() < 1e-12);
        assert_eq!(measured.map(|it| it.n), Sides { left: 18, right: 99 });
        assert_eq!((curves.bins.len(), curves.bins[78].ends_m), (79, Some([79.0, 80.0])));
    }

    #[test]
    fn a_ring_has_a_ratio_from_a_hundred_points_on() {
        let scan = |n| counts_of(&vec![[1.5, 0.0, 0.0]; n]);
        let ratio = |n| ring_density(&Sides { left: vec![scan(50)], right: vec![scan(n)] }).ratio(0);
        assert_eq!((ratio(99), ratio(100)), (None, Some(0.5)));
    }
}
