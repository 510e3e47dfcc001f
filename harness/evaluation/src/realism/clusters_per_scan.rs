//! Into how many pieces the foreground falls.

use baselines::kd_tree_components::{KdTreeScratch, kd_tree_components};
use detector::PointCloud;
use detector::pipeline::frame::Frame;
use detector::segment::clusters::Clusters;
use reports::numbers::curve_pair::{CurvePair, Sides};

use super::distribution::distribution;

/// Points nearer to each other than this hang together, in metres.
const TOLERANCE_M: f32 = 0.5;
/// Fewest points of a piece that counts.
const LEAST_POINTS: usize = 10;

/// Number of pieces, within a tolerance of 0.5 m and of at least ten points, of the foreground that `frame` has of
/// `cloud`.
pub fn n_clusters(cloud: &PointCloud, frame: &Frame) -> u64 {
    let foreground = frame.foreground.point_indices().iter();
    let positions_m: Vec<[f32; 3]> =
        foreground.map(|&point_idx| cloud.position_m(point_idx as usize)).collect();
    let mut labels = Vec::new();
    kd_tree_components(&positions_m, TOLERANCE_M, &mut KdTreeScratch::default(), &mut labels);
    let mut clusters = Clusters::default();
    clusters.group(labels.iter().copied(), labels.len());
    clusters.iter().filter(|members| members.len() >= LEAST_POINTS).count() as u64
}

/// The spread of the number of pieces over the scans.
pub fn clusters_per_scan(n_clusters: &Sides<Vec<u64>>) -> CurvePair {
    CurvePair {
        statistic: "clusters_per_scan",
        title: "clusters of the foreground per scan",
        bins_of: None,
        focus_m: None,
        unit: "clusters",
        counted: "scans",
        least_n: Sides { left: 1, right: 1 },
        bins: distribution(n_clusters.as_ref().map(|scans| scans.iter().map(|&n| n as f64).collect())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realism::drawn_scan;

    #[test]
    fn the_car_and_the_post_of_the_drawn_scan_are_two_pieces() {
        assert_eq!(n_clusters(&drawn_scan::scan().cloud, &drawn_scan::frame()), 2);
    }

    #[test]
    fn the_spread_is_over_scans() {
        let curves = clusters_per_scan(&Sides { left: vec![4, 2, 6], right: vec![8] });
        let ratios: Vec<_> = (0..3).map(|bin_idx| curves.ratio(bin_idx)).collect();
        assert_eq!(ratios, [Some(0.25), Some(0.5), Some(0.75)]);
    }
}
