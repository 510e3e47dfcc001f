//! Into how many pieces the foreground falls.

use baselines::kd_tree_components::{KdTreeScratch, kd_tree_components};
use detector::PointCloud;
use detector::pipeline::frame::Frame;
use detector::segment::clusters::Clusters;
use reports::numbers::curve_pair::{CurvePair, Sides};

use super::distribution::spread_of_counts;

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
    spread_of_counts("clusters_per_scan", "clusters of the foreground per scan", "clusters", n_clusters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realism::drawn_scan;

    #[test]
    fn the_car_and_the_post_of_the_drawn_scan_are_two_pieces() {
        assert_eq!(n_clusters(&drawn_scan::scan().cloud, &drawn_scan::frame()), 2);
    }
}
