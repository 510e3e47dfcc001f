//! How densely points lie, ring by ring around the sensor.

use detector::grid::ring_density::{FIRST_RING_M, N_RINGS, RingCounts, ring_area_m2};
use reports::numbers::curve_pair::{CurveBin, CurvePair, Measured, Sides};

/// The agreement between these ranges is reported separately: nearer the car's own roof matters, farther single walls.
const FOCUS_M: [f64; 2] = [5.0, 50.0];
/// Fewest points of a ring on the right: its density is then known to a tenth.
const LEAST_POINTS: u64 = 100;

/// Points per square metre and scan in every ring, over all scans together.
pub fn ring_density(counts: &Sides<Vec<RingCounts>>) -> CurvePair {
    let bin = |ring_idx: usize| {
        let from_m = (FIRST_RING_M + ring_idx) as f64;
        CurveBin {
            name: format!("{from_m}-{} m", from_m + 1.0),
            ends_m: Some([from_m, from_m + 1.0]),
            measured: counts.as_ref().map(|scans| {
                let n: u64 = scans.iter().map(|it| it.n_points()[ring_idx]).sum();
                let density = n as f64 / (ring_area_m2(ring_idx) * scans.len() as f64);
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
        bins: (0..N_RINGS).map(bin).collect(),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn scan(n: usize) -> RingCounts {
        RingCounts::of(&std::iter::repeat_n([1.5, 0.0, 0.0], n).collect())
    }

    #[test]
    fn density_is_points_over_area_and_scans() {
        // The ring from 1 to 2 m covers 3π m².
        let curves = ring_density(&Sides { left: vec![scan(6), scan(12)], right: vec![scan(99)] });
        let measured = curves.bins[0].measured;
        assert!((measured.left.value.unwrap() - 3.0 / PI).abs() < 1e-12);
        assert_eq!(measured.map(|it| it.n), Sides { left: 18, right: 99 });
        assert_eq!((curves.bins.len(), curves.bins[78].ends_m), (79, Some([79.0, 80.0])));
    }

    #[test]
    fn a_ring_has_a_ratio_from_a_hundred_points_on() {
        let ratio = |n| ring_density(&Sides { left: vec![scan(50)], right: vec![scan(n)] }).ratio(0);
        assert_eq!((ratio(99), ratio(100)), (None, Some(0.5)));
    }
}
