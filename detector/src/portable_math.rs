//! Sine, cosine, arc tangent, logarithm and exponential from IEEE additions, multiplications, divisions and square roots
//! alone.
//!
//! The functions of the standard library call the platform's mathematics library, which may round differently on another
//! machine. Simulated scans, trained models and detections are computed with these instead, so that a seed or a scan gives
//! the same bytes on every x86-64 machine. They are accurate to about 1e-14, far beyond the f32 the results are rounded to;
//! those of [`single`] are right but for that rounding, and faster.

pub mod single;

use std::f64::consts::{FRAC_PI_2, LN_2, PI, SQRT_2};

/// Sine and cosine of `angle_rad`, which should be within a few thousand turns.
pub fn sin_cos(angle_rad: f64) -> (f64, f64) {
    let quarter_turns = (angle_rad / FRAC_PI_2).round();
    let rest = angle_rad - quarter_turns * FRAC_PI_2;
    let square = rest * rest;
    let sine = rest * alternating_series(square, 1.0, 9);
    let cosine = alternating_series(square, 0.0, 9);
    match (quarter_turns as i64).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// 1 − s/((o+1)(o+2)) + s²/((o+1)(o+2)(o+3)(o+4)) − …, which is cosine for `offset` 0 and sine over its angle for 1.
fn alternating_series(square: f64, offset: f64, n_terms: u32) -> f64 {
    let from_last = (1..=n_terms).rev();
    from_last.fold(1.0, |sum, term| {
        let order = 2.0 * f64::from(term) + offset;
        1.0 - square / (order * (order - 1.0)) * sum
    })
}

/// Angle of the vector (`x`, `y`) in radians, counter-clockwise from x, in −π to π; 0 for the zero vector.
pub fn atan2(y: f64, x: f64) -> f64 {
    if x == 0.0 && y == 0.0 {
        return 0.0;
    }
    let first_octant = atan_below_one(y.abs().min(x.abs()) / y.abs().max(x.abs()));
    let first_quadrant = if y.abs() > x.abs() { FRAC_PI_2 - first_octant } else { first_octant };
    let upper_half = if x < 0.0 { PI - first_quadrant } else { first_quadrant };
    if y < 0.0 { -upper_half } else { upper_half }
}

/// Arc tangent of 0 to 1: two halvings of the angle make the series short.
fn atan_below_one(tangent: f64) -> f64 {
    let half = |t: f64| t / (1.0 + (1.0 + t * t).sqrt());
    let quarter = half(half(tangent));
    let square = quarter * quarter;
    let series = (0..12_u32).rev().fold(0.0, |sum, term| 1.0 / f64::from(2 * term + 1) - square * sum);
    4.0 * quarter * series
}

/// Natural logarithm of a positive, normal `x`.
pub fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32 - 1023;
    let mantissa = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000);
    let (mantissa, exponent) =
        if mantissa > SQRT_2 { (mantissa / 2.0, exponent + 1) } else { (mantissa, exponent) };
    let ratio = (mantissa - 1.0) / (mantissa + 1.0);
    let square = ratio * ratio;
    let series = (0..12_u32).rev().fold(0.0, |sum, term| 1.0 / f64::from(2 * term + 1) + square * sum);
    f64::from(exponent) * LN_2 + 2.0 * ratio * series
}

/// The exponential function of `x` between −700 and 700.
pub fn exp(x: f64) -> f64 {
    let doublings = (x / LN_2).round();
    let rest = x - doublings * LN_2;
    let series = (1..16_u32).rev().fold(1.0, |sum, term| 1.0 + rest / f64::from(term) * sum);
    // The exponent of a double is offset by 1023.
    series * f64::from_bits(((doublings as i64 + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sine_and_cosine_agree_with_the_standard_library(angle_rad in -500.0_f64..500.0) {
            let (sine, cosine) = sin_cos(angle_rad);
            prop_assert!((sine - angle_rad.sin()).abs() < 1e-12);
            prop_assert!((cosine - angle_rad.cos()).abs() < 1e-12);
        }

        #[test]
        fn the_angle_of_a_vector_agrees_with_the_standard_library(x in -9.0_f64..9.0, y in -9.0_f64..9.0) {
            prop_assert!((atan2(y, x) - y.atan2(x)).abs() < 1e-12);
        }

        #[test]
        fn the_logarithm_agrees_with_the_standard_library(x in 1e-9_f64..1e9) {
            prop_assert!((ln(x) - x.ln()).abs() < 1e-12);
        }

        #[test]
        fn the_exponential_agrees_with_the_standard_library(x in -50.0_f64..50.0) {
            prop_assert!((exp(x) / x.exp() - 1.0).abs() < 1e-12);
        }
    }
}
