//! The axes along which points spread.

/// Mean of points, and the axes of their spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrincipalFrame {
    /// Mean of the points in metres.
    pub center_m: [f64; 3],
    /// Unit vectors of largest, middle and least spread, at right angles to each other.
    pub axes: [[f64; 3]; 3],
}

impl PrincipalFrame {
    /// The frame of these points; the axes of the coordinates without any spread. For points on a line the last axis is the
    /// one across it that is nearest to upright, or x for an upright line. `None` without points.
    pub fn around(points_m: impl Iterator<Item = [f64; 3]> + Clone) -> Option<Self> {
        let (mut n, mut sum) = (0.0, [0.0; 3]);
        for point_m in points_m.clone() {
            n += 1.0;
            sum = [sum[0] + point_m[0], sum[1] + point_m[1], sum[2] + point_m[2]];
        }
        if n == 0.0 {
            return None;
        }
        let center_m = sum.map(|it| it / n);
        let mut spread = [[0.0; 3]; 3];
        for point_m in points_m {
            let [x, y, z] = difference(point_m, center_m);
            spread[0][0] += x * x;
            spread[0][1] += x * y;
            spread[0][2] += x * z;
            spread[1][1] += y * y;
            spread[1][2] += y * z;
            spread[2][2] += z * z;
        }
        let (axes, [largest, middle, _]) = eigenvectors(spread);
        let is_line = largest > 0.0 && middle <= LEAST_SPREAD * largest;
        Some(Self { center_m, axes: if is_line { axes_of_line(axes[0]) } else { axes } })
    }

    /// The axis of least spread: the normal of the plane that fits best.
    pub fn normal(&self) -> [f64; 3] {
        self.axes[2]
    }
}

/// Points are a line if their squared spread across the main axis is at most this share of that along it.
const LEAST_SPREAD: f64 = 1e-9;

/// Axes of a line, whose points prefer no direction across it.
fn axes_of_line(along: [f64; 3]) -> [[f64; 3]; 3] {
    let [x, y, z] = along;
    let level = (x * x + y * y).sqrt();
    let normal = if level > LEAST_SPREAD { [-z * x / level, -z * y / level, level] } else { [1.0, 0.0, 0.0] };
    [along, cross(normal, along), normal]
}

/// Sweeps after which Jacobi's method ends in any case; it needs four or five.
const MOST_SWEEPS: usize = 12;
/// It ends when the elements beside the diagonal are at most this share of the trace.
const SMALL: f64 = 1e-14;

/// The eigenvectors of a symmetric matrix, of which the upper half is read, with their eigenvalues from the largest to the
/// least, by Jacobi's method.
fn eigenvectors(mut a: [[f64; 3]; 3]) -> ([[f64; 3]; 3], [f64; 3]) {
    // Columns are the vectors.
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let whole = a[0][0] + a[1][1] + a[2][2];
    for _ in 0..MOST_SWEEPS {
        if a[0][1].abs() + a[0][2].abs() + a[1][2].abs() <= SMALL * whole {
            break;
        }
        for [p, q] in [[0, 1], [0, 2], [1, 2]] {
            turn(&mut a, &mut vectors, p, q);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]).then(i.cmp(&j)));
    let axes = order.map(|column| [vectors[0][column], vectors[1][column], vectors[2][column]]);
    (axes, order.map(|it| a[it][it]))
}

/// One rotation, after which element `p`, `q` is nought; `p` < `q`.
#[inline(always)]
fn turn(a: &mut [[f64; 3]; 3], vectors: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let ratio = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let size = 1.0 / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
    let tangent = if ratio < 0.0 { -size } else { size };
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let off = a[p][q];
    a[p][p] -= tangent * off;
    a[q][q] += tangent * off;
    a[p][q] = 0.0;
    let r = 3 - p - q;
    let [low_p, high_p] = [r.min(p), r.max(p)];
    let [low_q, high_q] = [r.min(q), r.max(q)];
    let (rp, rq) = (a[low_p][high_p], a[low_q][high_q]);
    a[low_p][high_p] = cosine * rp - sine * rq;
    a[low_q][high_q] = sine * rp + cosine * rq;
    for row in vectors {
        let (vp, vq) = (row[p], row[q]);
        row[p] = cosine * vp - sine * vq;
        row[q] = sine * vp + cosine * vq;
    }
}

/// `a` − `b`.
#[inline(always)]
pub fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The scalar product.
#[inline(always)]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
#[inline(always)]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_lying_sheet_has_an_upright_normal() {
        let points = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 1.0, 1.0], [2.0, 1.0, 1.0]];
        let frame = PrincipalFrame::around(points.into_iter()).unwrap();
        assert_eq!(frame.center_m, [1.0, 0.5, 1.0]);
        assert_eq!(
            frame.axes.map(|axis| axis.map(f64::abs)),
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        );
    }

    #[test]
    fn no_points_have_no_frame_and_one_has_the_axes_of_the_coordinates() {
        assert_eq!(PrincipalFrame::around(std::iter::empty()), None);
        let frame = PrincipalFrame::around([[1.0, 2.0, 3.0]].into_iter()).unwrap();
        assert_eq!(frame.axes, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn the_normal_of_a_line_is_as_upright_as_can_be() {
        for ([x, y, z], expected) in [
            ([3.0, 4.0, 0.0], [0.0, 0.0, 1.0]),
            ([0.0, 0.0, 2.0], [1.0, 0.0, 0.0]),
            ([0.6, 0.0, 0.8], [-0.8, 0.0, 0.6]),
        ] {
            let ends = [[1.0, 1.0, 1.0], [1.0 + x, 1.0 + y, 1.0 + z]];
            let normal = PrincipalFrame::around(ends.into_iter()).unwrap().normal();
            let is_near = |sign: f64| normal.iter().zip(expected).all(|(a, b)| (sign * a - b).abs() < 1e-12);
            assert!(is_near(1.0) || is_near(-1.0), "{normal:?}");
        }
    }

    proptest! {
        #[test]
        fn axes_are_unit_vectors_at_right_angles_that_do_not_mix(
            points in prop::collection::vec(prop::array::uniform3(-2.0_f64..2.0), 4..30),
        ) {
            let PrincipalFrame { center_m, axes } = PrincipalFrame::around(points.iter().copied()).unwrap();
            for (i, a) in axes.into_iter().enumerate() {
                for (j, b) in axes.into_iter().enumerate() {
                    prop_assert!((dot(a, b) - f64::from(u8::from(i == j))).abs() < 1e-12);
                    let mixed: f64 = points.iter().map(|&it| difference(it, center_m)).map(|it| dot(it, a) * dot(it, b)).sum();
                    prop_assert!(i == j || mixed.abs() < 1e-9, "{mixed}");
                }
            }
            let spread = axes.map(|a| points.iter().map(|&it| dot(difference(it, center_m), a)).map(|it| it * it).sum::<f64>());
            prop_assert!(spread[0] >= spread[1] - 1e-9 && spread[1] >= spread[2] - 1e-9);
        }
    }
}
