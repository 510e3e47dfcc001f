//! Angles between the normals of a patch: a point feature histogram.

use serde::{Deserialize, Serialize};

use super::principal_frame::{cross, difference, dot};

/// Number of bins: two for each of three angles.
pub const N_ANGLE_BINS: usize = 8;

/// Parameters of [`point_feature_histogram`] in model files; it has no choices.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AngleParams {
    /// Which pairs of points are counted.
    pub pairs: Pairs,
    /// Whether the signs of normals count.
    pub signs: AngleSigns,
}

/// Which pairs of points of a patch are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pairs {
    /// All, as in the histogram that the paper names.
    All,
}

/// Whether the signs of normals count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AngleSigns {
    /// Each angle has a bin for either sign.
    Count,
}

/// The shares of the pairs in the bins of α, φ and θ together, α in the highest bit; all 0 if there is no pair.
///
/// Of two points, the source is the one whose normal is nearer to the line between them (Rusu 2009), the first if both are
/// as near. With `d` from source to target, `u = n_s; v = u × d; w = u × v` and `α = v·n_t; φ = u·d; θ = atan(w·n_t,
/// u·n_t)`. v is a unit vector; a pair whose d lies along u has none and is left out, and so is one of the same position.
///
/// Paper: BG section 3.1, equations 2 and 3 (which print `w·n_t` for α).
pub fn point_feature_histogram(positions_m: &[[f64; 3]], normals: &[[f64; 3]]) -> [f64; N_ANGLE_BINS] {
    let mut counts = [0_u32; N_ANGLE_BINS];
    for b in 0..positions_m.len() {
        for a in 0..b {
            if let Some(bin) = bin_of([positions_m[a], positions_m[b]], [normals[a], normals[b]]) {
                counts[bin] += 1;
            }
        }
    }
    let n_pairs = f64::from(counts.iter().sum::<u32>().max(1));
    counts.map(|it| f64::from(it) / n_pairs)
}

/// The sine of the least angle: of a line to a normal, for there to be a plane through both, and of an angle with a sign.
const LEAST_SINE: f64 = 1e-6;

fn bin_of(ends_m: [[f64; 3]; 2], normals: [[f64; 3]; 2]) -> Option<usize> {
    clear_signs(ends_m, normals).or_else(|| exact_bin_of(ends_m, normals))
}

/// A sine or cosine above this is too large for rounding to change its sign.
const CLEAR: f64 = 1e-4;

/// The bin, if every sign is clear. It takes no square root, because scale changes no sign.
#[inline(always)]
fn clear_signs(ends_m: [[f64; 3]; 2], normals: [[f64; 3]; 2]) -> Option<usize> {
    let line = difference(ends_m[1], ends_m[0]);
    // Not less than the length of the line.
    let clear = CLEAR * (line[0].abs() + line[1].abs() + line[2].abs());
    let [first, second] = normals.map(|it| dot(it, line));
    let turned_by = second.abs() - first.abs();
    let (source, target, d, phi) = if turned_by > 0.0 {
        (normals[1], normals[0], line.map(|it| -it), -second)
    } else {
        (normals[0], normals[1], line, first)
    };
    let v = cross(source, d);
    let w = cross(source, v);
    let (alpha, theta_y) = (dot(v, target), dot(w, target));
    let is_clear = |value: f64| value.abs() > clear;
    // If α is clear, so is the plane through line and normal.
    let are_clear = is_clear(turned_by) && is_clear(phi) && is_clear(alpha) && is_clear(theta_y);
    let bits = [alpha, phi, theta_y].map(|it| usize::from(it > 0.0));
    are_clear.then_some(bits[0] << 2 | bits[1] << 1 | bits[2])
}

