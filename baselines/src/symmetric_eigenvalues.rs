//! Eigenvalues of symmetric 3 × 3 matrices, several side by side and equal to the bit on every machine.

/// Matrices side by side, so that one instruction serves several of them.
pub const LANES: usize = 8;

/// Upper triangles of `LANES` symmetric matrices, value by value: xx, yy, zz, xy, xz, yz.
pub type SymmetricMatrices = [[f32; LANES]; 6];

/// Off-diagonal values shrink with the square, and then the cube, of what they were; five rounds leave nothing of f32.
const N_ROUNDS: usize = 5;

/// The eigenvalues λ₁ ≥ λ₂ ≥ λ₃ of each of `matrices`, by Jacobi's rotations.
///
/// Only sums, products, quotients and roots are taken, which all machines round alike. Matrices must be finite.
pub fn symmetric_eigenvalues(matrices: &SymmetricMatrices) -> [[f32; LANES]; 3] {
    let [mut xx, mut yy, mut zz, mut xy, mut xz, mut yz] = *matrices;
    for _ in 0..N_ROUNDS {
        for lane in 0..LANES {
            rotate([&mut xx[lane], &mut yy[lane]], &mut xy[lane], [&mut xz[lane], &mut yz[lane]]);
            rotate([&mut xx[lane], &mut zz[lane]], &mut xz[lane], [&mut xy[lane], &mut yz[lane]]);
            rotate([&mut yy[lane], &mut zz[lane]], &mut yz[lane], [&mut xy[lane], &mut xz[lane]]);
        }
    }
    let mut values = [xx, yy, zz];
    for lane in 0..LANES {
        let [a, b, c] = values.map(|it| it[lane]);
        let (low, high) = in_order(a, b);
        let (middle, most) = in_order(high, c);
        let (least, middle) = in_order(low, middle);
        values[0][lane] = most;
        values[1][lane] = middle;
        values[2][lane] = least;
    }
    values
}

/// Turns the plane of two axes until their off-diagonal value is 0: `diagonal` are their diagonal values, `between` is their
/// off-diagonal value, and `to_third` are the off-diagonal values of each with the third axis.
#[inline]
fn rotate([a, b]: [&mut f32; 2], between: &mut f32, [to_a, to_b]: [&mut f32; 2]) {
    let difference = *b - *a;
    let root = (difference * difference + 4.0 * *between * *between).sqrt();
    // The smaller of both possible turns; where there is nothing to turn, the least of all numbers keeps 0 / 0 away.
    let denominator = difference + (root + f32::MIN_POSITIVE).copysign(difference);
    let tangent = 2.0 * *between / denominator;
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let sine = tangent * cosine;
    *a -= tangent * *between;
    *b += tangent * *between;
    *between = 0.0;
    (*to_a, *to_b) = (cosine * *to_a - sine * *to_b, sine * *to_a + cosine * *to_b);
}

/// The lesser and the greater of two numbers of which none is NaN; unlike `f32::min` and `f32::max` single instructions.
#[inline]
fn in_order(a: f32, b: f32) -> (f32, f32) {
    (if a < b { a } else { b }, if a < b { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, SymmetricEigen};
    use proptest::prelude::*;

    fn eigenvalues(matrix: [f32; 6]) -> [f32; 3] {
        symmetric_eigenvalues(&matrix.map(|it| [it; LANES])).map(|it| it[LANES - 1])
    }

    #[test]
    fn a_diagonal_is_put_in_order() {
        assert_eq!(eigenvalues([1.0, 3.0, 2.0, 0.0, 0.0, 0.0]), [3.0, 2.0, 1.0]);
        assert_eq!(eigenvalues([0.0; 6]), [0.0; 3]);
        assert_eq!(eigenvalues([2.0, 2.0, 2.0, 0.0, 0.0, 0.0]), [2.0; 3]);
    }

    #[test]
    fn a_line_askew_has_one_value() {
        // The outer product of (1, 2, 2), whose square is 9.
        let [first, second, third] = eigenvalues([1.0, 4.0, 4.0, 2.0, 2.0, 4.0]);
        assert!((first - 9.0).abs() < 1e-5 && second.abs() < 1e-5 && third.abs() < 1e-5);
    }

    proptest! {
        #[test]
        fn they_are_those_of_another_library(
            matrix in prop::array::uniform6(-1.0_f32..1.0), exponent in -6_i32..3,
        ) {
            let [xx, yy, zz, xy, xz, yz] = matrix.map(|it| it * 10.0_f32.powi(exponent));
            let other = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).map(f64::from);
            let mut expected: Vec<f64> = SymmetricEigen::new(other).eigenvalues.iter().copied().collect();
            expected.sort_by(|a, b| b.total_cmp(a));
            let tolerance = 1e-5 * 10.0_f64.powi(exponent);
            for (found, expected) in eigenvalues([xx, yy, zz, xy, xz, yz]).into_iter().zip(expected) {
                prop_assert!((f64::from(found) - expected).abs() < tolerance, "{found} against {expected}");
            }
        }
    }
}
