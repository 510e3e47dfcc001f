//! Training of the trees that classify vehicles among clusters.

use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::seen_size::may_be_vehicle;
use detector::describe::vehicle_features::{N_FEATURES, VehicleDescriber};

use super::candidate_kind::CandidateKind;
use super::candidates::Candidate;

/// A cluster as the trees see it.
#[derive(Debug, Clone, PartialEq)]
pub struct ClusterExample {
    /// Its drive.
    pub sequence: String,
    /// Its values.
    pub values: [f32; N_FEATURES],
    /// Whether it shows a vehicle.
    pub is_vehicle: bool,
}

/// Examples of the clusters among `candidates` that have the size of a vehicle. Cut regions are no clusters.
pub fn described_clusters(candidates: &[Candidate], library: &PrototypeLibrary) -> Vec<ClusterExample> {
    let mut describer = VehicleDescriber::new(library.clone());
    let is_asked = |it: &&Candidate| {
        it.kind != CandidateKind::CutRegion && may_be_vehicle(&it.bounding_box, it.surroundings.ground_m)
    };
    let example = |it: &Candidate| {
        let positions_m = it.positions_m.iter().copied();
        let values = describer.describe(&it.bounding_box, &it.surroundings, positions_m)?;
        let (sequence, is_vehicle) = (it.sequence.clone(), it.kind.is_vehicle());
        Some(ClusterExample { sequence, values, is_vehicle })
    };
    candidates.iter().filter(is_asked).filter_map(example).collect()
}
