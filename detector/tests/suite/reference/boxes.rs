//! The rectangle closest to the convex hull (VM section 4).

use std::f32::consts::{FRAC_PI_2, PI};

use detector::portable_math::single;
use detector::{OrientedBox, PointCloud};

use super::separation::Cluster;

/// The box of a cluster and its hull.
pub fn bounding_box(cloud: &PointCloud, cluster: &Cluster) -> (OrientedBox, Vec<[f32; 2]>) {
    let hull_m = convex_hull(boundary_points_m(cloud, cluster));
    let next = |corner: usize| hull_m[(corner + 1) % hull_m.len()];
    let rectangles = (0..hull_m.len()).map(|corner| Rectangle::along(hull_m[corner], next(corner), &hull_m));
    let best =
        rectangles.reduce(|best, it| if it.mean_distance_m < best.mean_distance_m { it } else { best });
    let z_m = cluster.points.iter().map(|&point_idx| cloud.z_m()[point_idx as usize]);
    let z_range_m = z_m.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
    (best.expect("clusters have points").upright(z_range_m), hull_m)
}

/// The points in dense cells that have a neighbour which is not the cluster's.
fn boundary_points_m(cloud: &PointCloud, cluster: &Cluster) -> Vec<[f32; 2]> {
    let dense = &cluster.points_of_dense;
    let boundary = dense.iter().filter(|(cell, _)| !cell.neighborhood().all(|it| dense.contains_key(&it)));
    let points = boundary.flat_map(|(_, points)| points);
    points.map(|&point_idx| cloud.position_m(point_idx as usize)).map(|[x, y, _]| [x, y]).collect()
}

/// Monotone chain.
fn convex_hull(mut points_m: Vec<[f32; 2]>) -> Vec<[f32; 2]> {
    points_m.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points_m.dedup();
    if points_m.len() < 3 {
        return points_m;
    }
    let lower = chain(points_m.iter());
    let upper = chain(points_m.iter().rev());
    [lower, upper].concat()
}

/// The left turns through sorted points, without the last.
fn chain<'a>(sorted_m: impl Iterator<Item = &'a [f32; 2]>) -> Vec<[f32; 2]> {
    let mut chain: Vec<[f32; 2]> = Vec::new();
    for &point_m in sorted_m {
        while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], point_m) <= 0.0 {
            chain.pop();
        }
        chain.push(point_m);
    }
    chain.pop();
    chain
}

/// Twice the signed area of the triangle.
fn turn(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f64 {
    let [ab, ac] = [b, c].map(|to| [0, 1].map(|axis| f64::from(to[axis]) - f64::from(a[axis])));
    ab[0] * ac[1] - ab[1] * ac[0]
}

/// A rectangle around the hull with a side along one of its edges.
struct Rectangle {
    direction: [f32; 2],
    /// Ends along the edge, and across it.
    along_m: [f32; 2],
    across_m: [f32; 2],
    /// Of the hull's corners from the nearest side.
    mean_distance_m: f32,
}

impl Rectangle {
    fn along(from_m: [f32; 2], to_m: [f32; 2], hull_m: &[[f32; 2]]) -> Self {
        let (dx, dy) = (to_m[0] - from_m[0], to_m[1] - from_m[1]);
        let length_m = single::hypot(dx, dy);
        let direction = if length_m > 0.0 { [dx / length_m, dy / length_m] } else { [1.0, 0.0] };
        let [ux, uy] = direction;
        let along: Vec<f32> = hull_m.iter().map(|[x, y]| x * ux + y * uy).collect();
        let across: Vec<f32> = hull_m.iter().map(|[x, y]| y * ux - x * uy).collect();
        let ends = |values: &[f32]| {
            let low = values.iter().copied().fold(f32::INFINITY, f32::min);
            [low, values.iter().copied().fold(f32::NEG_INFINITY, f32::max)]
        };
        let (along_m, across_m) = (ends(&along), ends(&across));
        let to_side = |value: f32, ends: [f32; 2]| (value - ends[0]).min(ends[1] - value);
        let distances =
            along.iter().zip(&across).map(|(&u, &v)| to_side(u, along_m).min(to_side(v, across_m)));
        let mean_distance_m = distances.fold(0.0, |sum_m, it| sum_m + it) / hull_m.len() as f32;
        Self { direction, along_m, across_m, mean_distance_m }
    }

    fn upright(&self, z_range_m: [f32; 2]) -> OrientedBox {
        let middle = |ends: [f32; 2]| 0.5 * (ends[0] + ends[1]);
        let [ux, uy] = self.direction;
        let (u, v) = (middle(self.along_m), middle(self.across_m));
        let sides_m = [self.along_m[1] - self.along_m[0], self.across_m[1] - self.across_m[0]];
        let quarter_turn = sides_m[0] < sides_m[1];
        let yaw_rad = if quarter_turn { single::atan2(uy, ux) + FRAC_PI_2 } else { single::atan2(uy, ux) };
        OrientedBox {
            center_m: [u * ux - v * uy, u * uy + v * ux, middle(z_range_m)],
            length_width_height_m: [
                sides_m[0].max(sides_m[1]),
                sides_m[0].min(sides_m[1]),
                z_range_m[1] - z_range_m[0],
            ],
            yaw_rad: within_half_turn(yaw_rad),
        }
    }
}

/// The yaw in (−π/2, π/2] of the same line.
fn within_half_turn(yaw_rad: f32) -> f32 {
    if yaw_rad > FRAC_PI_2 {
        within_half_turn(yaw_rad - PI)
    } else if yaw_rad <= -FRAC_PI_2 {
        within_half_turn(yaw_rad + PI)
    } else {
        yaw_rad
    }
}
