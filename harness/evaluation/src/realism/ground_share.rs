//! How much of a scan is ground.

use detector::pipeline::frame::Frame;
use detector::surface_class::SurfaceClass;
use reports::numbers::curve_pair::{CurvePair, Sides};

use super::distribution::spread_over_scans;

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
}
