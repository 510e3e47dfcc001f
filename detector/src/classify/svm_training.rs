//! Classifiers trained on labelled vectors.

use super::nu_svc_solver::{NuSvcError, NuSvcParams, solve_nu_svc};
use super::svm_model::SvmModel;

/// Trains a classifier on `vectors`, whose values are called `features`; `is_first` says for each whether it is of the
/// class that decides positive.
///
/// Values are standardised by their mean and standard deviation over `vectors`; a value that is the same everywhere
/// keeps its unit.
///
/// # Errors
///
/// [`NuSvcError`] if there is no such classifier.
///
/// Paper: VM section 5.
pub fn train_svm<const D: usize>(
    vectors: &[[f32; D]],
    is_first: &[bool],
    features: [&'static str; D],
    params: &NuSvcParams,
) -> Result<SvmModel<D>, NuSvcError> {
    let (means, deviations) = statistics(vectors);
    let standardise = |vector: &[f32; D]| -> [f32; D] {
        std::array::from_fn(|idx| (vector[idx] - means[idx]) / deviations[idx])
    };
    let standardised: Vec<[f32; D]> = vectors.iter().map(standardise).collect();
    let solution = solve_nu_svc(&standardised, is_first, params)?;
    let support =
        solution.coefficients.iter().zip(&standardised).filter(|&(&coefficient, _)| coefficient != 0.0);
    let (coefficients, support_vectors) =
        support.map(|(&coefficient, vector)| (coefficient as f32, *vector)).unzip();
    Ok(SvmModel {
        gamma: params.gamma,
        nu: params.nu,
        rho: solution.rho as f32,
        features,
        means,
        deviations,
        coefficients,
        support_vectors,
    })
}

fn statistics<const D: usize>(vectors: &[[f32; D]]) -> ([f32; D], [f32; D]) {
    let n = vectors.len().max(1) as f64;
    let mean = |idx: usize| vectors.iter().map(|vector| f64::from(vector[idx])).sum::<f64>() / n;
    let means: [f64; D] = std::array::from_fn(mean);
    let deviations = std::array::from_fn(|idx| {
        let squares = vectors.iter().map(|vector| (f64::from(vector[idx]) - means[idx]).powi(2));
        let deviation = (squares.sum::<f64>() / n).sqrt() as f32;
        if deviation > 0.0 { deviation } else { 1.0 }
    });
    (means.map(|mean| mean as f32), deviations)
}