fn exact_bin_of(ends_m: [[f64; 3]; 2], normals: [[f64; 3]; 2]) -> Option<usize> {
    let line = difference(ends_m[1], ends_m[0]);
    let length_m = dot(line, line).sqrt();
    if length_m == 0.0 {
        return None;
    }
    let direction = line.map(|it| it / length_m);
    let [first, second] = normals.map(|it| dot(it, direction));
    let is_turned = second.abs() > first.abs();
    let (source, target, d, phi) = if is_turned {
        (normals[1], normals[0], direction.map(|it| -it), -second)
    } else {
        (normals[0], normals[1], direction, first)
    };
    let v = cross(source, d);
    let sine = dot(v, v).sqrt();
    if sine < LEAST_SINE {
        return None;
    }
    let v = v.map(|it| it / sine);
    let w = cross(source, v);
    let (alpha, theta_y) = (dot(v, target), dot(w, target));
    // On a plane all three are nought, but for rounding.
    let bits = [alpha, phi, theta_y].map(|it| it > -LEAST_SINE);
    Some(bits.into_iter().fold(0, |bin, bit| bin << 1 | usize::from(bit)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn check(ends_m: [[f64; 3]; 2], normals: [[f64; 3]; 2], expected: Option<usize>) {
        assert_eq!(bin_of(ends_m, normals), expected);
        let [a, b] = ends_m;
        let [m, n] = normals;
        // Which of the two comes first does not matter, unless their normals are as near to the line.
        if dot(m, difference(b, a)).abs() != dot(n, difference(b, a)).abs() {
            assert_eq!(bin_of([b, a], [n, m]), expected);
        }
    }

    #[test]
    fn a_known_pair() {
        // u = z, d = x: v = z × x = y, w = z × y = −x. The target's normal (0, 0.6, 0.8): α = 0.6, φ = 0, θ = atan(0, 0.8).
        let ends = [[0.0; 3], [2.0, 0.0, 0.0]];
        check(ends, [[0.0, 0.0, 1.0], [0.0, 0.6, 0.8]], Some(0b111));
        check(ends, [[0.0, 0.0, 1.0], [0.0, -0.6, 0.8]], Some(0b011));
        // Here the second is the source: its normal leans to the line. u = (0.8, 0, 0.6), d = −x, v = u × d = (0, −0.6, 0) →
        // −y, w = u × −y = (0.6, 0, −0.8); φ = −0.8, α = 0, θ = atan(−0.8, 0.6).
        check(ends, [[0.0, 0.0, 1.0], [0.8, 0.0, 0.6]], Some(0b100));
    }

    proptest! {
        #[test]
        fn clear_signs_are_the_signs(
            ends_m in prop::array::uniform2(prop::array::uniform3(-2.0_f64..2.0)),
            normals in prop::array::uniform2(prop::array::uniform3(-1.0_f64..1.0)),
            flattened in prop::array::uniform3(0..3),
        ) {
            // Often level or upright, so that some angles are nought.
            let flat = |it: [f64; 3]| [0, 1, 2].map(|axis| if flattened[axis] == 0 { 0.0 } else { it[axis] });
            let unit = |it: [f64; 3]| it.map(|value| value / dot(it, it).sqrt().max(1e-9));
            for (ends_m, normals) in [(ends_m, normals), (ends_m.map(flat), normals), (ends_m, normals.map(flat))] {
                let normals = normals.map(unit);
                let exact = exact_bin_of(ends_m, normals);
                if let Some(clear) = clear_signs(ends_m, normals) {
                    prop_assert_eq!(Some(clear), exact);
                }
                prop_assert_eq!(bin_of(ends_m, normals), exact);
            }
        }
    }

    #[test]
    fn signs_that_rounding_may_change_are_not_clear() {
        let ends_m = [[0.0; 3], [2.0, 0.0, 1.0]];
        assert_eq!(clear_signs(ends_m, [[0.0, 0.0, 1.0], [0.6, 0.64, 0.48]]), Some(0b101));
        assert_eq!(clear_signs(ends_m, [[0.0, 0.0, 1.0], [0.6, 1e-7, 0.8]]), None);
    }

    #[test]
    fn pairs_without_a_frame_are_left_out() {
        let up = [0.0, 0.0, 1.0];
        check([[0.0; 3], [0.0, 0.0, 1.0]], [up, up], None);
        check([[1.0; 3], [1.0; 3]], [up, [1.0, 0.0, 0.0]], None);
    }

    #[test]
    fn shares_add_up_to_one_or_are_nothing() {
        let positions_m = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let normals = [[0.0, 0.0, 1.0]; 3];
        let flat = point_feature_histogram(&positions_m, &normals);
        assert_eq!(flat, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(point_feature_histogram(&positions_m[..1], &normals[..1]), [0.0; N_ANGLE_BINS]);
    }
}
