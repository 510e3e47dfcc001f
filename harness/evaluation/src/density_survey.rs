//! Density of the rings around the sensor, scan by scan. A weight over range is learned from it.

use detector::grid::density_curve::{DensityCurve, LEAST_POINTS};
use detector::grid::ring_density::{FIRST_RING_M, N_RINGS, RingCounts, ring_middle_m};
use reports::numbers::curve_pair::{CurveBin, CurvePair, Measured, Sides};

use crate::scan_pass::{ScanPass, ScanPassError};

/// Counts the points in the rings of the scans of `pass`, in their order.
///
/// # Errors
///
/// As [`ScanPass::over`] says.
pub fn count_rings(pass: ScanPass<'_>) -> Result<Vec<RingCounts>, ScanPassError> {
    pass.over(|| (), |(), it| RingCounts::of(&it.scan.cloud))
}

/// The density by range and the weight by range, measured on the left, fitted on the right.
///
/// Paper: HG Figs 5 a and 5 b.
pub fn density_curves(curve: &DensityCurve, scans: &[RingCounts]) -> [CurvePair; 2] {
    let n_points = |ring_idx: usize| scans.iter().map(|it| it.n_points()[ring_idx]).sum::<u64>();
    let pair = |statistic, title, unit, per_unit: f64| {
        let bin = |ring_idx: usize| {
            let from_m = (FIRST_RING_M + ring_idx) as f64;
            let measured = |value: f64| Measured { value: Some(value / per_unit), n: n_points(ring_idx) };
            let fitted = curve.peak_points_per_m2 * curve.weight(ring_middle_m(ring_idx));
            CurveBin {
                name: format!("{from_m}-{} m", from_m + 1.0),
                ends_m: Some([from_m, from_m + 1.0]),
                measured: Sides {
                    left: measured(curve.ring_points_per_m2[ring_idx]),
                    right: measured(fitted),
                },
            }
        };
        CurvePair {
            statistic,
            title,
            bins_of: Some("range"),
            focus_m: None,
            unit,
            counted: "points",
            least_n: Sides { left: LEAST_POINTS, right: 0 },
            bins: (0..N_RINGS).map(bin).collect(),
        }
    };
    [
        pair("ring_density", "point density per scan", "points/m²", 1.0),
        pair("weight", "weight of a cell", "share of the densest ring", curve.peak_points_per_m2),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::grid::density_curve::CurveOrigin;

    #[test]
    fn both_figures_show_the_same_ratio_of_measured_and_fitted() {
        let n_points = std::array::from_fn(|ring_idx| 1_000_000 / (ring_idx as u64 + 1));
        let scans = [RingCounts::from_n_points(n_points)];
        let origin =
            CurveOrigin { sensor: String::new(), datasets: vec![], seeds: vec![], command: String::new() };
        let curve = DensityCurve::fit(&scans, origin).unwrap();
        let [density, weight] = density_curves(&curve, &scans);
        assert_eq!(weight.bins[0].measured.left, Measured { value: Some(1.0), n: 1_000_000 });
        assert_eq!(density.bins[0].measured.left.value, Some(curve.peak_points_per_m2));
        assert_eq!(weight.bins[78].measured.right.value, Some(curve.weight(79.5)));
        for ring_idx in 0..N_RINGS {
            let [of_density, of_weight] = [&density, &weight].map(|it| it.ratio(ring_idx).unwrap());
            assert!((of_density / of_weight - 1.0).abs() < 1e-12);
        }
    }
}
