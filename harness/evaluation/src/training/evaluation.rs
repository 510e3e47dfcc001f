//! How good a trained model is on objects of held-out drives.

use std::collections::BTreeMap;

use detector::classify::nu_svm::NuSvm;
use detector::classify::svm_model::SvmModel;
use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;

use super::described_object::DescribedObject;
use super::operating_curves::OperatingCurves;

/// Numbers of objects of a kind that are classified as vehicles and as background.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PredictedAs {
    /// Classified as vehicles.
    pub n_vehicle: usize,
    /// Classified as background.
    pub n_background: usize,
}

/// Results of a model on held-out objects.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation<const D: usize> {
    /// The predictions for each kind of object, vehicles and others.
    pub predicted: BTreeMap<(bool, &'static str), PredictedAs>,
    /// Results at all thresholds.
    pub curves: OperatingCurves,
    /// Loss of ROC area for each value when this value is shuffled between objects; `None` without a ROC area.
    pub importance: [(&'static str, Option<f64>); D],
}

/// Judges `model` by `objects`. Values are shuffled by `seed`.
pub fn evaluate<const D: usize>(
    model: &SvmModel<D>,
    objects: &[DescribedObject<D>],
    seed: u64,
) -> Evaluation<D> {
    let svm = NuSvm::new(model);
    let decisions: Vec<f32> = objects.iter().map(|it| svm.decision(&it.features)).collect();
    let mut predicted: BTreeMap<_, PredictedAs> = BTreeMap::new();
    for (object, &decision) in objects.iter().zip(&decisions) {
        // Vehicles first.
        let counts = predicted.entry((!object.is_vehicle, object.kind)).or_default();
        *if decision > 0.0 { &mut counts.n_vehicle } else { &mut counts.n_background } += 1;
    }
    let labels = || objects.iter().map(|it| it.is_vehicle);
    let curves = OperatingCurves::of(decisions.iter().copied().zip(labels()));
    let importance = std::array::from_fn(|feature_idx| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(feature_idx as u64);
        let mut mixed: Vec<f32> = objects.iter().map(|it| it.features[feature_idx]).collect();
        mixed.shuffle(&mut rng);
        let decisions = objects.iter().zip(mixed).map(|(it, value)| {
            let mut features = it.features;
            features[feature_idx] = value;
            svm.decision(&features)
        });
        let area = OperatingCurves::of(decisions.zip(labels())).roc_area();
        let loss = curves.roc_area().zip(area).map(|(with, without)| with - without);
        (model.features[feature_idx], loss)
    });
    Evaluation { predicted, curves, importance }
}
