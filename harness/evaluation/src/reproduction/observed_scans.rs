//! Numbers of scans for figures of the papers that need no detections.

use detector::describe::box_frame_points::BoxFramePoints;
use detector::describe::corner_spheres::CornerSpheres;
use detector::grid::cell_fitness::CellTally;
use detector::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use detector::grid::ring_density::RingCounts;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{Annotation, LabeledScan};

use crate::scan_pass::{PassedScan, ScanPass, ScanPassError};

/// Cell sizes in metres: those of HG Fig. 6, and as many more.
pub const CELL_SIZES_M: [f32; 19] =
    [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0];

/// Fewest points of a car whose corner spheres are measured.
const LEAST_POINTS: usize = 200;

/// Numbers of one scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedScan {
    /// Tally of the cells for each of [`CELL_SIZES_M`]. HG Fig. 6 a.
    pub cells: Vec<CellTally>,
    /// Its points over range. HG Fig. 5.
    pub rings: RingCounts,
    /// Radius of the spheres at the front and at the back of each annotated car that is mostly seen, in metres. VM Fig. 6.
    pub spheres_m: Vec<[f32; 2]>,
}

/// Observes the scans of `pass`, in their order. The grids have the parameters of `grid` except the cell size; cells that
/// span more than `ground_extent_m` stand.
///
/// # Errors
///
/// As [`ScanPass::over`] says.
pub fn observe(
    pass: ScanPass<'_>,
    grid: &GridParams,
    ground_extent_m: f32,
) -> Result<Vec<ObservedScan>, ScanPassError> {
    let observed = |(): &mut (), PassedScan { scan, .. }: PassedScan<'_>| {
        let cells = CELL_SIZES_M.map(|cell_size_m| {
            let mut grid = HierarchicalGrid::new(GridParams { cell_size_m, xi: 1, ..grid.clone() });
            grid.fill(&scan.cloud);
            CellTally::of(&grid, ground_extent_m)
        });
        let spheres_m = scan.annotations.iter().filter_map(|it| spheres_of(scan, it)).collect();
        ObservedScan { cells: cells.to_vec(), rings: RingCounts::of(&scan.cloud), spheres_m }
    };
    pass.over(|| (), observed)
}

/// Radii of the spheres at the front and at the back of the annotated box, in metres; `None` if it is no car, or little of
/// it is seen.
fn spheres_of(scan: &LabeledScan, annotation: &Annotation) -> Option<[f32; 2]> {
    let bounding_box = annotation.bounding_box?;
    if annotation.class != AnnotationClass::Car || annotation.point_indices.len() < LEAST_POINTS {
        return None;
    }
    let mut points = BoxFramePoints::default();
    points.fill(&bounding_box, annotation.point_indices.iter().map(|&it| scan.cloud.position_m(it as usize)));
    let [length_m, width_m, _] = bounding_box.length_width_height_m;
    let [front_left, back_left, back_right, front_right] =
        CornerSpheres::around(&points, length_m, width_m)?.radii_m;
    // The nearest points to an unseen end are far away, whatever its shape.
    let [nearest_m, farthest_m] = points
        .along_m()
        .iter()
        .fold([f32::INFINITY, f32::NEG_INFINITY], |ends, &it| [ends[0].min(it), ends[1].max(it)]);
    let is_seen_whole = farthest_m - nearest_m >= 0.9 * length_m;
    // The hidden side has no points, so the smaller sphere of each end counts.
    is_seen_whole.then(|| [front_left.min(front_right), back_left.min(back_right)])
}

#[cfg(test)]
mod tests {
    use detector::{OrientedBox, PointCloud};
    use scans::annotation::ScanId;

    use super::*;

    /// A car of 4 m that is 0.8 m high at its front and 1.5 m behind, of which the left side is seen up to `end_m`.
    fn scan(end_m: f32) -> LabeledScan {
        let mut cloud = PointCloud::default();
        for step in 0..40_u8 {
            let along_m = -2.0 + 0.1 * f32::from(step);
            for level in 0..=15_u8 {
                let up_m = 0.1 * f32::from(level);
                if along_m <= end_m && (up_m <= 0.8 || along_m < 0.8) {
                    cloud.push([10.0 + along_m, 3.9, up_m - 1.7], 0.0);
                }
            }
        }
        let bounding_box = OrientedBox {
            center_m: [10.0, 3.0, -0.95],
            length_width_height_m: [4.0, 1.8, 1.5],
            yaw_rad: 0.0,
        };
        let (bounding_box, point_indices) = (Some(bounding_box), (0..cloud.len() as u32).collect());
        let car = Annotation { bounding_box, point_indices, ..Annotation::of(AnnotationClass::Car) };
        LabeledScan::everywhere(ScanId { sequence: "0".to_owned(), index: 0 }, cloud, vec![car])
    }

    #[test]
    fn a_bonnet_falls_away_from_its_corner() {
        let scan_of_all = scan(2.0);
        let [front_m, back_m] = spheres_of(&scan_of_all, &scan_of_all.annotations[0]).unwrap();
        // From (2, 0.9, 1.5 m up) to the bonnet 0.7 m below; at the back there is a point in the corner.
        assert!((front_m - 0.71).abs() < 0.01, "{front_m}");
        assert!(back_m < 0.01, "{back_m}");
    }

    #[test]
    fn a_car_of_which_an_end_is_not_seen_has_none() {
        let scan = scan(0.5);
        assert!(scan.annotations[0].point_indices.len() >= LEAST_POINTS);
        assert_eq!(spheres_of(&scan, &scan.annotations[0]), None);
    }
}
