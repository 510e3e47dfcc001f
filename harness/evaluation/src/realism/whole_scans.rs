//! What a whole scan comes to: how many pulses come back, how much is ground, into how many pieces the foreground falls.

use baselines::kd_tree_components::{KdTreeScratch, kd_tree_components};
use detector::PointCloud;
use detector::pipeline::frame::Frame;
use detector::segment::clusters::Clusters;
use detector::surface_class::SurfaceClass;
use reports::numbers::curve_pair::{CurvePair, Sides};

use super::distribution::{spread_of_counts, spread_over_scans};

/// The points of one scan, and those among them that are ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroundCount {
    /// Points of the ground, as the detectors' shared segmentation finds them.
    pub n_ground: u64,
    /// All points.
    pub n_points: u64,
}

impl GroundCount {
    /// Counts in the latest scan of `frame`.
    pub fn of(frame: &Frame) -> Self {
        let classes = frame.point_classes();
        let n_ground = classes.iter().filter(|&&class| class == SurfaceClass::Ground).count();
        Self { n_ground: n_ground as u64, n_points: classes.len() as u64 }
    }
}

/// The spread of the share of ground points over the scans; scans without points have none.
pub fn ground_share(counts: &Sides<Vec<GroundCount>>) -> CurvePair {
    let percent = |count: &GroundCount| 100.0 * count.n_ground as f64 / count.n_points as f64;
    let percents =
        |scans: &Vec<GroundCount>| scans.iter().filter(|count| count.n_points > 0).map(percent).collect();
    spread_over_scans("ground_share", "share of ground points", "%", counts.as_ref().map(percents))
}

/// Number of returns of a scan: its points, without those that mark missing returns by coordinates that are not finite.
pub fn n_returns(cloud: &PointCloud) -> u64 {
    cloud.positions_m().filter(|position_m| position_m.iter().all(|it| it.is_finite())).count() as u64
}

/// The spread of the returns per scan.
pub fn returns_per_scan(n_returns: &Sides<Vec<u64>>) -> CurvePair {
    spread_of_counts("returns_per_scan", "returns per scan", "points", n_returns)
}

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
    fn the_road_of_the_drawn_scan_is_ground_and_what_stands_on_it_is_not() {
        let frame = drawn_scan::frame();
        let expected = GroundCount { n_ground: drawn_scan::N_ROAD, n_points: drawn_scan::N_POINTS };
        assert_eq!(GroundCount::of(&frame), expected);
    }

    #[test]
    fn shares_are_per_scan_and_an_empty_scan_has_none() {
        let count = |n_ground, n_points| GroundCount { n_ground, n_points };
        let left = vec![count(1, 4), count(0, 0), count(3, 4), count(2, 4)];
        let curves = ground_share(&Sides { left, right: vec![count(1, 1)] });
        let values = curves.bins.iter().map(|bin| bin.measured.left.value.unwrap());
        assert!(values.eq([25.0, 50.0, 75.0]));
        assert_eq!(curves.bins[0].measured.left.n, 3);
    }

    #[test]
    fn missing_returns_are_none() {
        let cloud: PointCloud =
            [[1.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, f32::INFINITY, 0.0]]
                .into_iter()
                .collect();
        assert_eq!(n_returns(&cloud), 2);
    }

    #[test]
    fn the_car_and_the_post_of_the_drawn_scan_are_two_pieces() {
        assert_eq!(n_clusters(&drawn_scan::scan().cloud, &drawn_scan::frame()), 2);
    }
}
