//! The described keypoints of an object, from its points.

use super::keypoints::Keypoints;
use super::local_surface::LocalSurfaces;
use super::neighborhoods::Neighborhoods;
use super::partial_params::PartialParams;
use super::patch_descriptor::{Descriptor, PatchDescriber};
use super::patterns::PatternKind;
use super::seen_extents::SeenExtents;
use super::shape_statistics::{ShapeMeter, ShapeStatistics};
use super::thinned_points::ThinnedPoints;

/// A keypoint and its descriptor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DescribedKeypoint {
    /// Position in metres, z above the ground.
    pub position_m: [f64; 3],
    /// Descriptor of the surface around it.
    pub descriptor: Descriptor,
}

/// Buffers for describing one cloud after another. Labels and later stages do not matter here.
#[derive(Debug, Clone, Default)]
pub struct KeypointDescriber {
    thinned: ThinnedPoints,
    around: Neighborhoods,
    surfaces: LocalSurfaces,
    keypoints: Keypoints,
    patches: PatchDescriber,
    shape_meter: ShapeMeter,
    described: DescribedCloud,
}

/// The results on a cloud that later stages need.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DescribedCloud {
    /// Extents of its thinned points; all 0 unless extents are counted.
    pub extents: SeenExtents,
    /// Shape statistics of all its points; all 0 unless these are counted.
    pub shape: ShapeStatistics,
    /// Its keypoints.
    pub keypoints: Vec<DescribedKeypoint>,
}

impl KeypointDescriber {
    /// The keypoints of an object with these points, in metres, in a frame with z up and the ground at z = 0. Their order is
    /// arbitrary but does not depend on that of the points.
    ///
    /// Paper: BG section 3.1.
    pub fn describe(
        &mut self,
        positions_m: impl Iterator<Item = [f32; 3]>,
        params: &PartialParams,
    ) -> &DescribedCloud {
        let Self { thinned, around, surfaces, keypoints, patches, shape_meter, described } = self;
        let PartialParams { thinning, surface, keypoints: keypoint_params, descriptor, patterns, .. } =
            params;
        thinned.fill(positions_m, thinning);
        around.fill(thinned.points_m(), surface.radius_m);
        surfaces.fill(around, surface);
        keypoints.fill(around, surfaces.surfaces(), surface.radius_m, keypoint_params);
        described.extents = if patterns.kinds.contains(&PatternKind::Extents) {
            SeenExtents::of(thinned.points_m().iter().copied())
        } else {
            SeenExtents::default()
        };
        described.shape = if patterns.kinds.contains(&PatternKind::ShapeStatistics) {
            shape_meter.measure(thinned.all_points_m())
        } else {
            ShapeStatistics::default()
        };
        described.keypoints.clear();
        described.keypoints.extend(keypoints.point_indices().iter().map(|&point_idx| {
            let descriptor = patches.describe(
                around,
                surfaces.surfaces(),
                point_idx,
                surface,
                keypoint_params,
                descriptor,
            );
            DescribedKeypoint { position_m: around.points_m()[point_idx as usize], descriptor }
        }));
        described
    }
}
