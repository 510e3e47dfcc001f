//! Trees of many kinds: with leaves and bare, with high and low crowns, old and just planted.

use std::f32::consts::TAU;
use std::ops::Range;

use parry3d::math::Vector;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use crate::material::Material;
use crate::object_shape::ObjectShape;
use crate::solid::Solid;
use crate::vegetation_shape::{broad_tree, tree};
use crate::world::sine_and_cosine;

/// A tree of any kind.
pub fn any_tree(rng: &mut ChaCha8Rng) -> ObjectShape {
    match rng.random_range(0..100_u32) {
        0..14 => tree(rng),
        14..24 => broad_tree(rng),
        24..52 => branched(&LEAFY, rng),
        52..70 => branched(&BARE, rng),
        70..80 => conifer(rng),
        80..90 => columnar(rng),
        _ => young(rng),
    }
}

type Parts = Vec<(Solid, Material)>;

/// How a tree branches.
struct Branching {
    /// Height of the lowest fork, in metres.
    fork_m: Range<f32>,
    /// Length of the limbs, in metres.
    limb_m: Range<f32>,
    /// How often each branch forks again.
    n_forks: u32,
    /// Radius of the clump of leaves at the end of each branch over the length of the branch; none if bare.
    clump_share: Option<Range<f32>>,
}

const LEAFY: Branching =
    Branching { fork_m: 1.2..4.0, limb_m: 1.0..4.4, n_forks: 2, clump_share: Some(0.45..0.9) };

const BARE: Branching = Branching { fork_m: 1.0..4.0, limb_m: 1.2..4.4, n_forks: 3, clump_share: None };

/// A trunk that forks into limbs, these into branches, and so on.
fn branched(kind: &Branching, rng: &mut ChaCha8Rng) -> ObjectShape {
    let fork_m = rng.random_range(kind.fork_m.clone());
    let limb_m = rng.random_range(kind.limb_m.clone());
    let trunk_radius_m = (0.05 + 0.05 * limb_m) * rng.random_range(0.6_f32..1.5);
    let leaves = Material::foliage(rng.random_range(0.3..1.4));
    let clump_share = kind.clump_share.clone().map(|it| rng.random_range(it));
    let lean = Vector::new(rng.random_range(-0.08..0.08), rng.random_range(-0.08..0.08), 1.0);
    let fork = lean * fork_m;
    let mut parts = vec![(Solid::cylinder([0.0; 3], fork.into(), trunk_radius_m), Material::WOOD)];
    let mut branches = vec![Branch { from: fork, toward: lean, length_m: limb_m, radius_m: trunk_radius_m }];
    for generation in 0..=kind.n_forks {
        branches = branches.iter().flat_map(|it| forks(it, generation, rng)).collect();
        parts.extend(branches.iter().map(|it| (it.solid(), Material::WOOD)));
        if let Some(share) = clump_share
            && generation > 0
        {
            let clumps: Parts = branches.iter().map(|it| (it.clump(share, rng), leaves)).collect();
            parts.extend(clumps);
        }
    }
    ObjectShape::new(AnnotationClass::Tree, parts)
}

/// A straight piece of wood.
struct Branch {
    from: Vector,
    toward: Vector,
    length_m: f32,
    radius_m: f32,
}

impl Branch {
    fn end(&self) -> Vector {
        self.from + self.toward * self.length_m
    }

    fn solid(&self) -> Solid {
        Solid::cylinder(self.from.into(), self.end().into(), self.radius_m)
    }

    fn clump(&self, share: f32, rng: &mut ChaCha8Rng) -> Solid {
        let radius_m = self.length_m * share * rng.random_range(0.7_f32..1.2);
        Solid::spheroid(self.end().into(), radius_m, radius_m * rng.random_range(0.6_f32..1.0))
    }
}

/// The branches into which `stem` forks at its end: the trunk's end is where it begins.
fn forks(stem: &Branch, generation: u32, rng: &mut ChaCha8Rng) -> Vec<Branch> {
    let is_first = generation == 0;
    let n = if is_first { rng.random_range(3..7_u32) } else { rng.random_range(2..4_u32) };
    let from = if is_first { stem.from } else { stem.end() };
    let first_turn = rng.random_range(0.0..1.0_f32);
    let branch = |index: u32| {
        let turn = TAU * (first_turn + (index as f32 + rng.random_range(-0.3_f32..0.3)) / n as f32);
        let (sine, cosine) = sine_and_cosine(turn.into());
        let spread = rng.random_range(0.35_f32..1.0);
        // Twigs strive upward.
        let toward = stem.toward + Vector::new(cosine * spread, sine * spread, 0.15);
        let shrink = if is_first { 1.0 } else { 0.62 };
        Branch {
            from,
            toward: toward.normalize(),
            length_m: stem.length_m * shrink * rng.random_range(0.7_f32..1.15),
            radius_m: (stem.radius_m * rng.random_range(0.45_f32..0.65)).max(0.008),
        }
    };
    (0..n).map(branch).collect()
}

