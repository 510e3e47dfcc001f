//! Facts about one scan.

use std::f32::consts::PI;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use detector::PointCloud;
use reports::vocabulary::class::AnnotationClass;

use crate::annotation::{LabeledScan, PointRegion};

/// Points are counted between these distances, in metres on the ground plan.
pub const RANGES_M: [f32; 5] = [0.0, 10.0, 20.0, 40.0, 80.0];

/// The ground is looked for between these distances, in metres: the car is nearer, and slopes matter farther away.
const GROUND_RANGE_M: [f32; 2] = [4.0, 12.0];

/// The ground is looked for in squares of this side, in metres; a square counts if it has this many points.
const GROUND_SQUARE_M: f32 = 2.0;
const MIN_SQUARE_POINTS: usize = 5;

/// One scan in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanFacts {
    /// Points, with and without a position.
    pub n_points: usize,
    /// Points of the file without a position, which are left out.
    pub n_without_position: usize,
    /// Points at exactly the same position as another one.
    pub n_duplicates: usize,
    /// Points in each of the rings between [`RANGES_M`].
    pub n_by_range: [usize; RANGES_M.len() - 1],
    /// Height of the ground near the sensor, in metres; `None` if nothing is seen there.
    pub ground_z_m: Option<f32>,
    /// Points that the labels cover.
    pub n_labeled: usize,
    /// The annotations.
    pub annotations: Vec<AnnotationFacts>,
    /// A number that distinguishes scans: it is the same for the same points in the same order.
    pub fingerprint: u64,
}

/// One annotation in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct AnnotationFacts {
    /// Its class.
    pub class: AnnotationClass,
    /// Distance of the centre of its box, in metres on the ground plan; `None` if it has no box.
    pub box_range_m: Option<f32>,
    /// Number of its points.
    pub n_points: usize,
}

impl ScanFacts {
    /// Computes the facts of `scan`.
    pub fn of(scan: &LabeledScan) -> Self {
        let cloud = &scan.cloud;
        let annotations = scan.annotations.iter().map(|it| AnnotationFacts {
            class: it.class,
            box_range_m: it.bounding_box.map(|it| it.range_m()),
            n_points: it.point_indices.len(),
        });
        let mut hasher = DefaultHasher::new();
        let bits = |position_m: [f32; 3]| position_m.map(f32::to_bits);
        cloud.positions_m().for_each(|it| bits(it).hash(&mut hasher));
        let mut distinct: Vec<[u32; 3]> = cloud.positions_m().map(bits).collect();
        distinct.sort_unstable();
        distinct.dedup();
        Self {
            n_points: cloud.len() + scan.points_left_out.len(),
            n_without_position: scan.points_left_out.len(),
            n_duplicates: cloud.len() - distinct.len(),
            n_by_range: n_by_range(cloud),
            ground_z_m: ground_z_m(cloud),
            n_labeled: scan.point_regions.iter().filter(|it| **it == PointRegion::Labeled).count(),
            annotations: annotations.collect(),
            fingerprint: hasher.finish(),
        }
    }
}

fn n_by_range(cloud: &PointCloud) -> [usize; RANGES_M.len() - 1] {
    let mut n_by_range = [0; RANGES_M.len() - 1];
    for (x_m, y_m) in cloud.x_m().iter().zip(cloud.y_m()) {
        let range_m = x_m.hypot(*y_m);
        let ring = RANGES_M.windows(2).position(|ends| range_m >= ends[0] && range_m < ends[1]);
        if let Some(ring) = ring {
            n_by_range[ring] += 1;
        }
    }
    n_by_range
}

/// Area of each ring in square metres.
pub fn ring_areas_m2() -> [f32; RANGES_M.len() - 1] {
    std::array::from_fn(|ring| PI * (RANGES_M[ring + 1].powi(2) - RANGES_M[ring].powi(2)))
}

/// The median over squares near the sensor of a low height of each: a twentieth of its points are lower.
fn ground_z_m(cloud: &PointCloud) -> Option<f32> {
    let mut by_square: std::collections::BTreeMap<[i32; 2], Vec<f32>> = std::collections::BTreeMap::new();
    for position_m in cloud.positions_m() {
        let [x_m, y_m, z_m] = position_m;
        let range_m = x_m.hypot(y_m);
        if (GROUND_RANGE_M[0]..GROUND_RANGE_M[1]).contains(&range_m) {
            let square = [x_m, y_m].map(|it| (it / GROUND_SQUARE_M).floor() as i32);
            by_square.entry(square).or_default().push(z_m);
        }
    }
    let mut lowest_m: Vec<f32> = by_square
        .into_values()
        .filter(|heights_m| heights_m.len() >= MIN_SQUARE_POINTS)
        .map(|mut heights_m| {
            heights_m.sort_unstable_by(f32::total_cmp);
            heights_m[heights_m.len() / 20]
        })
        .collect();
    lowest_m.sort_unstable_by(f32::total_cmp);
    lowest_m.get(lowest_m.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotation::{LabeledArea, ScanId};
    use crate::dataset::positioned_points::PositionedPoints;

    fn facts(positions_m: &[[f32; 3]]) -> ScanFacts {
        let mut points = PositionedPoints::default();
        for position_m in positions_m {
            points.push(position_m.map(f64::from), 0.0).unwrap();
        }
        let (cloud, points_left_out) = points.into_parts();
        let point_regions = vec![PointRegion::Labeled; cloud.len()];
        let id = ScanId { sequence: "0".to_owned(), index: 0 };
        let labeled_area = LabeledArea::Everywhere;
        let annotations = Vec::new();
        ScanFacts::of(&LabeledScan { id, cloud, annotations, point_regions, labeled_area, points_left_out })
    }

    #[test]
    fn points_are_counted_once_for_each_ring() {
        let it =
            facts(&[[9.9, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, -50.0, 9.0], [80.0, 0.0, 0.0], [f32::NAN; 3]]);
        assert_eq!((it.n_by_range, it.n_points, it.n_without_position), ([1, 1, 0, 1], 5, 1));
        assert!((ring_areas_m2()[0] - 314.16).abs() < 0.01 && (ring_areas_m2()[1] - 942.48).abs() < 0.01);
    }

    #[test]
    fn duplicates_are_points_at_the_same_position() {
        let it = facts(&[[1.0; 3], [2.0; 3], [1.0; 3], [1.0; 3]]);
        assert_eq!(it.n_duplicates, 2);
        assert_ne!(it.fingerprint, facts(&[[1.0; 3], [1.0; 3], [1.0; 3], [2.0; 3]]).fingerprint);
    }

    #[test]
    fn the_ground_is_below_what_stands_on_it() {
        let mut positions_m = Vec::new();
        for step in 0..400 {
            let (x_m, y_m) = (4.0 + 0.4 * (step / 20) as f32, -4.0 + 0.4 * (step % 20) as f32);
            positions_m.push([x_m, y_m, -1.7]);
            positions_m.push([x_m, y_m, if step % 3 == 0 { 2.0 } else { -1.7 }]);
        }
        // Mirrored below the road.
        positions_m.push([6.0, 0.0, -9.0]);
        assert_eq!(facts(&positions_m).ground_z_m, Some(-1.7));
        assert_eq!(facts(&[[50.0, 0.0, -1.7]]).ground_z_m, None);
    }
}
