//! Keypoints and what describes them.

use std::f64::consts::PI;

use detector::partial::partial_params::PartialParams;
use detector::partial::patch_descriptor::VolumeScale;
use nalgebra::Vector3;

use super::points::{neighbors, vector};
use super::surfaces::{Surface, axes};

/// Indices of the keypoints, ascending.
pub fn keypoints(points_m: &[[f64; 3]], surfaces: &[Surface], params: &PartialParams) -> Vec<usize> {
    let mut left: Vec<usize> = (0..points_m.len()).collect();
    let mut chosen = Vec::new();
    // The strongest of those that are left, the first of equals.
    while let Some(strongest) = left
        .iter()
        .copied()
        .reduce(|best, it| if surfaces[it].harris[0] > surfaces[best].harris[0] { it } else { best })
    {
        chosen.push(strongest);
        let sphere_m = params.surface.radius_m * radius(surfaces[strongest].harris[0], params);
        let within = neighbors(points_m, points_m[strongest], sphere_m, usize::MAX);
        left.retain(|it| *it != strongest && !within.contains(it));
    }
    chosen.sort_unstable();
    chosen
}

fn radius(eigenvalue: f64, params: &PartialParams) -> f64 {
    (2.0 / eigenvalue).sqrt().clamp(params.keypoints.min_sphere, params.keypoints.max_sphere)
}

pub fn descriptor(
    points_m: &[[f64; 3]],
    surfaces: &[Surface],
    point_idx: usize,
    params: &PartialParams,
) -> [f64; 12] {
    let center_m = points_m[point_idx];
    let radius_m = params.surface.radius_m;
    let normal_within = |scale: f64| {
        let around: Vec<[f64; 3]> = neighbors(points_m, center_m, radius_m * scale, usize::MAX)
            .into_iter()
            .map(|it| points_m[it])
            .collect();
        (around.len() >= 3).then(|| axes(&around)[2])
    };
    let cosine =
        match (normal_within(params.descriptor.small_scale), normal_within(params.descriptor.large_scale)) {
            (Some(small), Some(large)) => small.dot(&large).abs().min(1.0),
            _ => 1.0,
        };
    let patch = neighbors(points_m, center_m, radius_m, params.descriptor.max_points);
    let bins = histogram(points_m, surfaces, &patch);
    let [k1, k2] = surfaces[point_idx].curvatures;
    let shape_index = if k1 == k2 { 0.5 } else { (((k1 + k2) / (k1 - k2)).atan() / PI).abs() };
    let volume_m3 = hull_volume(&patch.iter().map(|&it| vector(points_m[it])).collect::<Vec<_>>());
    let volume = match params.descriptor.volume {
        VolumeScale::Cubic => volume_m3,
        VolumeScale::Root => volume_m3.sqrt(),
    };
    let mut values = [0.0; 12];
    values[..8].copy_from_slice(&bins);
    values[8..].copy_from_slice(&[
        cosine,
        shape_index,
        radius(surfaces[point_idx].harris[1], params),
        volume,
    ]);
    values
}

fn histogram(points_m: &[[f64; 3]], surfaces: &[Surface], patch: &[usize]) -> [f64; 8] {
    let mut counts = [0.0; 8];
    for (index, &b) in patch.iter().enumerate() {
        for &a in &patch[..index] {
            let [m, n] = [a, b].map(|it| (vector(points_m[it]), surfaces[it].normal));
            if let Some(bin) = bin(m, n) {
                counts[bin] += 1.0;
            }
        }
    }
    let sum: f64 = counts.iter().sum();
    counts.map(|it: f64| it / sum.max(1.0))
}

type PointWithNormal = (Vector3<f64>, Vector3<f64>);

fn bin(a: PointWithNormal, b: PointWithNormal) -> Option<usize> {
    let line = b.0 - a.0;
    let is_b_nearer = b.1.dot(&line).abs() > a.1.dot(&line).abs();
    let ((from_m, source), (to_m, target)) = if is_b_nearer { (b, a) } else { (a, b) };
    let d = (to_m - from_m).try_normalize(0.0)?;
    let v = source.cross(&d).try_normalize(1e-6)?;
    let w = source.cross(&v);
    let (alpha, phi) = (v.dot(&target), source.dot(&d));
    let theta = w.dot(&target).atan2(source.dot(&target));
    // What rounding makes of nought is nought.
    let is_positive = |it: f64| it > -1e-6;
    let bits = [is_positive(alpha), is_positive(phi), is_positive(theta.sin())];
    Some(4 * usize::from(bits[0]) + 2 * usize::from(bits[1]) + usize::from(bits[2]))
}

/// By all triangles that have all points on one side.
fn hull_volume(points_m: &[Vector3<f64>]) -> f64 {
    let middle_m = points_m.iter().sum::<Vector3<f64>>() / points_m.len() as f64;
    let mut volume_m3 = 0.0;
    for a in 0..points_m.len() {
        for b in 0..a {
            for c in 0..b {
                let [p, q, r] = [a, b, c].map(|it| points_m[it]);
                let normal = (q - p).cross(&(r - p));
                let others = (0..points_m.len()).filter(|it| ![a, b, c].contains(it));
                let sides: Vec<f64> = others.map(|it| normal.dot(&(points_m[it] - p))).collect();
                if sides.iter().all(|&it| it > 0.0) || sides.iter().all(|&it| it < 0.0) {
                    volume_m3 += normal.dot(&(middle_m - p)).abs() / 6.0;
                }
            }
        }
    }
    volume_m3
}
