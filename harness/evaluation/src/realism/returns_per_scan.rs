//! How many pulses come back.

use detector::PointCloud;
use reports::numbers::curve_pair::{CurvePair, Sides};

use super::distribution::distribution;

/// Number of returns of a scan: its points, without those that mark missing returns by coordinates that are not finite.
pub fn n_returns(cloud: &PointCloud) -> u64 {
    cloud.positions_m().filter(|position_m| position_m.iter().all(|it| it.is_finite())).count() as u64
}

/// The spread of the returns per scan.
pub fn returns_per_scan(n_returns: &Sides<Vec<u64>>) -> CurvePair {
    CurvePair {
        statistic: "returns_per_scan",
        title: "returns per scan",
        bins_of: None,
        focus_m: None,
        unit: "points",
        counted: "scans",
        least_n: Sides { left: 1, right: 1 },
        bins: distribution(n_returns.as_ref().map(|scans| scans.iter().map(|&n| n as f64).collect())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_returns_are_none() {
        let cloud: PointCloud =
            [[1.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, f32::INFINITY, 0.0]]
                .into_iter()
                .collect();
        assert_eq!(n_returns(&cloud), 2);
    }

    #[test]
    fn the_ratio_of_the_medians_is_left_over_right() {
        let curves = returns_per_scan(&Sides { left: vec![100, 300, 200], right: vec![400] });
        assert_eq!((curves.bins[1].name.as_str(), curves.ratio(1)), ("median", Some(0.5)));
    }
}
