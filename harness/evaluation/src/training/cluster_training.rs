//! Training of the trees that classify road users among clusters.

use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::seen_size::may_be;
use detector::describe::vehicle_features::{N_FEATURES, VehicleDescriber};
use detector::road_user::{MayBe, N_ROAD_USERS, RoadUser};

use super::candidate_kind::CandidateKind;
use super::candidates::Candidate;
use super::vehicle_labels::is_road_user;

/// A cluster as the trees see it.
#[derive(Debug, Clone, PartialEq)]
pub struct ClusterExample {
    /// Its drive.
    pub sequence: String,
    /// Its values.
    pub values: [f32; N_FEATURES],
    /// The road users that it may show by its size.
    pub may_be: MayBe,
    /// Whether it shows each of [`RoadUser::ALL`]; `None` if the labels leave it open.
    pub shows: [Option<bool>; N_ROAD_USERS],
}

/// Examples of the clusters among `candidates` that have the size of a road user. Cut regions are no clusters.
pub fn described_clusters(candidates: &[Candidate], library: &PrototypeLibrary) -> Vec<ClusterExample> {
    let mut describer = VehicleDescriber::new(library.clone());
    let is_asked = |it: &&Candidate| {
        let may_be = may_be(&it.bounding_box, it.surroundings.ground_m);
        it.kind != CandidateKind::CutRegion && may_be.allows_any()
    };
    let example = |it: &Candidate| {
        let positions_m = it.positions_m.iter().copied();
        let values = describer.describe(&it.bounding_box, &it.surroundings, positions_m)?;
        let may_be = may_be(&it.bounding_box, it.surroundings.ground_m);
        let shows = RoadUser::ALL.map(|road_user| match road_user {
            RoadUser::Vehicle => Some(it.kind.is_vehicle()),
            other => it.shown.map_or(Some(false), |class| is_road_user(class, other)),
        });
        Some(ClusterExample { sequence: it.sequence.clone(), values, may_be, shows })
    };
    candidates.iter().filter(is_asked).filter_map(example).collect()
}
