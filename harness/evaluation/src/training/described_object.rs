//! Candidates as the classifiers see them.

use baselines::pca_features::{N_PCA_FEATURES, PcaDescriber};
use detector::classify::nu_svc_solver::{NuSvcError, NuSvcParams};
use detector::classify::svm_model::SvmModel;
use detector::classify::svm_training::train_svm;
use detector::describe::paper_features::{N_PAPER_FEATURES, PaperDescriber};

use super::candidates::Candidate;

/// Takes the `D` values of a vehicle model from a candidate.
pub trait CandidateDescriber<const D: usize> {
    /// The values; `None` without points.
    fn values_of(&mut self, candidate: &Candidate) -> Option<[f32; D]>;
}

impl CandidateDescriber<N_PAPER_FEATURES> for PaperDescriber {
    fn values_of(&mut self, candidate: &Candidate) -> Option<[f32; N_PAPER_FEATURES]> {
        let positions_m = candidate.positions_m.iter().copied();
        self.describe(&candidate.bounding_box, positions_m).map(|it| it.values())
    }
}

impl CandidateDescriber<N_PCA_FEATURES> for PcaDescriber {
    fn values_of(&mut self, candidate: &Candidate) -> Option<[f32; N_PCA_FEATURES]> {
        let positions_m = candidate.positions_m.iter().copied();
        self.describe(&candidate.bounding_box, positions_m).map(|it| it.values())
    }
}

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
    pub fn of(candidate: &Candidate, describer: &mut impl CandidateDescriber<D>) -> Option<Self> {
        Some(Self {
            kind: candidate.kind.name(),
            is_vehicle: candidate.kind.is_vehicle(),
            features: describer.values_of(candidate)?,
        })
    }
}

/// The classifier of vehicles against background of `selected` candidates, whose values `describer` takes and `names`
/// names.
///
/// # Errors
///
/// [`NuSvcError`] if there is no such classifier.
pub fn fit_model<const D: usize>(
    selected: &[&Candidate],
    describer: &mut impl CandidateDescriber<D>,
    names: [&'static str; D],
    params: &NuSvcParams,
) -> Result<SvmModel<D>, NuSvcError> {
    let objects: Vec<DescribedObject<D>> =
        selected.iter().filter_map(|it| DescribedObject::of(it, describer)).collect();
    let vectors: Vec<[f32; D]> = objects.iter().map(|it| it.features).collect();
    let is_vehicle: Vec<bool> = objects.iter().map(|it| it.is_vehicle).collect();
    train_svm(&vectors, &is_vehicle, names, params)
}
