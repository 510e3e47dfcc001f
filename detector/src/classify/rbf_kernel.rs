//! The Gaussian kernel, the same to the bit on every machine.

/// Vectors side by side, so that one instruction serves several of them: twice as many as fit into a register of AVX2,
/// because the machine would wait for one result after the other.
pub(super) const LANES: usize = 16;

/// `LANES` vectors of `D` values, value by value.
pub(super) type VectorBlock<const D: usize> = [[f32; LANES]; D];

/// Vectors in blocks; the last block is filled up with zeros.
pub(super) fn blocks_of<const D: usize>(vectors: &[[f32; D]]) -> Vec<VectorBlock<D>> {
    let block_of = |chunk: &[[f32; D]]| {
        std::array::from_fn(|value| {
            std::array::from_fn(|lane| chunk.get(lane).map_or(0.0, |vector| vector[value]))
        })
    };
    vectors.chunks(LANES).map(block_of).collect()
}

/// exp(−`gamma` ‖`vector` − v‖²) for every v of `block`.
#[inline(always)]
pub(super) fn rbf_kernel<const D: usize>(
    vector: &[f32; D],
    block: &VectorBlock<D>,
    gamma: f32,
) -> [f32; LANES] {
    let mut squared_distance = [0.0; LANES];
    for (&value, others) in vector.iter().zip(block) {
        for lane in 0..LANES {
            let difference = value - others[lane];
            squared_distance[lane] += difference * difference;
        }
    }
    exp_of_negative(squared_distance.map(|it| gamma * it))
}

/// exp(−x) for x ≥ 0, to seven digits; nought from x = 86 on.
///
/// The platform's own differs from machine to machine in the last bit, and serves one number at a time.
#[inline(always)]
fn exp_of_negative(x: [f32; LANES]) -> [f32; LANES] {
    use std::f32::consts::LOG2_E;
    const LEAST_WITHOUT_VALUE: f32 = 86.0;
    // A number added to it is rounded to a whole one, which then stands in the last bits of the sum.
    const ROUNDING: f32 = 12_582_912.0;
    // ln 2 in two parts, of which the first has so few digits that its whole multiples are exact.
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    // The series of exp: |rest| ≤ ½ ln 2, so that the next term is below 10⁻⁷ of the sum.
    const TERMS: [f32; 7] = [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
    let mut exp = [0.0; LANES];
    for lane in 0..LANES {
        let bounded = if x[lane] < LEAST_WITHOUT_VALUE { x[lane] } else { LEAST_WITHOUT_VALUE };
        let rounded = bounded * LOG2_E + ROUNDING;
        let halvings = rounded - ROUNDING;
        let rest = (halvings * LN_2_HIGH - bounded) + halvings * LN_2_LOW;
        let [mut mantissa, others @ ..] = TERMS;
        for term in others {
            mantissa = mantissa * rest + term;
        }
        // At most 124 are taken from an exponent of 127.
        let n_halvings = rounded.to_bits().wrapping_sub(ROUNDING.to_bits());
        let power = f32::from_bits(1.0_f32.to_bits().wrapping_sub(n_halvings << 23));
        exp[lane] = if x[lane] < LEAST_WITHOUT_VALUE { mantissa * power } else { 0.0 };
    }
    exp
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_ends_are_exact() {
        let mut x = [0.0; LANES];
        let mut expected = [1.0; LANES];
        (x[1], x[2], x[3]) = (86.0, 1e9, f32::INFINITY);
        (expected[1], expected[2], expected[3]) = (0.0, 0.0, 0.0);
        assert_eq!(exp_of_negative(x), expected);
    }

    proptest! {
        #[test]
        fn it_is_the_exponential_function(x in 0.0_f32..86.0) {
            let expected = (-f64::from(x)).exp();
            let relative = (f64::from(exp_of_negative([x; LANES])[3]) - expected).abs() / expected;
            prop_assert!(relative < 3e-7, "exp(-{x}): {relative:e}");
        }

        #[test]
        fn every_lane_holds_the_kernel_of_its_vector(
            vectors in prop::collection::vec(prop::array::uniform3(-2.0_f32..2.0), 1..20),
            at in prop::array::uniform3(-2.0_f32..2.0),
        ) {
            let blocks = blocks_of(&vectors);
            let kernels: Vec<f32> = blocks.iter().flat_map(|block| rbf_kernel(&at, block, 0.7)).collect();
            for (vector, kernel) in vectors.iter().zip(kernels) {
                let squared: f64 = vector.iter().zip(at).map(|(a, b)| f64::from(a - b).powi(2)).sum();
                prop_assert!((f64::from(kernel) - (-0.7 * squared).exp()).abs() < 1e-6);
            }
        }
    }
}
