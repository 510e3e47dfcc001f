//! Candidates as the classifiers see them.

use detector::classify::nu_svc_solver::{NuSvcError, NuSvcParams};
use detector::classify::svm_model::SvmModel;
use detector::classify::svm_training::train_svm;
use detector::describe::object_describer::ObjectDescriber;

use super::candidates::Candidate;

/// An object with the values that the classifier uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DescribedObject<const D: usize> {
    /// Name of its kind, as in files.
    pub kind: &'static str,
    /// Whether it is a vehicle.
    pub is_vehicle: bool,
    /// The values of the model.
    pub features: [f32; D],
}

impl<const D: usize> DescribedObject<D> {
    /// The values that `describer` computes of `candidate`; `None` without points.
    pub fn of(candidate: &Candidate, describer: &mut impl ObjectDescriber<D>) -> Option<Self> {
        let features = describer.describe(&candidate.bounding_box, candidate.positions_m.iter().copied())?;
        Some(Self { kind: candidate.kind.name(), is_vehicle: candidate.kind.is_vehicle(), features })
    }
}

/// Trains a classifier of vehicles against background on `selected` candidates; `describer` computes their values.
///
/// # Errors
///
/// [`NuSvcError`] if the training fails.
pub fn fit_model<const D: usize, S: ObjectDescriber<D>>(
    selected: &[&Candidate],
    describer: &mut S,
    params: &NuSvcParams,
) -> Result<SvmModel<D>, NuSvcError> {
    let objects = selected.iter().filter_map(|it| DescribedObject::of(it, describer));
    let (vectors, is_vehicle): (Vec<[f32; D]>, Vec<bool>) =
        objects.map(|it| (it.features, it.is_vehicle)).unzip();
    train_svm(&vectors, &is_vehicle, S::NAMES, params)
}
