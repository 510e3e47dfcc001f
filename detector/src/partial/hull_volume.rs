//! The volume of the convex hull of points in space.

use super::principal_frame::{cross, difference, dot};

/// Buffers for one hull after another.
#[derive(Debug, Clone, Default)]
pub struct HullVolume {
    faces: Vec<Face>,
    seen_edges: Vec<[u32; 2]>,
}

/// A triangle of the hull; its corners turn counter-clockwise seen from outside.
#[derive(Debug, Clone, Copy)]
struct Face {
    corners: [u32; 3],
    normal: [f64; 3],
    offset: f64,
}

/// Points no farther outside than this share of the extent are on the hull.
const TOLERANCE: f64 = 1e-9;

impl HullVolume {
    /// The volume in cubic metres; 0 for fewer than four points, points on a line, and points in a plane.
    ///
    /// The hull grows from a tetrahedron point by point: the faces that a point sees make way for those between it and their
    /// rim.
    ///
    /// Paper: BG section 3.1.
    pub fn of(&mut self, points_m: &[[f64; 3]]) -> f64 {
        let Some((corners, tolerance_m)) = first_tetrahedron(points_m) else { return 0.0 };
        self.faces.clear();
        let [a, b, c, d] = corners;
        for corners in [[a, b, c], [a, c, d], [a, d, b], [b, d, c]] {
            self.faces.push(Face::new(points_m, corners));
        }
        for point_idx in 0..points_m.len() as u32 {
            if !corners.contains(&point_idx) {
                self.add(points_m, point_idx, tolerance_m);
            }
        }
        let from_m = points_m[a as usize];
        let volume = |face: &Face| {
            let [p, q, r] = face.corners.map(|it| difference(points_m[it as usize], from_m));
            dot(p, cross(q, r)) / 6.0
        };
        self.faces.iter().map(volume).sum::<f64>().max(0.0)
    }

    fn add(&mut self, points_m: &[[f64; 3]], point_idx: u32, tolerance_m: f64) {
        let Self { faces, seen_edges } = self;
        let point_m = points_m[point_idx as usize];
        seen_edges.clear();
        faces.retain(|face| {
            let is_seen = dot(face.normal, point_m) - face.offset > tolerance_m;
            if is_seen {
                let [a, b, c] = face.corners;
                seen_edges.extend([[a, b], [b, c], [c, a]]);
            }
            !is_seen
        });
        // An edge between two seen faces is there both ways; one on the rim is not.
        for &[a, b] in &*seen_edges {
            if !seen_edges.contains(&[b, a]) {
                faces.push(Face::new(points_m, [a, b, point_idx]));
            }
        }
    }
}

impl Face {
    fn new(points_m: &[[f64; 3]], corners: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|it| points_m[it as usize]);
        let normal = cross(difference(b, a), difference(c, a));
        let length = dot(normal, normal).sqrt();
        let normal = if length > 0.0 { normal.map(|it| it / length) } else { normal };
        Self { corners, normal, offset: dot(normal, a) }
    }
}

/// Four points that are far from each other, in an order in which the first three turn counter-clockwise seen from outside;
/// and the distance within which a point lies on a plane. `None` if all points are in a plane.
fn first_tetrahedron(points_m: &[[f64; 3]]) -> Option<([u32; 4], f64)> {
    let a_m = *points_m.first()?;
    let farthest = |measure: &dyn Fn([f64; 3]) -> f64| {
        let mut best = (0, 0.0);
        for (point_idx, &point_m) in points_m.iter().enumerate() {
            let measured = measure(point_m);
            if measured > best.1 {
                best = (point_idx, measured);
            }
        }
        best
    };
    let (b, squared_m) = farthest(&|it| dot(difference(it, a_m), difference(it, a_m)));
    let tolerance_m = TOLERANCE * squared_m.sqrt();
    let along = difference(points_m[b], a_m);
    let off_line = |it: [f64; 3]| cross(along, difference(it, a_m));
    let (c, squared_area) = farthest(&|it| dot(off_line(it), off_line(it)));
    let normal = off_line(points_m[c]);
    let area = squared_area.sqrt();
    let (d, height) = farthest(&|it| dot(normal, difference(it, a_m)).abs());
    if squared_m == 0.0 || area <= tolerance_m * squared_m.sqrt() || height <= tolerance_m * area {
        return None;
    }
    let [b, c, d] = [b as u32, c as u32, d as u32];
    let is_outside = dot(normal, difference(points_m[d as usize], a_m)) > 0.0;
    Some((if is_outside { [0, c, b, d] } else { [0, b, c, d] }, tolerance_m))
}

/// Volume of the tetrahedron of four points in cubic metres.
pub fn tetrahedron_m3([a, b, c, d]: [[f64; 3]; 4]) -> f64 {
    dot(difference(b, a), cross(difference(c, a), difference(d, a))).abs() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn volume(points_m: &[[f64; 3]]) -> f64 {
        HullVolume::default().of(points_m)
    }

    fn cube(side_m: f64) -> Vec<[f64; 3]> {
        (0..8).map(|it| [it & 1, it >> 1 & 1, it >> 2].map(|bit| f64::from(bit) * side_m)).collect()
    }

    #[test]
    fn a_cube_has_its_volume_whatever_lies_in_it_and_on_it() {
        assert!((volume(&cube(2.0)) - 8.0).abs() < 1e-9);
        let mut filled = cube(2.0);
        filled.extend([[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [2.0, 2.0, 2.0]]);
        assert!((volume(&filled) - 8.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_flat_or_thin_has_no_volume() {
        let line: Vec<[f64; 3]> =
            (0..9).map(|it| [0.1 * f64::from(it), 0.2 * f64::from(it), 0.3 * f64::from(it)]).collect();
        let sheet: Vec<[f64; 3]> =
            (0..9).map(|it| [f64::from(it % 3) * 0.1, f64::from(it / 3) * 0.1, 0.3]).collect();
        for points_m in [&line[..], &sheet, &[[1.0; 3]; 7], &cube(1.0)[..3], &[]] {
            assert_eq!(volume(points_m), 0.0);
        }
    }

    #[test]
    fn a_corner_of_a_cube_is_a_sixth_of_it() {
        assert_eq!(tetrahedron_m3([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), 1.0 / 6.0);
    }

    /// The volume by all triangles that have all points on one side, of points in general position.
    fn by_all_triangles(points_m: &[[f64; 3]]) -> f64 {
        let middle_m =
            points_m.iter().fold([0.0; 3], |sum, it| [sum[0] + it[0], sum[1] + it[1], sum[2] + it[2]]);
        let middle_m = middle_m.map(|it| it / points_m.len() as f64);
        let mut sum = 0.0;
        for a in 0..points_m.len() {
            for b in 0..a {
                for c in 0..b {
                    let [p, q, r] = [a, b, c].map(|it| points_m[it]);
                    let normal = cross(difference(q, p), difference(r, p));
                    let sides = || {
                        points_m
                            .iter()
                            .enumerate()
                            .filter(|(it, _)| ![a, b, c].contains(it))
                            .map(|(_, it)| dot(normal, difference(*it, p)))
                    };
                    if sides().all(|it| it > 0.0) || sides().all(|it| it < 0.0) {
                        sum += tetrahedron_m3([p, q, r, middle_m]);
                    }
                }
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn it_is_the_volume_within_all_outer_triangles(
            points_m in prop::collection::vec(prop::array::uniform3(-1.0_f64..1.0), 4..24),
        ) {
            let expected = by_all_triangles(&points_m);
            prop_assert!((volume(&points_m) - expected).abs() < 1e-9 * expected.max(1.0));
        }
    }
}
