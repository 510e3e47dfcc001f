//! Trees and hedges, whose leaves let some pulses through.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::material::Material;
use super::object_shape::ObjectShape;
use super::solid::Solid;

/// A street tree: trunk, and a crown of several lobes that begins above head height.
pub fn tree(rng: &mut ChaCha8Rng) -> ObjectShape {
    let clear_m = rng.random_range(1.9_f32..3.2);
    let crown_radius_m = rng.random_range(1.3_f32..2.6);
    let crown_half_height_m = crown_radius_m * rng.random_range(0.8..1.3);
    let trunk_radius_m = rng.random_range(0.08_f32..0.24);
    tree_with([clear_m, crown_radius_m, crown_half_height_m, trunk_radius_m], rng)
}

/// A tree of an avenue, whose crown hangs over the road beside it.
pub fn broad_tree(rng: &mut ChaCha8Rng) -> ObjectShape {
    let clear_m = rng.random_range(1.8_f32..3.4);
    let crown_radius_m = rng.random_range(2.5_f32..5.0);
    let crown_half_height_m = crown_radius_m * rng.random_range(0.4..0.9);
    let trunk_radius_m = rng.random_range(0.12_f32..0.4);
    tree_with([clear_m, crown_radius_m, crown_half_height_m, trunk_radius_m], rng)
}

/// A tree of these sizes: below the crown, radius and half the height of the crown, radius of the trunk.
fn tree_with(
    [clear_m, crown_radius_m, crown_half_height_m, trunk_radius_m]: [f32; 4],
    rng: &mut ChaCha8Rng,
) -> ObjectShape {
    let lean_m = rng.random_range(-0.15_f32..0.15);
    let leaves = Material::foliage(rng.random_range(0.7..2.0));
    let middle_m = clear_m + crown_half_height_m;
    let trunk = Solid::cylinder([0.0; 3], [lean_m, 0.0, middle_m], trunk_radius_m);
    let mut parts = vec![
        (trunk, Material::WOOD),
        (Solid::spheroid([lean_m, 0.0, middle_m], crown_radius_m, crown_half_height_m), leaves),
    ];
    for _ in 0..rng.random_range(2..5_u32) {
        let share = rng.random_range(0.35_f32..0.6);
        let offset = |reach: f32, rng: &mut ChaCha8Rng| reach * rng.random_range(-0.7_f32..0.7);
        let center_m = [
            lean_m + offset(crown_radius_m, rng),
            offset(crown_radius_m, rng),
            middle_m + offset(crown_half_height_m, rng) * 0.8,
        ];
        let lobe = Solid::spheroid(center_m, crown_radius_m * share, crown_half_height_m * share);
        parts.push((lobe, leaves));
    }
    ObjectShape::new(AnnotationClass::Tree, parts)
}

/// A hedge along x, `length_m` long: no two metres of it are of the same height and depth, and shoots stand out of the
/// top.
pub fn hedge(length_m: f32, rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(0.8_f32..1.9);
    let half_depth_m = rng.random_range(0.25_f32..0.5);
    let leaves = Material::foliage(rng.random_range(0.05..0.12));
    let shoots = Material::foliage(rng.random_range(0.2..0.6));
    let n_pieces = (length_m / 1.2).ceil();
    let piece_m = length_m / n_pieces;
    let mut parts = Vec::new();
    for piece in 0..n_pieces as u32 {
        let from_m = piece as f32 * piece_m - length_m / 2.0;
        let to_m = from_m + piece_m;
        let top_m = height_m * rng.random_range(0.86_f32..1.05);
        let depth_m = half_depth_m * rng.random_range(0.75_f32..1.1);
        parts.push((Solid::cuboid([from_m, -depth_m, 0.0], [to_m, depth_m, top_m]), leaves));
        if rng.random_bool(0.6) {
            let middle_m = [f32::midpoint(from_m, to_m), 0.0, top_m];
            let tuft = Solid::spheroid(middle_m, piece_m / 2.0, rng.random_range(0.1_f32..0.35));
            parts.push((tuft, shoots));
        }
    }
    ObjectShape::new(AnnotationClass::Hedge, parts)
}

/// A bush that branches into several tufts.
pub fn bush(rng: &mut ChaCha8Rng) -> ObjectShape {
    let radius_m = rng.random_range(0.4_f32..0.9);
    let half_height_m = rng.random_range(0.4_f32..0.9);
    let leaves = Material::foliage(rng.random_range(0.1..0.4));
    let body = Solid::spheroid([0.0, 0.0, half_height_m], radius_m * 0.8, half_height_m);
    let mut parts = vec![(body, leaves)];
    for _ in 0..rng.random_range(1..4_u32) {
        let offset = |rng: &mut ChaCha8Rng| radius_m * rng.random_range(-0.55_f32..0.55);
        let tuft_m = half_height_m * rng.random_range(0.3_f32..0.6);
        let center_m = [offset(rng), offset(rng), half_height_m * rng.random_range(1.0_f32..1.9)];
        parts.push((Solid::spheroid(center_m, radius_m * 0.4, tuft_m), leaves));
    }
    ObjectShape::new(AnnotationClass::Hedge, parts)
}

/// A shrub, a tall perennial or a potted plant.
pub fn shrub(rng: &mut ChaCha8Rng) -> ObjectShape {
    let radius_m = rng.random_range(0.18_f32..0.45);
    let half_height_m = rng.random_range(0.25_f32..0.8);
    let leaves = Material::foliage(rng.random_range(0.08..0.3));
    let body = Solid::spheroid([0.0, 0.0, half_height_m], radius_m, half_height_m);
    ObjectShape::new(AnnotationClass::Hedge, [(body, leaves)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn people_walk_below_the_crowns_of_street_trees() {
        let mut rng = ChaCha8Rng::from_seed([5; 32]);
        for _ in 0..50 {
            let tree = tree(&mut rng);
            let head = parry3d::query::Ray::new([5.0, 0.9, 1.5].into(), [-1.0, 0.0, 0.0].into());
            let placed = tree.parts.iter().map(|part| part.solid.placed(&parry3d::math::Pose::IDENTITY));
            assert!(placed.filter_map(|solid| solid.crossing(&head)).count() == 0);
        }
    }

    #[test]
    fn a_hedge_is_as_long_as_asked_for() {
        let mut rng = ChaCha8Rng::from_seed([5; 32]);
        assert!((hedge(8.0, &mut rng).length_m() - 8.0).abs() < 1e-4);
        assert!(bush(&mut rng).length_m() < 2.1);
        assert!(shrub(&mut rng).length_m() < 1.0);
    }
}
