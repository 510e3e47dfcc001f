//! People on foot of many kinds: grown and small, standing and walking, with what they wear and carry.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::material::Material;
use crate::object_shape::{ObjectShape, Part};
use crate::person_shape::{Build, any_build, pedestrian};
use crate::solid::{Prism, Solid};

/// Share of people who are children.
const CHILDREN: f64 = 0.15;
/// Share of people who stand.
const STANDING: f64 = 0.3;

/// A person of any kind, who looks along x.
pub fn any_person(rng: &mut ChaCha8Rng) -> ObjectShape {
    let grown = any_build(rng);
    let build = if rng.random_bool(CHILDREN) { child(&grown, rng) } else { grown };
    let walked_m = if rng.random_bool(STANDING) { 0.0 } else { rng.random_range(0.05..1.5) };
    let mut shape = pedestrian(&build, walked_m);
    let worn = [coat, backpack, bag, hat, umbrella];
    let shares = [0.3, 0.2, 0.2, 0.15, 0.04];
    for (wear, share) in worn.into_iter().zip(shares) {
        if rng.random_bool(share) {
            let (solid, material) = wear(&build, rng);
            shape.parts.push(Part { solid, material, is_outside_box: false });
        }
    }
    shape
}

fn child(grown: &Build, rng: &mut ChaCha8Rng) -> Build {
    let height_m = rng.random_range(1.0_f32..1.5);
    Build { height_m, half_width_m: height_m * rng.random_range(0.115_f32..0.135), ..*grown }
}

/// A coat, skirt or dress, wider at the hem.
fn coat(build: &Build, rng: &mut ChaCha8Rng) -> (Solid, Material) {
    let &Build { height_m, half_width_m, clothes, .. } = build;
    let (hem_m, top_m) = (height_m * rng.random_range(0.2_f32..0.42), height_m * 0.62);
    let half_depth_m = rng.random_range(0.15_f32..0.25);
    let cloth = Prism {
        profile_m: vec![[-half_depth_m, hem_m], [half_depth_m, hem_m], [0.12, top_m], [-0.12, top_m]],
        center_y_m: 0.0,
        bottom_half_width_m: half_width_m * rng.random_range(0.85_f32..1.15),
        top_half_width_m: half_width_m * 0.85,
    };
    (Solid::Prism(cloth), clothes)
}

fn backpack(build: &Build, rng: &mut ChaCha8Rng) -> (Solid, Material) {
    let (bottom_m, top_m) = (build.height_m * 0.52, build.height_m * 0.8);
    let depth_m = rng.random_range(0.12_f32..0.28);
    let half_m = build.half_width_m * 0.75;
    let back_m = -0.1;
    let sack = Solid::cuboid([back_m - depth_m, -half_m, bottom_m], [back_m, half_m, top_m]);
    (sack, Material::solid(rng.random_range(0.08..0.4)))
}

/// A bag in one hand.
fn bag(build: &Build, rng: &mut ChaCha8Rng) -> (Solid, Material) {
    let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let aside_m = side * (build.half_width_m + 0.07);
    let top_m = build.height_m * 0.42;
    let bottom_m = top_m - rng.random_range(0.2_f32..0.35);
    let half_length_m = rng.random_range(0.1_f32..0.22);
    let sack = Solid::cuboid(
        [-half_length_m, aside_m - 0.07, bottom_m.max(0.02)],
        [half_length_m, aside_m + 0.07, top_m],
    );
    (sack, Material::solid(rng.random_range(0.08..0.5)))
}

fn hat(build: &Build, rng: &mut ChaCha8Rng) -> (Solid, Material) {
    let z_m = build.height_m - 0.05;
    let radius_m = rng.random_range(0.1_f32..0.19);
    (Solid::cylinder([0.0, 0.0, z_m], [0.0, 0.0, z_m + 0.08], radius_m), build.clothes)
}

fn umbrella(build: &Build, rng: &mut ChaCha8Rng) -> (Solid, Material) {
    let radius_m = rng.random_range(0.4_f32..0.55);
    (Solid::spheroid([0.05, 0.0, build.height_m + 0.12], radius_m, 0.1), build.clothes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn people_are_as_large_as_people() {
        let mut rng = ChaCha8Rng::from_seed([5; 32]);
        let mut heights_m = Vec::new();
        for _ in 0..400 {
            let bounds = any_person(&mut rng).bounds();
            let size = bounds.extents();
            assert!((0.95..2.2).contains(&size.z), "height {}", size.z);
            assert!((0.2..1.2).contains(&size.x) && (0.3..1.2).contains(&size.y), "{size:?}");
            assert!(bounds.mins.z > -0.04, "feet are not in the ground: {}", bounds.mins.z);
            heights_m.push(size.z);
        }
        let n_small = heights_m.iter().filter(|it| **it < 1.5).count();
        assert!((20..100).contains(&n_small), "{n_small} of 400 are small");
    }
}
