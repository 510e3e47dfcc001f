//! All statistics of two collections of scans.

use reports::numbers::curve_pair::{CurvePair, Sides};

use super::cell_classes::cell_classes;
use super::height_histogram::height_histogram;
use super::points_per_car::{points_on_sides, points_per_car, rough_points};
use super::points_per_track::points_per_track;
use super::ring_density::ring_density;
use super::survey::SurveyedScan;
use super::whole_scans::{clusters_by_range, clusters_per_scan, ground_share, returns_per_scan};

/// The curves of every statistic, in the order of the table.
pub fn compare(scans: &Sides<Vec<SurveyedScan>>) -> Vec<CurvePair> {
    vec![
        returns_per_scan(&of_scans(scans, |it| it.n_returns)),
        ground_share(&of_scans(scans, |it| it.ground)),
        ring_density(&of_scans(scans, |it| it.rings.clone())),
        points_per_car(&of_scans(scans, |it| it.cars.clone())),
        points_on_sides(&of_scans(scans, |it| it.cars.clone())),
        rough_points(&of_scans(scans, |it| it.cars.clone())),
        points_per_track(&of_scans(scans, |it| it.cars.clone())),
        clusters_per_scan(&of_scans(scans, |it| it.cluster_ranges_m.clone())),
        clusters_by_range(&of_scans(scans, |it| it.cluster_ranges_m.clone())),
        height_histogram(&of_scans(scans, |it| it.heights.clone())),
        cell_classes(&of_scans(scans, |it| it.cells)),
    ]
}

/// The `finding` of every scan of both sides.
fn of_scans<T>(scans: &Sides<Vec<SurveyedScan>>, finding: impl Fn(&SurveyedScan) -> T) -> Sides<Vec<T>> {
    scans.as_ref().map(|scans| scans.iter().map(&finding).collect())
}
