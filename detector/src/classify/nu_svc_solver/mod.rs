//! Training of a ν support vector classifier.

mod descent;

use super::kernel_rows::KernelRows;
use descent::Problem;

/// Tuning of [`solve_nu_svc`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NuSvcParams {
    /// Width of the Gaussian kernel exp(−γ ‖a − b‖²).
    pub gamma: f32,
    /// Upper bound of the share of vectors inside the margin, lower bound of the share of support vectors.
    pub nu: f64,
    /// Distance from the optimum at which training may stop.
    pub tolerance: Tolerance,
    /// Steps after which training gives up.
    pub max_steps: usize,
}

/// Distance from the optimum at which training may stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// Decision values may be so far off; the margin is 1.
    OfMargin(f64),
    /// The gradients of the dual problem may be so far off, as in the libraries; the kernel is at most 1. With small ν and
    /// noise this is reached long before the least objective.
    OfGradients(f64),
}

/// A trained classifier: `decision(v) = Σ coefficient k(v, vector) − rho`, positive for the first class.
#[derive(Debug, Clone, PartialEq)]
pub struct NuSvcSolution {
    /// One for each vector, of the sign of its class; 0 if it is no support vector. Their sum is 0.
    pub coefficients: Vec<f64>,
    /// Offset of the decision.
    pub rho: f64,
    /// ½ αᵀQα at the end, α in 0 to 1 and summing up to ν times the number of vectors.
    pub objective: f64,
    /// Steps it took.
    pub n_steps: usize,
}

/// Why there is no classifier.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NuSvcError {
    /// Vectors without labels, or the other way round.
    #[error("there are {n_vectors} vectors but {n_labels} labels")]
    LabelCount {
        /// Number of vectors.
        n_vectors: usize,
        /// Number of labels.
        n_labels: usize,
    },
    /// A vector that has no distance to others.
    #[error("vector {vector_idx} is not finite")]
    NotFinite {
        /// Its index.
        vector_idx: usize,
    },
    /// Too few vectors of one class for this ν, or none.
    #[error(
        "nu = {nu} is not within 0 to {largest}, the largest value for {n_first} against {n_second} vectors"
    )]
    Nu {
        /// The ν asked for.
        nu: f64,
        /// The largest possible.
        largest: f64,
        /// Vectors of the first class.
        n_first: usize,
        /// Vectors of the second class.
        n_second: usize,
    },
    /// The two classes have, as far as ν lets them differ, the same mean.
    #[error("no margin separates the classes after {n_steps} steps")]
    NoMargin {
        /// Steps taken.
        n_steps: usize,
    },
    /// The end was not reached.
    #[error("training did not converge in {n_steps} steps: decision values are still {deviation} off")]
    NotConverged {
        /// Steps taken.
        n_steps: usize,
        /// Largest deviation, where the margin is 1.
        deviation: f64,
    },
}

/// Trains on `vectors`, of which `is_first` says for each whether it is of the first class.
///
/// The dual problem of Schölkopf et al. 2000, `min ½ αᵀQα` with α within 0 to 1 and `ν n / 2` in either class, by sequential
/// minimal optimisation: two multipliers of one class at a time, chosen by second-order gain (Fan, Chen, Lin 2005). A
/// tolerance that is relative to the margin is the safe one: with small ν and noise the margin is so small that a fixed
/// tolerance ends long before the least objective. The result depends on the order of the vectors, in the last digits, and
/// on nothing else.
///
/// # Errors
///
/// [`NuSvcError`] if labels or values are unusable, ν is too large for the smaller class, or no solution was reached.
///
/// Paper: VM section 5.
pub fn solve_nu_svc<const D: usize>(
    vectors: &[[f32; D]],
    is_first: &[bool],
    params: &NuSvcParams,
) -> Result<NuSvcSolution, NuSvcError> {
    check(vectors, is_first, params.nu)?;
    // First the one class, then the other, so that each is a range.
    let mut order: Vec<usize> = (0..vectors.len()).collect();
    order.sort_by_key(|&vector_idx| !is_first[vector_idx]);
    let sorted: Vec<[f32; D]> = order.iter().map(|&vector_idx| vectors[vector_idx]).collect();
    let n_first = is_first.iter().filter(|&&it| it).count();
    let mut problem = Problem::new(KernelRows::new(&sorted, params.gamma), n_first, params.nu);
    let n_steps = problem.descend(params)?;
    Ok(problem.solution(&order, n_steps))
}

fn check<const D: usize>(vectors: &[[f32; D]], is_first: &[bool], nu: f64) -> Result<(), NuSvcError> {
    if vectors.len() != is_first.len() {
        return Err(NuSvcError::LabelCount { n_vectors: vectors.len(), n_labels: is_first.len() });
    }
    if let Some(vector_idx) = vectors.iter().position(|vector| !vector.iter().all(|it| it.is_finite())) {
        return Err(NuSvcError::NotFinite { vector_idx });
    }
    let n_first = is_first.iter().filter(|&&it| it).count();
    let n_second = is_first.len() - n_first;
    let largest = 2.0 * n_first.min(n_second) as f64 / is_first.len().max(1) as f64;
    if nu > 0.0 && nu <= largest { Ok(()) } else { Err(NuSvcError::Nu { nu, largest, n_first, n_second }) }
}
