//! Points, evened out, and their neighbours.

use std::collections::BTreeMap;

use detector::partial::thinned_points::ThinningParams;
use nalgebra::Vector3;

/// All points that are finite, by coordinates.
pub fn all(positions_m: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let finite = positions_m.iter().filter(|it| it.iter().all(|value| value.is_finite()));
    let mut sorted: Vec<[f64; 3]> = finite.map(|it| it.map(f64::from)).collect();
    sorted.sort_by(|a, b| a.partial_cmp(b).expect("they are finite"));
    sorted
}

/// The mean of the points of every cube. The cloud has to fit into the bound as it is.
pub fn thinned(positions_m: &[[f32; 3]], params: &ThinningParams) -> Vec<[f64; 3]> {
    let sorted = all(positions_m);
    if params.cube_m == 0.0 {
        return sorted;
    }
    let mut cubes: BTreeMap<[i64; 3], Vec<[f64; 3]>> = BTreeMap::new();
    for position_m in sorted {
        cubes.entry(position_m.map(|it| (it / params.cube_m).floor() as i64)).or_default().push(position_m);
    }
    let mean = |points: Vec<[f64; 3]>| {
        [0, 1, 2].map(|axis| points.iter().map(|it| it[axis]).sum::<f64>() / points.len() as f64)
    };
    let points_m: Vec<[f64; 3]> = cubes.into_values().map(mean).collect();
    assert!(points_m.len() <= params.max_points, "the reference does not grow cubes");
    points_m
}

/// The order that the detector gives them: by cubes of a radius, and in these by coordinates.
pub fn ordered(mut points_m: Vec<[f64; 3]>, radius_m: f64) -> Vec<[f64; 3]> {
    let cube = |it: &[f64; 3]| it.map(|value| (value / radius_m).floor() as i64);
    points_m.sort_by(|a, b| cube(a).cmp(&cube(b)).then_with(|| a.partial_cmp(b).expect("they are finite")));
    points_m
}

/// Indices of the points within a radius, ascending; of more than `max` as many, evenly spread.
pub fn neighbors(points_m: &[[f64; 3]], center_m: [f64; 3], radius_m: f64, max: usize) -> Vec<usize> {
    let near = |it: &usize| {
        let [x, y, z] = [0, 1, 2].map(|axis| points_m[*it][axis] - center_m[axis]);
        x * x + y * y + z * z <= radius_m * radius_m
    };
    let all: Vec<usize> = (0..points_m.len()).filter(near).collect();
    if all.len() <= max { all } else { (0..max).map(|it| all[it * all.len() / max]).collect() }
}

pub fn vector(point_m: [f64; 3]) -> Vector3<f64> {
    Vector3::from(point_m)
}
