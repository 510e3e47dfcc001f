//! A curved surface through the points around each point, and how much it changes there.

use serde::{Deserialize, Serialize};

use super::neighborhoods::{Nearby, Neighborhoods, keep_evenly};
use super::principal_frame::{PrincipalFrame, difference, dot};

/// Tuning of [`local_surface`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceParams {
    /// Points within this of a point are fitted, in metres: the paper's r.
    pub radius_m: f64,
    /// Most points that are fitted; of more, as many are taken that are evenly spread over the order.
    pub max_neighbors: usize,
    /// Damping of bends and slopes: as if so many points, each `radius_m` away, lay on the plane. With few points, noise
    /// would make wild surfaces.
    pub damping: f64,
    /// How the signs of normals are chosen.
    pub normals: NormalSigns,
}

/// How the signs of normals are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NormalSigns {
    /// Upward; normals that are level point away from the mean of the cloud.
    Up,
    /// Away from the mean of the cloud on the ground plan; normals without a level part point up.
    Outward,
}

/// The surface at a point. Lengths are in units of the radius that it was fitted in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalSurface {
    /// Unit vector of the plane through the points around.
    pub normal: [f64; 3],
    /// Eigenvalues λ₁ ≤ λ₂ of the Harris matrix.
    pub harris: [f64; 2],
    /// Principal curvatures, the larger one first.
    pub curvatures: [f64; 2],
}

/// Number of coefficients of a quadric.
const N_TERMS: usize = 6;
/// A pivot below this share of the largest makes the surface a plane.
const LEAST_PIVOT: f64 = 1e-9;

/// Fits a plane to the points `neighbors` of `point_m`, and over it the quadric
/// z = ½ p₁ x² + p₂ x y + ½ p₃ y² + p₄ x + p₅ y + p₆, with `point_m` above the origin.
///
/// Coordinates are divided by the radius first, so that slopes and bends can be added. Fewer than six points, and points
/// that leave the quadric undetermined, such as those on a line, are a plane. The sign of the normal is arbitrary.
///
/// The Harris matrix is that of Sipiran and Bustos 2011, equations 8 to 10: with Gaussian weights of variance 2, its
/// elements are p₄² + 2 p₁² + 2 p₂², p₅² + 2 p₂² + 2 p₃², p₄ p₅ + 2 p₁ p₂ + 2 p₂ p₃.
///
/// Paper: BG section 3.1.
pub fn local_surface(
    points_m: &[[f64; 3]],
    point_m: [f64; 3],
    neighbors: &[u32],
    params: &SurfaceParams,
) -> LocalSurface {
    let of_neighbors = neighbors.iter().map(|&it| points_m[it as usize]);
    let Some(frame) = PrincipalFrame::around(of_neighbors.clone()) else {
        return LocalSurface { normal: [0.0, 0.0, 1.0], harris: [0.0; 2], curvatures: [0.0; 2] };
    };
    let [u, v, normal] = frame.axes;
    let mut sums = QuadricSums::default();
    if neighbors.len() >= N_TERMS {
        let scale = 1.0 / params.radius_m;
        for it in of_neighbors {
            let from_point = difference(it, point_m);
            let above = dot(difference(it, frame.center_m), normal);
            sums.add([dot(from_point, u) * scale, dot(from_point, v) * scale, above * scale]);
        }
        sums.damp(params.damping);
    }
    let [p1, p2, p3, p4, p5, _] = sums.solve().unwrap_or_default();
    let a = p4 * p4 + 2.0 * p1 * p1 + 2.0 * p2 * p2;
    let b = p5 * p5 + 2.0 * p2 * p2 + 2.0 * p3 * p3;
    let c = p4 * p5 + 2.0 * p1 * p2 + 2.0 * p2 * p3;
    LocalSurface {
        normal,
        harris: symmetric_eigenvalues(a, b, c),
        curvatures: principal_curvatures([p1, p2, p3, p4, p5]),
    }
}

/// λ₁ ≤ λ₂ of the matrix with `a` and `b` on its diagonal and `c` beside it, which has no negative eigenvalue.
fn symmetric_eigenvalues(a: f64, b: f64, c: f64) -> [f64; 2] {
    let mean = 0.5 * (a + b);
    let half = 0.5 * (a - b);
    let off = (half * half + c * c).sqrt();
    [(mean - off).max(0.0), mean + off]
}

/// Principal curvatures of the quadric at the origin, the larger one first.
fn principal_curvatures([p1, p2, p3, p4, p5]: [f64; 5]) -> [f64; 2] {
    let square = 1.0 + p4 * p4 + p5 * p5;
    let gaussian = (p1 * p3 - p2 * p2) / (square * square);
    let mean =
        ((1.0 + p5 * p5) * p1 - 2.0 * p4 * p5 * p2 + (1.0 + p4 * p4) * p3) / (2.0 * square * square.sqrt());
    let off = (mean * mean - gaussian).max(0.0).sqrt();
    [mean + off, mean - off]
}

