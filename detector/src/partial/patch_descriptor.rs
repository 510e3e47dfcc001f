//! Descriptor of the surface around a keypoint: twelve numbers.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::hull_volume::HullVolume;
use super::keypoints::{KeypointParams, characteristic_radius};
use super::local_surface::{LocalSurface, SurfaceParams};
use super::neighborhoods::{Nearby, Neighborhoods, keep_evenly};
use super::point_pair_angles::{AngleParams, N_ANGLE_BINS, point_feature_histogram};
use super::principal_frame::{PrincipalFrame, dot};
use crate::portable_math::atan2;

/// Number of values.
pub const N_DESCRIPTOR_VALUES: usize = N_ANGLE_BINS + 4;

/// The values of a keypoint: the eight bins of the point feature histogram; the cosine between normals at two scales; the
/// modified shape index; ρ₂; the volume of the patch.
pub type Descriptor = [f64; N_DESCRIPTOR_VALUES];

/// Tuning of [`PatchDescriber`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DescriptorParams {
    /// The point feature histogram.
    pub angles: AngleParams,
    /// Most points of a patch; of more, as many are taken that are evenly spread over the order.
    pub max_points: usize,
    /// Radius of the small normal in units of the radius of surfaces.
    pub small_scale: f64,
    /// Radius of the large normal in units of the radius of surfaces.
    pub large_scale: f64,
    /// How the volume is written.
    pub volume: VolumeScale,
}

/// How the volume of a patch is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VolumeScale {
    /// In cubic metres.
    Cubic,
    /// As the square root of that: the volumes of thin and thick things lie too far apart for means and deviations.
    Root,
}

/// Buffers for one patch after another.
#[derive(Debug, Clone, Default)]
pub struct PatchDescriber {
    hull: HullVolume,
    nearby: Nearby,
    positions_m: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
}

impl PatchDescriber {
    /// The descriptor of the points within the radius of surfaces around point `point_idx`.
    ///
    /// Paper: BG section 3.1.
    pub fn describe(
        &mut self,
        around: &Neighborhoods,
        surfaces: &[LocalSurface],
        point_idx: u32,
        surface: &SurfaceParams,
        keypoint: &KeypointParams,
        params: &DescriptorParams,
    ) -> Descriptor {
        let center_m = around.points_m()[point_idx as usize];
        let cosine = self.normal_cosine(
            around,
            center_m,
            [params.small_scale, params.large_scale].map(|it| it * surface.radius_m),
        );
        around.within(center_m, surface.radius_m, &mut self.nearby);
        let neighbors = &mut self.nearby.found;
        keep_evenly(neighbors, params.max_points);
        self.positions_m.clear();
        self.positions_m.extend(neighbors.iter().map(|&it| around.points_m()[it as usize]));
        self.normals.clear();
        self.normals.extend(neighbors.iter().map(|&it| surfaces[it as usize].normal));
        let angles = point_feature_histogram(&self.positions_m, &self.normals);
        let LocalSurface { harris, curvatures, .. } = surfaces[point_idx as usize];
        let volume_m3 = self.hull.of(&self.positions_m);
        let mut values = [0.0; N_DESCRIPTOR_VALUES];
        values[..N_ANGLE_BINS].copy_from_slice(&angles);
        values[N_ANGLE_BINS..].copy_from_slice(&[
            cosine,
            modified_shape_index(curvatures),
            characteristic_radius(harris[1], [keypoint.min_sphere, keypoint.max_sphere]),
            match params.volume {
                VolumeScale::Cubic => volume_m3,
                VolumeScale::Root => volume_m3.sqrt(),
            },
        ]);
        values
    }

