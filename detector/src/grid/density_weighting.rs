//! Cell counts as they would be at the range where points lie densest.

use serde::Deserialize;

use super::density_curve::DensityCurve;

/// Tuning of [`DensityWeighting`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DensityWeightingParams {
    /// Whether counts are weighted; if not, every weight is 1.
    pub enabled: bool,
    /// How the density falls with the range.
    pub curve: DensityCurve,
}

/// The weight of a cell by its range, for every metre.
///
/// Counts are divided by the weight, so that they can be compared whatever the range.
///
/// Paper: HG section 4.
#[derive(Debug, Clone)]
pub struct DensityWeighting {
    // At the middle of every metre from 0 on; the last holds for all farther ranges.
    weight_by_metre: Vec<f32>,
    peak_points_per_m2: f32,
}

/// The curve ends here, in metres.
const N_METRES: usize = super::ring_density::LAST_RING_END_M;

impl DensityWeighting {
    /// The weights of `params`.
    pub fn new(params: &DensityWeightingParams) -> Self {
        let weight = |metre: usize| {
            if params.enabled { params.curve.weight(metre as f64 + 0.5) as f32 } else { 1.0 }
        };
        Self {
            weight_by_metre: (0..N_METRES).map(weight).collect(),
            peak_points_per_m2: params.curve.peak_points_per_m2 as f32,
        }
    }

    /// The weight from the range of `metre` to that of the next, for every metre from 0 to 80 m.
    pub fn weight_by_metre(&self) -> &[f32] {
        &self.weight_by_metre
    }

    /// Points that a square metre holds where the weight is 1.
    pub fn peak_points_per_m2(&self) -> f32 {
        self.peak_points_per_m2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weighting(enabled: bool) -> DensityWeighting {
        let curve = DensityCurve::shipped("hdl-64e-s2").unwrap();
        DensityWeighting::new(&DensityWeightingParams { enabled, curve })
    }

    #[test]
    fn the_weight_of_a_metre_is_that_of_its_middle() {
        let curve = DensityCurve::shipped("hdl-64e-s2").unwrap();
        let weights = weighting(true);
        assert_eq!(weights.weight_by_metre().len(), 80);
        assert_eq!(weights.weight_by_metre()[20], curve.weight(20.5) as f32);
        assert_eq!(weights.peak_points_per_m2(), curve.peak_points_per_m2 as f32);
    }

    #[test]
    fn without_weighting_every_weight_is_one() {
        assert!(weighting(false).weight_by_metre().iter().all(|&weight| weight == 1.0));
    }
}
