//! What regrouping might make of clusters.

use detector::fit::convex_hull_box::ConvexHullBox;
use detector::regroup::cut_places::CutPlaces;
use detector::regroup::joinable::may_be_one;
use detector::regroup::regrouping_params::RegroupingParams;
use detector::{Detections, OrientedBox, PointCloud};

/// Parts are cut once more, and then no more.
const MOST_CUTS: u32 = 2;
/// Only what boxes are on the ground plan matters here.
const LEVEL_M: [f32; 2] = [0.0, 0.0];

/// The point indices, ascending, of the parts into which clusters of a scan may be cut, and of the pairs that may be
/// joined.
pub fn regroupings(cloud: &PointCloud, clusters: &Detections, params: &RegroupingParams) -> Vec<Vec<u32>> {
    let mut found = Vec::new();
    for cluster in clusters.iter() {
        cut(cloud, cluster.point_indices, params, MOST_CUTS, &mut found);
    }
    let mut box_fit = ConvexHullBox::default();
    let with_hull = |cluster: detector::Detection<'_>| {
        let positions_m = positions_m(cloud, cluster.point_indices);
        box_fit.fit(positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]), LEVEL_M);
        (cluster.bounding_box, box_fit.hull_m().to_vec())
    };
    let outlines: Vec<(OrientedBox, Vec<[f32; 2]>)> = clusters.iter().map(with_hull).collect();
    for (first, (a, a_hull_m)) in outlines.iter().enumerate() {
        for (second, (b, b_hull_m)) in outlines.iter().enumerate().skip(first + 1) {
            if may_be_one([(a, a_hull_m), (b, b_hull_m)], params) {
                let mut both =
                    [clusters.get(first).point_indices, clusters.get(second).point_indices].concat();
                both.sort_unstable();
                found.push(both);
            }
        }
    }
    found
}

fn cut(
    cloud: &PointCloud,
    point_indices: &[u32],
    params: &RegroupingParams,
    most_cuts: u32,
    found: &mut Vec<Vec<u32>>,
) {
    if most_cuts == 0 {
        return;
    }
    let positions_m = positions_m(cloud, point_indices);
    let on_plan_m = positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]);
    let Some(bounding_box) = ConvexHullBox::default().fit(on_plan_m, LEVEL_M) else {
        return;
    };
    for plane in CutPlaces::default().find(&positions_m, &bounding_box, params) {
        let is_before = |it: &u32| plane.is_before(cloud.position_m(*it as usize));
        let (before, behind): (Vec<u32>, Vec<u32>) = point_indices.iter().partition(|it| is_before(it));
        if before.len().min(behind.len()) >= params.min_points {
            for part in [before, behind] {
                cut(cloud, &part, params, most_cuts - 1, found);
                found.push(part);
            }
        }
    }
}

fn positions_m(cloud: &PointCloud, point_indices: &[u32]) -> Vec<[f32; 3]> {
    point_indices.iter().map(|&it| cloud.position_m(it as usize)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::params::HierarchicalParams;
    use detector::{DetectedClass, Detection};

    /// Points on the near side of a car of 4 m, from `start_m` on along x.
    fn side(start_m: f32) -> impl Iterator<Item = [f32; 3]> {
        (0..=40_u8).map(move |it| [start_m + 0.1 * f32::from(it), 5.0, -1.0])
    }

    #[test]
    fn a_row_is_cut_into_cars_and_neighbours_are_joined() {
        let params = HierarchicalParams::shipped().regrouping;
        let cloud: PointCloud = side(10.0).chain(side(14.6)).chain(side(18.8)).collect();
        let cluster = |point_indices| Detection {
            point_indices,
            bounding_box: ConvexHullBox::default()
                .fit(positions_m(&cloud, point_indices).iter().map(|&[x, y, _]| [x, y]), LEVEL_M)
                .unwrap(),
            class: DetectedClass::Object,
            score: None,
        };
        let cars: Vec<Vec<u32>> = vec![(0..41).collect(), (41..82).collect(), (82..123).collect()];
        let row: Vec<u32> = (0..123).collect();
        let parts = regroupings(&cloud, &[cluster(&row)].into_iter().collect(), &params);
        assert!(cars.iter().all(|car| parts.contains(car)), "{parts:?}");
        let apart: Detections = cars.iter().map(|it| cluster(it)).collect();
        // Only the last two are near enough.
        assert_eq!(regroupings(&cloud, &apart, &params), [(41..123).collect::<Vec<u32>>()]);
    }
}