    /// The cosine between the normals of the points within two radii, without its sign: a plane has two normals. 1 if the
    /// smaller one has fewer than three points, which have none.
    ///
    /// Paper: BG equation 4.
    fn normal_cosine(&mut self, around: &Neighborhoods, center_m: [f64; 3], radii_m: [f64; 2]) -> f64 {
        let mut normals = [[0.0; 3]; 2];
        for (normal, radius_m) in normals.iter_mut().zip(radii_m) {
            around.within(center_m, radius_m, &mut self.nearby);
            if self.nearby.found.len() < 3 {
                return 1.0;
            }
            let points_m = self.nearby.found.iter().map(|&it| around.points_m()[it as usize]);
            *normal = PrincipalFrame::around(points_m).map_or([0.0; 3], |it| it.normal());
        }
        dot(normals[0], normals[1]).abs().min(1.0)
    }
}

/// |1/π · atan((k₁ + k₂) / (k₁ − k₂))|, from 0 for a saddle to 0.5 for a bowl; 0.5 where k₁ = k₂, on planes too.
///
/// Paper: BG equation 5.
pub fn modified_shape_index([first, second]: [f64; 2]) -> f64 {
    if first == second { 0.5 } else { atan2((first + second).abs(), (first - second).abs()) / PI }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partial::local_surface::{LocalSurfaces, NormalSigns};
    use crate::partial::point_pair_angles::{AngleSigns, Pairs};

    #[test]
    fn the_shape_index_distinguishes_saddles_troughs_and_bowls() {
        assert_eq!(modified_shape_index([1.0, -1.0]), 0.0);
        assert!((modified_shape_index([1.0, 0.0]) - 0.25).abs() < 1e-12);
        assert!((modified_shape_index([0.0, -1.0]) - 0.25).abs() < 1e-12);
        assert_eq!((modified_shape_index([1.0, 1.0]), modified_shape_index([0.0, 0.0])), (0.5, 0.5));
    }

    /// The descriptor in the middle of these points.
    fn described(points_m: &[[f64; 3]]) -> Descriptor {
        let surface =
            SurfaceParams { radius_m: 0.75, max_neighbors: 99, damping: 0.0, normals: NormalSigns::Up };
        let keypoint = KeypointParams { min_sphere: 0.0, max_sphere: 4.0 };
        let params = DescriptorParams {
            angles: AngleParams { pairs: Pairs::All, signs: AngleSigns::Count },
            max_points: 99,
            small_scale: 0.5,
            large_scale: 1.0,
            volume: VolumeScale::Cubic,
        };
        let mut around = Neighborhoods::default();
        around.fill(points_m, surface.radius_m);
        let mut surfaces = LocalSurfaces::default();
        surfaces.fill(&around, &surface);
        let mut describer = PatchDescriber::default();
        let from_middle = |it: &[f64; 3]| dot(*it, *it);
        let all = (0..).zip(around.points_m());
        let middle = all.min_by(|a, b| from_middle(a.1).total_cmp(&from_middle(b.1))).unwrap().0;
        describer.describe(&around, surfaces.surfaces(), middle, &surface, &keypoint, &params)
    }

    #[test]
    fn a_sheet_is_flat_in_every_value() {
        let steps = || (-2..=2).map(|it| f64::from(it) * 0.25);
        let sheet: Vec<[f64; 3]> = steps().flat_map(|x| steps().map(move |y| [x, y, 0.0])).collect();
        // All normals are the same, so that every pair is in the bin of α = 0, φ = 0, θ = 0.
        assert_eq!(described(&sheet), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 4.0, 0.0]);
    }

    #[test]
    fn a_block_has_the_volume_of_what_is_within_the_radius() {
        // A lattice of 27 points a quarter of a metre apart: half a metre wide, and all of it within 0.75 m of its middle.
        let steps = || (-1..=1).map(|it| f64::from(it) * 0.25);
        let block: Vec<[f64; 3]> =
            steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z]))).collect();
        assert!((described(&block)[11] - 0.125).abs() < 1e-12);
    }

    #[test]
    fn one_point_alone_has_a_descriptor() {
        assert_eq!(described(&[[0.5; 3]]), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.5, 4.0, 0.0]);
    }
}