/// The normal equations of a quadric.
#[derive(Debug, Clone, Default)]
struct QuadricSums {
    matrix: [[f64; N_TERMS]; N_TERMS],
    right: [f64; N_TERMS],
}

impl QuadricSums {
    #[inline(always)]
    fn add(&mut self, [x, y, z]: [f64; 3]) {
        let terms = [0.5 * x * x, x * y, 0.5 * y * y, x, y, 1.0];
        for row in 0..N_TERMS {
            // An even number of columns, to add two at a time; nothing above the diagonal is read.
            let n_columns = (row | 1) + 1;
            for column in 0..n_columns {
                self.matrix[row][column] += terms[row] * terms[column];
            }
            self.right[row] += terms[row] * z;
        }
    }

    /// Damps all coefficients but the height, as so many points on the plane would.
    fn damp(&mut self, damping: f64) {
        for row in 0..N_TERMS - 1 {
            self.matrix[row][row] += damping;
        }
    }

    /// The coefficients, by the method of Cholesky. `None` if they are not determined.
    fn solve(mut self) -> Option<[f64; N_TERMS]> {
        let diagonal: [f64; N_TERMS] = std::array::from_fn(|it| self.matrix[it][it]);
        for (row, largest) in diagonal.into_iter().enumerate() {
            for column in 0..=row {
                let mut sum = self.matrix[row][column];
                for before in 0..column {
                    sum -= self.matrix[row][before] * self.matrix[column][before];
                }
                if row > column {
                    self.matrix[row][column] = sum / self.matrix[column][column];
                } else if sum > LEAST_PIVOT * largest {
                    self.matrix[row][row] = sum.sqrt();
                } else {
                    return None;
                }
            }
        }
        let mut solution = self.right;
        for row in 0..N_TERMS {
            for before in 0..row {
                solution[row] -= self.matrix[row][before] * solution[before];
            }
            solution[row] /= self.matrix[row][row];
        }
        for row in (0..N_TERMS).rev() {
            for after in row + 1..N_TERMS {
                solution[row] -= self.matrix[after][row] * solution[after];
            }
            solution[row] /= self.matrix[row][row];
        }
        Some(solution)
    }
}

/// The surfaces at all points of a cloud.
#[derive(Debug, Clone, Default)]
pub struct LocalSurfaces {
    surfaces: Vec<LocalSurface>,
    nearby: Nearby,
}

impl LocalSurfaces {
    /// Fits one at every point of `around`.
    pub fn fill(&mut self, around: &Neighborhoods, params: &SurfaceParams) {
        let points_m = around.points_m();
        let Self { surfaces, nearby } = self;
        let middle_m = mean_of(points_m);
        surfaces.clear();
        surfaces.extend(points_m.iter().map(|&point_m| {
            around.within(point_m, params.radius_m, nearby);
            keep_evenly(&mut nearby.found, params.max_neighbors);
            let surface = local_surface(points_m, point_m, &nearby.found, params);
            let normal = signed_normal(surface.normal, difference(point_m, middle_m), params.normals);
            LocalSurface { normal, ..surface }
        }));
    }

    /// The surface at each point.
    pub fn surfaces(&self) -> &[LocalSurface] {
        &self.surfaces
    }
}

/// The mean of these points; the origin without points.
pub fn mean_of(points_m: &[[f64; 3]]) -> [f64; 3] {
    let add = |sum: [f64; 3], it: &[f64; 3]| [sum[0] + it[0], sum[1] + it[1], sum[2] + it[2]];
    points_m.iter().fold([0.0; 3], add).map(|it| it / points_m.len().max(1) as f64)
}

/// A part of a normal below this does not count as a direction.
const LEAST_PART: f64 = 1e-6;

