//! Planes and quadrics by the methods of another library.

use detector::partial::local_surface::{NormalSigns, SurfaceParams};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, SymmetricEigen, Vector3};

use super::points::{neighbors, vector};

pub struct Surface {
    pub normal: Vector3<f64>,
    /// Ascending.
    pub harris: [f64; 2],
    /// Descending.
    pub curvatures: [f64; 2],
}

pub fn surfaces(points_m: &[[f64; 3]], params: &SurfaceParams) -> Vec<Surface> {
    let middle_m = mean(points_m);
    let of_point = |&point_m: &[f64; 3]| {
        let around = neighbors(points_m, point_m, params.radius_m, params.max_neighbors);
        let around: Vec<[f64; 3]> = around.into_iter().map(|it| points_m[it]).collect();
        let surface = surface(&around, point_m, params);
        let outward = (surface.normal.xy()).dot(&(vector(point_m) - middle_m).xy());
        let [first, second] = match params.normals {
            NormalSigns::Up => [surface.normal.z, outward],
            NormalSigns::Outward => [outward, surface.normal.z],
        };
        let decides = if first.abs() > 1e-6 { first } else { second };
        let normal = if decides < 0.0 { -surface.normal } else { surface.normal };
        Surface { normal, ..surface }
    };
    points_m.iter().map(of_point).collect()
}

fn mean(points_m: &[[f64; 3]]) -> Vector3<f64> {
    points_m.iter().map(|&it| vector(it)).sum::<Vector3<f64>>() / points_m.len() as f64
}

/// Axes of largest, middle and least spread.
pub fn axes(points_m: &[[f64; 3]]) -> [Vector3<f64>; 3] {
    let center_m = mean(points_m);
    let spread: Matrix3<f64> =
        points_m.iter().map(|&it| vector(it) - center_m).map(|it| it * it.transpose()).sum();
    let eigen = SymmetricEigen::new(spread);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axes = order.map(|it| eigen.eigenvectors.column(it).into_owned());
    let [largest, middle, _] = order.map(|it| eigen.eigenvalues[it]);
    if largest <= 0.0 {
        return [Vector3::x(), Vector3::y(), Vector3::z()];
    }
    if middle > 1e-9 * largest {
        return axes;
    }
    // A line: across it, and as upright as can be.
    let normal = Vector3::z() - axes[0] * axes[0].z;
    let normal = normal.try_normalize(1e-9).unwrap_or(Vector3::x());
    [axes[0], normal.cross(&axes[0]), normal]
}

fn surface(around_m: &[[f64; 3]], point_m: [f64; 3], params: &SurfaceParams) -> Surface {
    let [u, v, normal] = axes(around_m);
    let center_m = mean(around_m);
    let mut p = DVector::zeros(6);
    if around_m.len() >= 6 {
        // Damping as more rows: each would have one coefficient be nought.
        let n = around_m.len();
        let mut left = DMatrix::zeros(n + 5, 6);
        let mut right = DVector::zeros(n + 5);
        for (row, &it) in around_m.iter().enumerate() {
            let from_point = (vector(it) - vector(point_m)) / params.radius_m;
            let (x, y) = (from_point.dot(&u), from_point.dot(&v));
            let terms = [0.5 * x * x, x * y, 0.5 * y * y, x, y, 1.0];
            for (column, term) in terms.into_iter().enumerate() {
                left[(row, column)] = term;
            }
            right[row] = (vector(it) - center_m).dot(&normal) / params.radius_m;
        }
        for column in 0..5 {
            left[(n + column, column)] = params.damping.sqrt();
        }
        p = left.svd(true, true).solve(&right, 1e-9).expect("both bases were asked for");
    }
    let bends = Matrix2::new(p[0], p[1], p[1], p[2]);
    let slope = nalgebra::Vector2::new(p[3], p[4]);
    let harris = SymmetricEigen::new(slope * slope.transpose() + 2.0 * bends * bends).eigenvalues;
    let harris = [harris.min().max(0.0), harris.max()];
    // The shape operator: second over first fundamental form.
    let first_form = Matrix2::identity() + slope * slope.transpose();
    let shape =
        first_form.try_inverse().expect("it is positive") * bends / (1.0 + slope.norm_squared()).sqrt();
    let (mean, product) = (0.5 * shape.trace(), shape.determinant());
    let off = (mean * mean - product).max(0.0).sqrt();
    Surface { normal, harris, curvatures: [mean + off, mean - off] }
}
