//! These functions for numbers of single precision: computed in double precision, and rounded.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Length of the vector (`x`, `y`).
#[inline]
pub fn hypot(x: f32, y: f32) -> f32 {
    let [x, y] = [x, y].map(f64::from);
    (x * x + y * y).sqrt() as f32
}

/// Sine and cosine of `angle_rad`, which should be within a few thousand turns.
#[inline]
pub fn sin_cos(angle_rad: f32) -> (f32, f32) {
    // Factorials of 3, 5, 7, 9, 11 and of 2, 4, 6, 8, 10, 12.
    const SINE: [f64; 5] = [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0];
    const COSINE: [f64; 6] =
        [-0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0, -1.0 / 3_628_800.0, 1.0 / 479_001_600.0];
    let angle_rad = f64::from(angle_rad);
    let quarter_turns = (angle_rad / FRAC_PI_2).round();
    let rest = angle_rad - quarter_turns * FRAC_PI_2;
    let square = rest * rest;
    let sine = rest * (1.0 + square * polynomial(square, &SINE));
    let cosine = 1.0 + square * polynomial(square, &COSINE);
    let (sine, cosine) = match (quarter_turns as i64).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    };
    (sine as f32, cosine as f32)
}

/// Tangent of `angle_rad`.
pub fn tan(angle_rad: f32) -> f32 {
    let (sine, cosine) = super::sin_cos(f64::from(angle_rad));
    (sine / cosine) as f32
}

/// Angle of the vector (`x`, `y`) in radians, counter-clockwise from x, in −π to π; 0 for the zero vector.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    if x == 0.0 && y == 0.0 {
        return 0.0;
    }
    let [x, y] = [x, y].map(f64::from);
    let first_octant = atan_below_one(y.abs().min(x.abs()) / y.abs().max(x.abs()));
    let first_quadrant = if y.abs() > x.abs() { FRAC_PI_2 - first_octant } else { first_octant };
    let upper_half = if x < 0.0 { std::f64::consts::PI - first_quadrant } else { first_quadrant };
    (if y < 0.0 { -upper_half } else { upper_half }) as f32
}

/// Arc tangent of 0 to 1.
#[inline]
fn atan_below_one(tangent: f64) -> f64 {
    // The odd numbers from 3 to 23.
    const SERIES: [f64; 11] = [
        -1.0 / 3.0,
        1.0 / 5.0,
        -1.0 / 7.0,
        1.0 / 9.0,
        -1.0 / 11.0,
        1.0 / 13.0,
        -1.0 / 15.0,
        1.0 / 17.0,
        -1.0 / 19.0,
        1.0 / 21.0,
        -1.0 / 23.0,
    ];
    // The tangent of an eighth of a half turn.
    const TAN_FRAC_PI_8: f64 = 0.414_213_562_373_095_05;
    let is_steep = tangent > TAN_FRAC_PI_8;
    let (from, rest) = if is_steep { (FRAC_PI_4, (tangent - 1.0) / (tangent + 1.0)) } else { (0.0, tangent) };
    let square = rest * rest;
    from + rest * (1.0 + square * polynomial(square, &SERIES))
}

/// Natural logarithm of a positive, normal `x`.
#[inline]
pub fn ln(x: f32) -> f32 {
    super::ln(f64::from(x)) as f32
}

/// Cubic root of a positive, normal `x`.
pub fn cbrt(x: f32) -> f32 {
    super::exp(super::ln(f64::from(x)) / 3.0) as f32
}

/// c₀ + c₁ x + c₂ x² + …
#[inline]
fn polynomial(x: f64, coefficients: &[f64]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Whether two values are the same but for rounding to single precision.
    fn agree(found: f32, expected: f64) -> bool {
        (f64::from(found) - expected).abs() <= 1e-9 + 6e-8 * expected.abs()
    }

    proptest! {
        #[test]
        fn they_agree_with_the_standard_library(x in -90.0_f32..90.0, y in -90.0_f32..90.0) {
            let [x64, y64] = [x, y].map(f64::from);
            prop_assert!(agree(hypot(x, y), x64.hypot(y64)));
            prop_assert!(agree(atan2(y, x), y64.atan2(x64)));
            let (sine, cosine) = sin_cos(x);
            prop_assert!(agree(sine, x64.sin()) && agree(cosine, x64.cos()));
        }

        #[test]
        fn they_agree_on_positive_values(x in 1e-6_f32..1e6) {
            let x64 = f64::from(x);
            prop_assert!(agree(ln(x), x64.ln()));
            prop_assert!(agree(cbrt(x), x64.cbrt()));
            let angle_rad = x.min(1.5);
            prop_assert!(agree(tan(angle_rad), f64::from(angle_rad).tan()));
        }
    }

    #[test]
    fn axes_and_cubes_are_exact() {
        assert_eq!((sin_cos(0.0), hypot(3.0, 4.0), cbrt(27.0), ln(1.0)), ((0.0, 1.0), 5.0, 3.0, 0.0));
        let angles_rad =
            [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 0.0)].map(|(y, x)| atan2(y, x));
        let [quarter, half] = [std::f32::consts::FRAC_PI_2, std::f32::consts::PI];
        assert_eq!(angles_rad, [0.0, quarter, half, -quarter, 0.0]);
    }
}
