//! Which candidates a model is trained on: vehicles and background, and not more than the solver takes.

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;

use super::candidate_kind::CandidateKind;
use super::candidates::Candidate;

/// Cut regions are at most this share of the background: a street has more clusters to be taken for vehicles than
/// rectangles that nobody put there.
const MOST_CUT_REGIONS: f64 = 0.25;
/// Fragments of vehicles are at most this share of it.
const MOST_FRAGMENTS: f64 = 0.15;

/// So many of what regrouping might make of clusters, for each vehicle: vehicles, fragments of them, and others.
const REGROUPED_VEHICLES: f64 = 0.3;
const REGROUPED_FRAGMENTS: f64 = 0.3;
const REGROUPED_CLUSTERS: f64 = 0.25;

/// Up to `most_vehicles` vehicles of `candidates`, drawn from `seed`, up to `others_per_vehicle` times as many others, and
/// some of what regrouping might make of them, in the order they have there.
///
/// Paper: VM section 6.
pub fn select<'a>(
    candidates: &[&'a Candidate],
    (most_vehicles, others_per_vehicle): (usize, f64),
    seed: u64,
) -> Vec<&'a Candidate> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = |is_regrouped: bool, is_wanted: fn(&CandidateKind) -> bool, most: usize| {
        let is_wanted = |it: &Candidate| it.is_regrouped == is_regrouped && is_wanted(&it.kind);
        let mut places: Vec<usize> = (0..candidates.len()).filter(|&it| is_wanted(candidates[it])).collect();
        places.shuffle(&mut rng);
        places.truncate(most);
        places
    };
    let mut places = drawn(false, CandidateKind::is_vehicle, most_vehicles);
    let n_vehicles = places.len() as f64;
    let most = |share: f64| (share * others_per_vehicle * n_vehicles) as usize;
    let cut = drawn(false, |it| *it == CandidateKind::CutRegion, most(MOST_CUT_REGIONS));
    let fragments = drawn(false, |it| *it == CandidateKind::Fragment, most(MOST_FRAGMENTS));
    places.extend(drawn(false, |it| *it == CandidateKind::Cluster, most(1.0) - cut.len() - fragments.len()));
    places.extend(cut);
    places.extend(fragments);
    let most = |per_vehicle: f64| (per_vehicle * n_vehicles) as usize;
    places.extend(drawn(true, CandidateKind::is_vehicle, most(REGROUPED_VEHICLES)));
    places.extend(drawn(true, |it| *it == CandidateKind::Fragment, most(REGROUPED_FRAGMENTS)));
    places.extend(drawn(true, |it| *it == CandidateKind::Cluster, most(REGROUPED_CLUSTERS)));
    places.sort_unstable();
    places.into_iter().map(|place| candidates[place]).collect()
}
