//! Candidates as the classifiers see them.

use detector::classify::nu_svc_solver::{NuSvcError, NuSvcParams};
use detector::classify::svm_model::SvmModel;
use detector::classify::svm_training::train_svm;
use detector::describe::object_describer::ObjectDescriber;

use super::candidates::Candidate;

/// An object with what the classifier sees of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DescribedObject<const D: usize> {
    /// What it is, as in files.
    pub kind: &'static str,
    /// Whether it is a vehicle.
    pub is_vehicle: bool,
    /// The values of the model.
    pub features: [f32; D],
}

impl<const D: usize> DescribedObject<D> {
    /// What `describer` sees of `candidate`; `None` without points.
    pub fn of(candidate: &Candidate, describer: &mut impl ObjectDescriber<D>) -> Option<Self> {
        let features = describer.describe(&candidate.bounding_box, candidate.positions_m.iter().copied())?;
        Some(Self { kind: candidate.kind.name(), is_vehicle: candidate.kind.is_vehicle(), features })
    }
}

/// The classifier of vehicles against background of `selected` candidates, whose values `describer` takes.
///
/// # Errors
///
/// [`NuSvcError`] if there is no such classifier.
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
