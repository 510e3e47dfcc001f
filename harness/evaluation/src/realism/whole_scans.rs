//! Numbers of a whole scan: how many pulses return, the share of the ground, the number of clusters of the foreground.

use baselines::kd_tree_components::{KdTreeScratch, kd_tree_components};
use detector::PointCloud;
use detector::pipeline::frame::Frame;
use detector::segment::clusters::Clusters;
use detector::segment::foreground::Foreground;
use detector::surface_class::SurfaceClass;
use reports::numbers::curve_pair::{CurvePair, Measured, Sides};

use super::distribution::{spread_of_counts, spread_over_scans};
use super::points_per_car::{bin_of_range, range_bins};

/// Number of points of one scan, and of its ground points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroundCount {
    /// Points of the ground, as the detectors' shared segmentation finds them.
    pub n_ground: u64,
    /// All points.
    pub n_points: u64,
}

impl GroundCount {
    /// Counts in the latest scan of `frame`.
    pub fn of(frame: &Frame<Foreground>) -> Self {
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

/// Points nearer to each other than this belong to one cluster, in metres.
const TOLERANCE_M: f32 = 0.5;
/// Fewest points of a cluster that counts.
const LEAST_POINTS: usize = 10;

/// Distances on the ground plan of the clusters of the foreground of `frame`, in metres from the sensor to the mean of the
/// points; `cloud` is its scan. Clusters have at least ten points and a tolerance of 0.5 m.
pub fn cluster_ranges_m(cloud: &PointCloud, frame: &Frame<Foreground>) -> Vec<f64> {
    let foreground = frame.clustering.point_indices().iter();
    let positions_m: Vec<[f32; 3]> =
        foreground.map(|&point_idx| cloud.position_m(point_idx as usize)).collect();
    let mut labels = Vec::new();
    kd_tree_components(&positions_m, TOLERANCE_M, &mut KdTreeScratch::default(), &mut labels);
    let mut clusters = Clusters::default();
    clusters.group(labels.iter().copied(), labels.len());
    let range_m = |members: &[u32]| {
        let mean_m = |axis: usize| {
            let sum_m: f64 = members.iter().map(|&it| f64::from(positions_m[it as usize][axis])).sum();
            sum_m / members.len() as f64
        };
        mean_m(0).hypot(mean_m(1))
    };
    clusters.iter().filter(|members| members.len() >= LEAST_POINTS).map(range_m).collect()
}

/// The spread of the number of clusters over the scans.
pub fn clusters_per_scan(ranges_m: &Sides<Vec<Vec<f64>>>) -> CurvePair {
    let n_clusters = ranges_m.as_ref().map(|scans| scans.iter().map(|it| it.len() as u64).collect());
    spread_of_counts("clusters_per_scan", "clusters of the foreground per scan", "clusters", &n_clusters)
}

/// Mean number of clusters of a scan in every range bin: in a narrow street most are near.
pub fn clusters_by_range(ranges_m: &Sides<Vec<Vec<f64>>>) -> CurvePair {
    let measured = |bin_idx: usize| {
        ranges_m.as_ref().map(|scans| {
            let in_bin = scans.iter().flatten().filter(|it| bin_of_range(**it) == Some(bin_idx));
            let n = in_bin.count() as u64;
            Measured { value: (!scans.is_empty()).then(|| n as f64 / scans.len() as f64), n }
        })
    };
    CurvePair {
        statistic: "clusters_by_range",
        title: "mean number of clusters of the foreground in a scan",
        bins_of: Some("range"),
        focus_m: None,
        unit: "clusters",
        counted: "clusters",
        least_n: Sides { left: LEAST_CLUSTERS, right: LEAST_CLUSTERS },
        bins: range_bins(measured),
    }
}

/// Fewest clusters of a bin, on either side.
const LEAST_CLUSTERS: u64 = 5;

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
        let ranges_m = cluster_ranges_m(&drawn_scan::scan().cloud, &drawn_scan::frame());
        assert_eq!(ranges_m.len(), 2);
        let scans = || vec![vec![12.0, 12.4, 31.0], vec![14.9, 13.0, 11.0, 95.0]];
        let curves = clusters_by_range(&Sides { left: scans(), right: scans() });
        assert_eq!(curves.bins[2].measured.left, Measured { value: Some(2.5), n: 5 });
        assert_eq!(curves.ratio(2), Some(1.0));
        assert_eq!(curves.ratio(6), None, "one cluster in two scans");
    }
}
