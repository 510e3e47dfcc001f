//! How many pulses come back.

use detector::PointCloud;
use reports::numbers::curve_pair::{CurvePair, Sides};

use super::distribution::spread_of_counts;

/// Number of returns of a scan: its points, without those that mark missing returns by coordinates that are not finite.
pub fn n_returns(cloud: &PointCloud) -> u64 {
    cloud.positions_m().filter(|position_m| position_m.iter().all(|it| it.is_finite())).count() as u64
}

/// The spread of the returns per scan.
pub fn returns_per_scan(n_returns: &Sides<Vec<u64>>) -> CurvePair {
    spread_of_counts("returns_per_scan", "returns per scan", "points", n_returns)
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
}