/// A fir or spruce: its crown begins near the ground and narrows to a tip.
fn conifer(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(3.0_f32..18.0);
    let clear_m = rng.random_range(0.15_f32..1.6);
    let foot_radius_m = height_m * rng.random_range(0.14_f32..0.26);
    let leaves = Material::foliage(rng.random_range(0.2..0.8));
    let trunk_radius_m = height_m * rng.random_range(0.01_f32..0.022);
    let trunk = Solid::cylinder([0.0; 3], [0.0, 0.0, height_m * 0.95], trunk_radius_m);
    let mut parts = vec![(trunk, Material::WOOD)];
    let n_tiers = rng.random_range(5..11_u32);
    let tier_m = (height_m - clear_m) / n_tiers as f32;
    for tier in 0..n_tiers {
        let up = (tier as f32 + 0.5) / n_tiers as f32;
        let radius_m = foot_radius_m * (1.0 - 0.9 * up) * rng.random_range(0.85_f32..1.1);
        let center_m = [0.0, 0.0, clear_m + (tier as f32 + 0.5) * tier_m];
        parts.push((Solid::spheroid(center_m, radius_m, tier_m * 0.75), leaves));
    }
    ObjectShape::new(AnnotationClass::Tree, parts)
}

/// A poplar, cypress or pillar of hornbeam.
fn columnar(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(4.0_f32..17.0);
    let clear_m = rng.random_range(0.2_f32..1.9);
    let radius_m = height_m * rng.random_range(0.07_f32..0.14);
    let half_m = (height_m - clear_m) / 2.0;
    let leaves = Material::foliage(rng.random_range(0.2..0.9));
    let trunk_radius_m = height_m * rng.random_range(0.012_f32..0.022);
    let mut parts = vec![
        (Solid::cylinder([0.0; 3], [0.0, 0.0, clear_m + half_m], trunk_radius_m), Material::WOOD),
        (Solid::spheroid([0.0, 0.0, clear_m + half_m], radius_m, half_m), leaves),
    ];
    for _ in 0..rng.random_range(3..8_u32) {
        let mut aside = || radius_m * rng.random_range(-0.7_f32..0.7);
        let center_m = [aside(), aside(), clear_m + half_m * rng.random_range(0.5_f32..1.6)];
        parts.push((Solid::spheroid(center_m, radius_m * 0.55, half_m * 0.25), leaves));
    }
    ObjectShape::new(AnnotationClass::Tree, parts)
}

/// A tree that was planted a few years ago, between stakes.
fn young(rng: &mut ChaCha8Rng) -> ObjectShape {
    let clear_m = rng.random_range(1.3_f32..2.2);
    let radius_m = rng.random_range(0.45_f32..1.1);
    let half_m = radius_m * rng.random_range(0.9_f32..1.6);
    let leaves = Material::foliage(rng.random_range(0.3..1.0));
    let trunk_radius_m = rng.random_range(0.025_f32..0.06);
    let mut parts = vec![
        (Solid::cylinder([0.0; 3], [0.0, 0.0, clear_m + half_m], trunk_radius_m), Material::WOOD),
        (Solid::spheroid([0.0, 0.0, clear_m + half_m], radius_m, half_m), leaves),
    ];
    for _ in 0..rng.random_range(2..5_u32) {
        let mut aside = || radius_m * rng.random_range(-0.8_f32..0.8);
        let center_m = [aside(), aside(), clear_m + half_m * rng.random_range(0.6_f32..1.7)];
        parts.push((Solid::spheroid(center_m, radius_m * 0.5, half_m * 0.4), leaves));
    }
    let stake_m = rng.random_range(1.0_f32..1.8);
    for side in [-1.0_f32, 1.0].into_iter().take(rng.random_range(0..3_usize)) {
        let foot_m = [side * 0.3, 0.0, 0.0];
        parts.push((Solid::cylinder(foot_m, [side * 0.3, 0.0, stake_m], 0.035), Material::WOOD));
    }
    ObjectShape::new(AnnotationClass::Tree, parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[track_caller]
    fn check(make: impl Fn(&mut ChaCha8Rng) -> ObjectShape, heights_m: Range<f32>, widths_m: Range<f32>) {
        let mut rng = ChaCha8Rng::from_seed([5; 32]);
        for _ in 0..100 {
            let bounds = make(&mut rng).bounds();
            assert!(heights_m.contains(&bounds.maxs.z), "height {}", bounds.maxs.z);
            // Trunks lean, and leaves may touch the ground.
            assert!((-0.4..0.01).contains(&bounds.mins.z), "it stands on the ground: {}", bounds.mins.z);
            let size = bounds.extents();
            assert!(widths_m.contains(&size.x) && widths_m.contains(&size.y), "width {size:?}");
        }
    }

    #[test]
    fn trees_are_as_large_as_along_streets() {
        check(any_tree, 1.9..21.0, 0.6..20.0);
        check(conifer, 2.9..19.0, 0.7..10.5);
        check(columnar, 3.9..17.6, 0.5..5.2);
        check(young, 2.0..6.5, 0.8..2.9);
        check(|rng| branched(&BARE, rng), 2.5..21.0, 1.5..20.0);
        check(|rng| branched(&LEAFY, rng), 2.5..21.0, 1.5..20.0);
    }

    #[test]
    fn bare_trees_have_no_leaves_and_others_do() {
        let mut rng = ChaCha8Rng::from_seed([6; 32]);
        let has_leaves = |shape: &ObjectShape| {
            shape.parts.iter().any(|it| matches!(it.material.passage, crate::material::Passage::FreePath(_)))
        };
        assert!(!has_leaves(&branched(&BARE, &mut rng)));
        assert!(has_leaves(&branched(&LEAFY, &mut rng)));
        let n_leafy = (0..200).filter(|_| has_leaves(&any_tree(&mut rng))).count();
        assert!((140..190).contains(&n_leafy), "{n_leafy} of 200 have leaves");
    }
}