/// `normal` or its opposite, at a point with the offset `from_middle_m` from the mean of the cloud.
pub fn signed_normal(normal: [f64; 3], from_middle_m: [f64; 3], signs: NormalSigns) -> [f64; 3] {
    let outward = normal[0] * from_middle_m[0] + normal[1] * from_middle_m[1];
    let [first, second] = match signs {
        NormalSigns::Up => [normal[2], outward],
        NormalSigns::Outward => [outward, normal[2]],
    };
    let decides = if first.abs() > LEAST_PART { first } else { second };
    if decides < 0.0 { normal.map(|it| -it) } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params(radius_m: f64) -> SurfaceParams {
        SurfaceParams { radius_m, max_neighbors: 1000, damping: 0.0, normals: NormalSigns::Up }
    }

    /// The surface at the origin, through points over a square of the ground plan of half side 0.5 m.
    fn surface_at_origin(radius_m: f64, height_m: impl Fn(f64, f64) -> f64) -> LocalSurface {
        let steps = || (-5..=5).map(|it| f64::from(it) * 0.1);
        let points: Vec<[f64; 3]> =
            steps().flat_map(|x| steps().map(move |y| [x, y])).map(|[x, y]| [x, y, height_m(x, y)]).collect();
        let all: Vec<u32> = (0..points.len() as u32).collect();
        local_surface(&points, [0.0, 0.0, height_m(0.0, 0.0)], &all, &params(radius_m))
    }

    #[track_caller]
    fn check_near(found: [f64; 2], expected: [f64; 2], bound: f64) {
        assert!(
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= bound),
            "{found:?} is not {expected:?}"
        );
    }

    #[test]
    fn a_plane_has_no_corner_and_no_curvature_however_it_lies() {
        for slope in [0.0, 0.5, -2.0] {
            let surface = surface_at_origin(1.0, |x, _| slope * x);
            check_near(surface.harris, [0.0; 2], 1e-20);
            check_near(surface.curvatures, [0.0; 2], 1e-10);
            let length = (1.0 + slope * slope).sqrt();
            assert!((surface.normal[2].abs() - 1.0 / length).abs() < 1e-12);
        }
    }

    #[test]
    fn a_paraboloid_has_the_curvatures_of_its_sphere_in_units_of_the_radius() {
        // z = x²/4 + y²/4 touches a sphere of 2 m: half a unit of curvature at a radius of 1 m, one at 2 m. Its Harris
        // matrix is 2 p₁² on the diagonal.
        let surface = surface_at_origin(1.0, |x, y| 0.25 * (x * x + y * y));
        check_near(surface.curvatures.map(f64::abs), [0.5, 0.5], 1e-9);
        check_near(surface.harris, [0.5, 0.5], 1e-9);
        let surface = surface_at_origin(2.0, |x, y| 0.25 * (x * x + y * y));
        check_near(surface.curvatures.map(f64::abs), [1.0, 1.0], 1e-9);
        check_near(surface.harris, [2.0, 2.0], 1e-9);
    }

    #[test]
    fn a_saddle_bends_both_ways_and_a_trough_one_way() {
        let [first, second] = surface_at_origin(1.0, |x, y| 0.5 * x * x - 0.5 * y * y).curvatures;
        check_near([first, second], [1.0, -1.0], 1e-9);
        let trough = surface_at_origin(1.0, |x, _| 0.5 * x * x);
        check_near(
            trough.curvatures.map(f64::abs),
            if trough.curvatures[0] > 0.5 { [1.0, 0.0] } else { [0.0, 1.0] },
            1e-9,
        );
        check_near(trough.harris, [0.0, 2.0], 1e-9);
    }

    #[test]
    fn points_that_determine_no_quadric_are_a_plane() {
        let line: Vec<[f64; 3]> = (0..20).map(|it| [f64::from(it) * 0.1, 0.0, 0.0]).collect();
        let all: Vec<u32> = (0..20).collect();
        for neighbors in [&all[..], &all[..5], &all[..1], &[]] {
            let surface = local_surface(&line, line[0], neighbors, &params(1.0));
            assert_eq!((surface.harris, surface.curvatures), ([0.0; 2], [0.0; 2]));
        }
        let alike = vec![[1.0; 3]; 9];
        assert_eq!(local_surface(&alike, alike[0], &all[..9], &params(1.0)).harris, [0.0; 2]);
    }

    #[test]
    fn damping_makes_a_bend_smaller() {
        let bend = |damping: f64| {
            let points: Vec<[f64; 3]> = (-2..=2)
                .flat_map(|x| (-2..=2).map(move |y| [f64::from(x) * 0.2, f64::from(y) * 0.2]))
                .map(|[x, y]| [x, y, x * x])
                .collect();
            let all: Vec<u32> = (0..points.len() as u32).collect();
            local_surface(&points, [0.0; 3], &all, &SurfaceParams { damping, ..params(1.0) }).harris[1]
        };
        assert!(bend(0.0) > 1.1 * bend(0.05));
    }

    #[test]
    fn normals_point_up_or_outward() {
        let check =
            |normal, signs, expected| assert_eq!(signed_normal(normal, [2.0, 0.0, 0.0], signs), expected);
        check([0.0, 0.0, -1.0], NormalSigns::Up, [0.0, 0.0, 1.0]);
        check([-1.0, 0.0, 0.0], NormalSigns::Up, [1.0, 0.0, 0.0]);
        check([-0.6, 0.0, 0.8], NormalSigns::Up, [-0.6, 0.0, 0.8]);
        check([-0.6, 0.0, 0.8], NormalSigns::Outward, [0.6, 0.0, -0.8]);
        check([0.0, 0.0, -1.0], NormalSigns::Outward, [0.0, 0.0, 1.0]);
    }
}
