//! Keypoints, where a surface turns most.

use serde::{Deserialize, Serialize};

use super::local_surface::LocalSurface;
use super::neighborhoods::{Nearby, Neighborhoods};

/// Tuning of [`Keypoints`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeypointParams {
    /// No sphere is smaller than this, in units of the radius of surfaces.
    pub min_sphere: f64,
    /// No sphere is larger than this, in units of the radius of surfaces; that of a plane is as large.
    pub max_sphere: f64,
}

/// √(2/`eigenvalue`), within bounds: the radius ρ, in units of the radius of surfaces.
///
/// Paper: BG equations 1 and 6.
pub fn characteristic_radius(eigenvalue: f64, [least, largest]: [f64; 2]) -> f64 {
    if eigenvalue > 0.0 { (2.0 / eigenvalue).sqrt().clamp(least, largest) } else { largest }
}

/// Buffers for one cloud after another.
#[derive(Debug, Clone, Default)]
pub struct Keypoints {
    strongest_first: Vec<(f64, u32)>,
    is_taken: Vec<bool>,
    in_sphere: Nearby,
    point_indices: Vec<u32>,
}

impl Keypoints {
    /// Chooses keypoints, the strongest first: the point with the largest λ₁ of all that lie in no sphere yet, until none is
    /// left. Its sphere has the radius ρ₁ = √(2/λ₁). Of equals the first is taken.
    ///
    /// Paper: BG section 3.1.
    pub fn fill(
        &mut self,
        around: &Neighborhoods,
        surfaces: &[LocalSurface],
        radius_m: f64,
        params: &KeypointParams,
    ) {
        let Self { strongest_first, is_taken, in_sphere, point_indices } = self;
        strongest_first.clear();
        strongest_first
            .extend(surfaces.iter().zip(0..).map(|(surface, point_idx)| (surface.harris[0], point_idx)));
        strongest_first.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        is_taken.clear();
        is_taken.resize(surfaces.len(), false);
        point_indices.clear();
        for &(lambda, point_idx) in &*strongest_first {
            if is_taken[point_idx as usize] {
                continue;
            }
            point_indices.push(point_idx);
            let sphere_m = radius_m * characteristic_radius(lambda, [params.min_sphere, params.max_sphere]);
            around.within(around.points_m()[point_idx as usize], sphere_m, in_sphere);
            for &it in &in_sphere.found {
                is_taken[it as usize] = true;
            }
        }
        point_indices.sort_unstable();
    }

    /// Indices of the keypoints among the points, ascending.
    pub fn point_indices(&self) -> &[u32] {
        &self.point_indices
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keypoints of points a metre apart on a line, with these λ₁.
    #[track_caller]
    fn check(lambdas: &[f64], params: &KeypointParams, expected: &[u32]) {
        let points_m: Vec<[f64; 3]> = (0..lambdas.len()).map(|it| [it as f64, 0.0, 0.0]).collect();
        let mut around = Neighborhoods::default();
        around.fill(&points_m, 1.0);
        let surface = |&lambda: &f64| LocalSurface {
            normal: [0.0, 0.0, 1.0],
            harris: [lambda, lambda],
            curvatures: [0.0; 2],
        };
        let surfaces: Vec<LocalSurface> = lambdas.iter().map(surface).collect();
        let mut keypoints = Keypoints::default();
        keypoints.fill(&around, &surfaces, 1.0, params);
        assert_eq!(keypoints.point_indices(), expected);
    }

    #[test]
    fn each_sphere_has_one_keypoint_the_strongest_first() {
        let unbounded = KeypointParams { min_sphere: 0.0, max_sphere: 100.0 };
        // ρ₁ of 2 is 1 m, of 0.5 is 2 m, of 8 is half a metre.
        check(&[0.1, 2.0, 0.2, 0.3, 0.4], &unbounded, &[1, 4]);
        check(&[8.0; 3], &unbounded, &[0, 1, 2]);
        check(&[0.5, 0.5, 0.5, 0.5, 0.5, 0.5], &unbounded, &[0, 3]);
        check(&[0.0; 5], &unbounded, &[0]);
        check(&[], &unbounded, &[]);
    }

    #[test]
    fn spheres_are_kept_within_bounds() {
        check(&[0.0; 5], &KeypointParams { min_sphere: 0.0, max_sphere: 1.0 }, &[0, 2, 4]);
        check(&[1e9; 5], &KeypointParams { min_sphere: 1.5, max_sphere: 9.0 }, &[0, 2, 4]);
    }
}
