//! The classifier against libsvm, and what it refuses.

use detector::classify::nu_svc_solver::{NuSvcError, NuSvcParams, Tolerance, solve_nu_svc};
use detector::classify::nu_svm::NuSvm;
use detector::classify::svm_model::SvmModel;
use detector::classify::svm_training::train_svm;
use serde::Deserialize;

const FEATURES: [&str; 8] = ["a", "b", "c", "d", "e", "f", "g", "h"];

/// See `fixtures/nu_svc.py`.
#[derive(Deserialize)]
struct Reference {
    gamma: f32,
    labels: Vec<i32>,
    vectors: Vec<[f32; 8]>,
    probes: Vec<[f32; 8]>,
    solution: Vec<Solution>,
}

#[derive(Deserialize)]
struct Solution {
    nu: f64,
    objective: f64,
    n_support: usize,
    decisions: Vec<f32>,
}

impl Reference {
    fn read() -> Self {
        toml::from_str(include_str!("../fixtures/nu_svc.toml")).expect("what the script wrote")
    }

    fn is_first(&self) -> Vec<bool> {
        self.labels.iter().map(|&label| label > 0).collect()
    }

    fn params(&self, nu: f64) -> NuSvcParams {
        NuSvcParams { gamma: self.gamma, nu, tolerance: Tolerance::OfMargin(1e-5), max_steps: 1_000_000 }
    }
}

/// The solution as a model of values that are standardised already.
fn unscaled_model(reference: &Reference, params: &NuSvcParams) -> SvmModel<8> {
    let solution = solve_nu_svc(&reference.vectors, &reference.is_first(), params).expect("a solution");
    SvmModel {
        gamma: params.gamma,
        nu: params.nu,
        rho: solution.rho as f32,
        features: FEATURES,
        means: [0.0; 8],
        deviations: [1.0; 8],
        coefficients: solution.coefficients.iter().map(|&it| it as f32).collect(),
        support_vectors: reference.vectors.clone(),
    }
}

#[test]
fn objective_and_decisions_are_those_of_libsvm() {
    let reference = Reference::read();
    assert_eq!(reference.solution.len(), 2);
    for expected in &reference.solution {
        let params = reference.params(expected.nu);
        let solution = solve_nu_svc(&reference.vectors, &reference.is_first(), &params).unwrap();
        let relative = (solution.objective / expected.objective - 1.0).abs();
        assert!(relative < 1e-4, "nu {}: {} against {}", expected.nu, solution.objective, expected.objective);
        let n_support = solution.coefficients.iter().filter(|&&it| it != 0.0).count();
        assert!(n_support.abs_diff(expected.n_support) <= 2, "{n_support} against {}", expected.n_support);
        let svm = NuSvm::new(&unscaled_model(&reference, &params));
        for (probe, &decision) in reference.probes.iter().zip(&expected.decisions) {
            let ours = svm.decision(probe);
            assert!((ours - decision).abs() < 2e-3, "nu {}: {ours} against {decision}", expected.nu);
        }
    }
}

#[test]
fn nu_bounds_the_share_of_support_vectors_and_of_errors() {
    let reference = Reference::read();
    let n = reference.vectors.len() as f64;
    for nu in [0.05, 0.2, 0.4] {
        let params = reference.params(nu);
        let model = unscaled_model(&reference, &params);
        let n_support = model.coefficients.iter().filter(|&&it| it != 0.0).count() as f64;
        assert!(n_support >= nu * n, "{n_support} support vectors at nu {nu}");
        let svm = NuSvm::new(&model);
        let side = |is_first: bool| if is_first { 1.0 } else { -1.0 };
        let labelled = reference.vectors.iter().zip(reference.is_first());
        let inside = labelled.filter(|&(vector, it)| side(it) * svm.decision(vector) < 0.99);
        assert!(inside.count() as f64 <= nu * n, "errors at nu {nu}");
    }
}

#[test]
fn a_trained_model_does_not_depend_on_the_units_of_its_values() {
    let reference = Reference::read();
    let train = |vectors: &[[f32; 8]]| {
        let params = reference.params(0.3);
        train_svm(vectors, &reference.is_first(), FEATURES, &params).unwrap()
    };
    let in_millimetres = |vector: &[f32; 8]| vector.map(|it| 1000.0 * it + 250.0);
    let metres = NuSvm::new(&train(&reference.vectors));
    let scaled: Vec<[f32; 8]> = reference.vectors.iter().map(in_millimetres).collect();
    let millimetres = NuSvm::new(&train(&scaled));
    for probe in &reference.probes {
        let (a, b) = (metres.decision(probe), millimetres.decision(&in_millimetres(probe)));
        assert!((a - b).abs() < 2e-3, "{a} against {b}");
    }
}

#[test]
fn training_twice_gives_the_same() {
    let reference = Reference::read();
    let params = reference.params(0.0377);
    let train = || train_svm(&reference.vectors, &reference.is_first(), FEATURES, &params).unwrap();
    let model = train();
    assert_eq!(model, train());
    assert!(model.support_vectors.len() < reference.vectors.len());
}

#[test]
fn a_value_that_never_differs_is_harmless() {
    let vectors = [[0.0, 5.0], [0.2, 5.0], [1.0, 5.0], [1.2, 5.0]];
    let params = NuSvcParams { gamma: 1.0, nu: 0.5, tolerance: Tolerance::OfMargin(1e-6), max_steps: 1000 };
    let model = train_svm(&vectors, &[true, true, false, false], ["a", "b"], &params).unwrap();
    let svm = NuSvm::new(&model);
    assert!(svm.decision(&[0.1, 5.0]) > 0.5 && svm.decision(&[1.1, 5.0]) < -0.5);
}

#[test]
fn what_cannot_be_trained_is_an_error() {
    let params = NuSvcParams { gamma: 1.0, nu: 0.5, tolerance: Tolerance::OfMargin(1e-6), max_steps: 1000 };
    let solve = |vectors: &[[f32; 1]], is_first: &[bool], params: &NuSvcParams| {
        solve_nu_svc(vectors, is_first, params).unwrap_err()
    };
    let line = [[0.0], [1.0], [2.0], [3.0]];
    let labels = NuSvcError::LabelCount { n_vectors: 4, n_labels: 1 };
    assert_eq!(solve(&line, &[true], &params), labels);
    assert_eq!(solve(&[[0.0], [f32::NAN]], &[true, false], &params), NuSvcError::NotFinite { vector_idx: 1 });
    let too_few = NuSvcError::Nu { nu: 0.6, largest: 0.5, n_first: 1, n_second: 3 };
    assert_eq!(solve(&line, &[true, false, false, false], &NuSvcParams { nu: 0.6, ..params }), too_few);
    assert!(matches!(solve(&line, &[true; 4], &params), NuSvcError::Nu { largest: 0.0, .. }));
    assert!(matches!(solve(&[], &[], &params), NuSvcError::Nu { .. }));
    let same = [[1.0], [2.0], [1.0], [2.0]];
    let is_first = [true, true, false, false];
    assert!(matches!(solve(&same, &is_first, &params), NuSvcError::NoMargin { .. }));
    let hasty = NuSvcParams { nu: 0.3, max_steps: 0, ..params };
    let uneven = [[0.0], [0.3], [1.0], [1.1]];
    assert!(matches!(solve(&uneven, &is_first, &hasty), NuSvcError::NotConverged { n_steps: 0, .. }));
}
