//! Selection of the candidates for training: vehicles and background, not more than the solver can handle.

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;

use super::candidate_kind::CandidateKind;
use super::candidates::Candidate;

/// Greatest share of cut regions in the background: a street has more clusters that may be taken for vehicles than
/// arbitrary rectangles.
const MOST_CUT_REGIONS: f64 = 0.25;
/// Greatest share of fragments of vehicles in the background.
const MOST_FRAGMENTS: f64 = 0.15;

/// Draws up to `most_vehicles` vehicles of `candidates` by `seed`, and up to `others_per_vehicle` times as many others.
/// Keeps the order of `candidates`.
///
/// Paper: VM section 6.
pub fn select<'a>(
    candidates: &[&'a Candidate],
    most_vehicles: usize,
    others_per_vehicle: f64,
    seed: u64,
) -> Vec<&'a Candidate> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = |is_wanted: fn(&CandidateKind) -> bool, most: usize| {
        let mut indices: Vec<usize> =
            (0..candidates.len()).filter(|&it| is_wanted(&candidates[it].kind)).collect();
        indices.shuffle(&mut rng);
        indices.truncate(most);
        indices
    };
    let mut indices = drawn(CandidateKind::is_vehicle, most_vehicles);
    let n_vehicles = indices.len() as f64;
    let most = |share: f64| (share * others_per_vehicle * n_vehicles) as usize;
    let cut = drawn(|it| *it == CandidateKind::CutRegion, most(MOST_CUT_REGIONS));
    let fragments = drawn(|it| *it == CandidateKind::Fragment, most(MOST_FRAGMENTS));
    indices.extend(drawn(|it| *it == CandidateKind::Cluster, most(1.0) - cut.len() - fragments.len()));
    indices.extend(cut);
    indices.extend(fragments);
    indices.sort_unstable();
    indices.into_iter().map(|index| candidates[index]).collect()
}
