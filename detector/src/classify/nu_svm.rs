//! The decision of a trained classifier.

use super::rbf_kernel::{LANES, VectorBlock, blocks_of, rbf_kernel};
use super::svm_model::SvmModel;
use crate::vector_instructions::{HotLoop, vectorised};

/// Sums that are added up side by side.
const N_SUMS: usize = 8;

/// A ν support vector classifier of `D` values with a Gaussian kernel, ready to decide.
///
/// The time of a decision grows with the number of support vectors.
#[derive(Debug, Clone, PartialEq)]
pub struct NuSvm<const D: usize> {
    means: [f32; D],
    deviations: [f32; D],
    gamma: f32,
    rho: f32,
    /// Support vectors with their coefficients; those that fill up the last block have coefficient 0.
    support: Vec<(VectorBlock<D>, [f32; LANES])>,
}

impl<const D: usize> NuSvm<D> {
    /// The classifier that `model` describes.
    pub fn new(model: &SvmModel<D>) -> Self {
        let coefficients = model
            .coefficients
            .chunks(LANES)
            .map(|chunk| std::array::from_fn(|lane| chunk.get(lane).copied().unwrap_or(0.0)));
        Self {
            means: model.means,
            deviations: model.deviations,
            gamma: model.gamma,
            rho: model.rho,
            support: blocks_of(&model.support_vectors).into_iter().zip(coefficients).collect(),
        }
    }

    /// How far `vector` is on the side of the first class: the margin is at 1, the border at 0, and the second class
    /// below.
    ///
    /// Paper: VM section 5.
    pub fn decision(&self, vector: &[f32; D]) -> f32 {
        let standardised = std::array::from_fn(|idx| (vector[idx] - self.means[idx]) / self.deviations[idx]);
        vectorised(WeightedKernels { vector: &standardised, svm: self }) - self.rho
    }
}

/// The sum of the kernels between a standardised vector and all support vectors, each times its coefficient.
struct WeightedKernels<'a, const D: usize> {
    vector: &'a [f32; D],
    svm: &'a NuSvm<D>,
}

impl<const D: usize> HotLoop for WeightedKernels<'_, D> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let mut sums = [0.0; N_SUMS];
        for (block, coefficients) in &self.svm.support {
            let kernels = rbf_kernel(self.vector, block, self.svm.gamma);
            // Independent sums, so that an addition need not wait for the one before; their number is fixed, and with it the
            // order of additions on every machine.
            for lane in 0..LANES {
                sums[lane % N_SUMS] += coefficients[lane] * kernels[lane];
            }
        }
        sums.iter().sum()
    }
}
