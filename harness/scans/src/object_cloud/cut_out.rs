//! One annotated object of a scan, cut out with the ground at height 0.

use detector::PointCloud;
use nalgebra::{Isometry3, Point3};

use crate::annotation::{Annotation, LabeledScan};

/// Parameters of the points that are cut out of scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutOutParams {
    /// Objects with fewer points are left out.
    pub least_points: usize,
    /// Points in a box that are less than this above its bottom are ground, in metres: boxes hold the ground that they stand
    /// on.
    pub box_floor_m: f32,
    /// Ground is searched for this far around the points of an object without a box, on the ground plan, in metres.
    pub ground_around_m: f32,
}

/// The share of the points around an object that lie below its ground: mirror echoes and noise.
const BELOW_GROUND: f32 = 0.1;
/// Points this much higher than the lowest point of the object are no ground, in metres.
const ABOVE_LOWEST_M: f32 = 0.5;
/// If fewer points are around it, the object stands on its own lowest point.
const LEAST_GROUND_POINTS: usize = 5;

impl CutOutParams {
    /// The default parameters.
    pub const USUAL: Self = Self { least_points: 20, box_floor_m: 0.15, ground_around_m: 1.0 };
}

/// The points of `annotation` in the frame of its box, x along its heading, and z from its bottom; `None` if it has no box.
///
/// In this frame moving objects stand still.
pub fn in_its_box(scan: &LabeledScan, annotation: &Annotation, params: &CutOutParams) -> Option<PointCloud> {
    let bounding_box = annotation.bounding_box?;
    let half_height_m = bounding_box.length_width_height_m[2] / 2.0;
    let mut cloud = PointCloud::with_capacity(annotation.point_indices.len());
    for &point_idx in &annotation.point_indices {
        let [along_m, across_m, up_m] = bounding_box.in_box_frame(scan.cloud.position_m(point_idx as usize));
        let z_m = up_m + half_height_m;
        if z_m >= params.box_floor_m {
            cloud.push([along_m, across_m, z_m], scan.cloud.intensity()[point_idx as usize]);
        }
    }
    Some(cloud)
}

/// The points of `annotation` in the world, by `world_from_sensor`, and the height of the ground under it there, in metres.
///
/// Ground are the low points around the object on the ground plan that belong to no annotation.
pub fn in_the_world(
    scan: &LabeledScan,
    is_annotated: &[bool],
    annotation: &Annotation,
    world_from_sensor: &Isometry3<f64>,
    params: &CutOutParams,
) -> (PointCloud, f32) {
    let position = |point_idx: usize| -> [f32; 3] {
        let position_m = scan.cloud.position_m(point_idx).map(f64::from);
        let [x_m, y_m, z_m]: [f64; 3] = (world_from_sensor * Point3::from(position_m)).coords.into();
        [x_m, y_m, z_m].map(|it| it as f32)
    };
    let mut cloud = PointCloud::with_capacity(annotation.point_indices.len());
    let (mut least_m, mut greatest_m) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for &point_idx in &annotation.point_indices {
        let position_m = position(point_idx as usize);
        for axis in 0..3 {
            least_m[axis] = least_m[axis].min(position_m[axis]);
            greatest_m[axis] = greatest_m[axis].max(position_m[axis]);
        }
        cloud.push(position_m, scan.cloud.intensity()[point_idx as usize]);
    }
    let around_m = params.ground_around_m;
    let is_near = |[x_m, y_m, z_m]: &[f32; 3]| {
        (least_m[0] - around_m..=greatest_m[0] + around_m).contains(x_m)
            && (least_m[1] - around_m..=greatest_m[1] + around_m).contains(y_m)
            && *z_m <= least_m[2] + ABOVE_LOWEST_M
    };
    let background = (0..scan.cloud.len()).filter(|point_idx| !is_annotated[*point_idx]);
    let mut heights_m: Vec<f32> = background.map(position).filter(is_near).map(|it| it[2]).collect();
    heights_m.sort_unstable_by(f32::total_cmp);
    let low = (heights_m.len() as f32 * BELOW_GROUND) as usize;
    let has_ground = heights_m.len() >= LEAST_GROUND_POINTS;
    // No object is below the ground that it stands on.
    let ground_m = if has_ground { heights_m[low].min(least_m[2]) } else { least_m[2] };
    (cloud, ground_m)
}

/// For every point of `scan`, whether it belongs to an annotation.
pub fn annotated_points(scan: &LabeledScan) -> Vec<bool> {
    let mut is_annotated = vec![false; scan.cloud.len()];
    for &point_idx in scan.annotations.iter().flat_map(|it| &it.point_indices) {
        is_annotated[point_idx as usize] = true;
    }
    is_annotated
}
