//! The side profiles that stand for all vehicles of a kind.

use detector::describe::box_frame_points::BoxFramePoints;
use detector::describe::prototype_library::Prototype;
use detector::describe::side_profile::SideProfile;
use detector::describe::turning_function::TurningFunction;
use reports::vocabulary::class::{AnnotationClass, Occlusion};

use super::candidate_kind::CandidateKind;
use super::candidates::Candidate;

/// Width of the columns of the profiles.
///
/// Paper: VM section 4, the resolution of the concave hull.
pub const COLUMN_M: f32 = 0.2;
/// Profiles are taken only of vehicles seen well: with at least these points and shares of their length and height.
const LEAST_POINTS: usize = 200;
const LEAST_SHARE_OF_LENGTH: f32 = 0.9;
const LEAST_SHARE_OF_HEIGHT: f32 = 0.75;
/// The box must have the heading of the vehicle within 8 degrees.
const LEAST_COS_OF_TURN: f32 = 0.99;
/// Most profiles of a kind among which its prototypes are searched.
const MOST_PROFILES: usize = 100;

/// Kinds of vehicles that have prototypes.
const KINDS: [AnnotationClass; 4] =
    [AnnotationClass::Car, AnnotationClass::Van, AnnotationClass::Truck, AnnotationClass::Bus];

struct Profile {
    contour_m: Vec<[f32; 2]>,
    function: TurningFunction,
}

/// Up to `n_per_kind` profiles of each of cars, vans, trucks and buses among `candidates`: those from which the others of
/// their kind differ least, chosen one after the other.
///
/// Paper: VM section 4, prototypes.
pub fn find_prototypes(candidates: &[&Candidate], n_per_kind: usize) -> Vec<Prototype> {
    let mut prototypes = Vec::new();
    for kind in KINDS {
        let seen_well: Vec<&Candidate> =
            candidates.iter().copied().filter(|it| is_seen_well(it) && is_of(it, kind)).collect();
        // Evenly over all drives.
        let step = seen_well.len().div_ceil(MOST_PROFILES).max(1);
        let profiles: Vec<Profile> = seen_well.iter().step_by(step).filter_map(|it| profile(it)).collect();
        for (number, medoid_idx) in medoids(&profiles, n_per_kind).into_iter().enumerate() {
            prototypes.push(Prototype {
                name: format!("{} {}", kind.name(), number + 1),
                contour_m: profiles[medoid_idx].contour_m.clone(),
            });
        }
    }
    prototypes
}

fn is_of(candidate: &Candidate, kind: AnnotationClass) -> bool {
    matches!(candidate.kind, CandidateKind::Vehicle { class, .. } if class == kind)
}

/// Whether a profile may be taken of a candidate: a vehicle that is mostly visible.
pub fn is_seen_well(candidate: &Candidate) -> bool {
    let CandidateKind::Vehicle { whole: Some(whole), occlusion, .. } = candidate.kind else {
        return false;
    };
    let [length_m, _, height_m] = candidate.bounding_box.length_width_height_m;
    let [whole_length_m, _, whole_height_m] = whole.length_width_height_m;
    occlusion.is_none_or(|it| it == Occlusion::None)
        && candidate.positions_m.len() >= LEAST_POINTS
        && length_m >= LEAST_SHARE_OF_LENGTH * whole_length_m
        && height_m >= LEAST_SHARE_OF_HEIGHT * whole_height_m
        && (candidate.bounding_box.yaw_rad - whole.yaw_rad).cos().abs() >= LEAST_COS_OF_TURN
}

/// The profile of a vehicle with its front at the greater end, to the millimetre.
fn profile(candidate: &Candidate) -> Option<Profile> {
    let mut points = BoxFramePoints::default();
    points.fill(&candidate.bounding_box, candidate.positions_m.iter().copied());
    let mut profile = SideProfile::new(COLUMN_M);
    let looks_back = match candidate.kind {
        CandidateKind::Vehicle { whole: Some(whole), .. } => {
            (candidate.bounding_box.yaw_rad - whole.yaw_rad).cos() < 0.0
        }
        _ => false,
    };
    let forward = if looks_back { -1.0 } else { 1.0 };
    let rounded = |it: f32| (it * 1000.0).round() / 1000.0;
    let contour_m: Vec<[f32; 2]> = profile
        .concave_contour(&points)
        .iter()
        .map(|&[along_m, up_m]| [rounded(forward * along_m), rounded(up_m)])
        .collect();
    let function = TurningFunction::of(&contour_m)?;
    Some(Profile { contour_m, function })
}

/// Indices of up to `n` profiles. Each is chosen to minimize the sum over all profiles of the distance to the nearest chosen
/// one; of equals, the first.
fn medoids(profiles: &[Profile], n: usize) -> Vec<usize> {
    let differences: Vec<Vec<f32>> = profiles
        .iter()
        .map(|a| profiles.iter().map(|b| a.function.distance(&b.function)).collect())
        .collect();
    let mut chosen = Vec::new();
    let mut nearest = vec![1.0_f32; profiles.len()];
    while chosen.len() < n.min(profiles.len()) {
        let sum_with = |medoid_idx: usize| -> f64 {
            let of_others = nearest.iter().zip(&differences[medoid_idx]);
            of_others.map(|(&before, &with)| f64::from(before.min(with))).sum()
        };
        let left = (0..profiles.len()).filter(|it| !chosen.contains(it));
        let Some(best) = left.min_by(|&a, &b| sum_with(a).total_cmp(&sum_with(b))) else { break };
        for (nearest, &with) in nearest.iter_mut().zip(&differences[best]) {
            *nearest = nearest.min(with);
        }
        chosen.push(best);
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wedge(height_m: f32) -> Profile {
        let contour_m = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 0.3], [0.0, height_m]];
        let function = TurningFunction::of(&contour_m).unwrap();
        Profile { contour_m, function }
    }

    #[test]
    fn medoids_are_the_middles_of_groups() {
        let profiles: Vec<Profile> = [0.9, 1.0, 1.1, 5.8, 6.0, 6.2, 6.1].map(wedge).into_iter().collect();
        let mut chosen = medoids(&profiles, 2);
        chosen.sort_unstable();
        assert!(chosen[0] < 3 && chosen[1] >= 3, "{chosen:?}");
        assert_eq!(medoids(&profiles[..1], 2), [0]);
        assert_eq!(medoids(&[], 2), [0_usize; 0]);
    }
}
