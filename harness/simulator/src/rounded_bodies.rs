//! Cars and vans as they are on a ground plan: sides that curve toward both ends, and mirrors that stand out.
//!
//! The boxes that the shapes are drawn with have flat sides. On recorded scans of three drives and two sensors the median
//! car has 58 % of its points farther than 4 cm from flat sides, and 29 % near the long sides of its box; with flat sides
//! it has 41 and 49 %.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::car_shape::part_between;
use super::material::{Material, Passage};
use super::object_shape::{ObjectShape, Part};
use super::solid::{Prism, Solid};
use super::world::{Body, World};

/// Where the steps of a side end, as shares of half the length.
const STEPS: [f32; 6] = [1.0, 0.93, 0.84, 0.72, 0.55, 0.3];

/// Rounds the bodies of all cars and vans, and gives them mirrors.
pub fn rounded_bodies(world: &mut World, rng: &mut ChaCha8Rng) {
    for object in &mut world.objects {
        if let Body::Rigid(shape) = &mut object.body
            && matches!(shape.class, AnnotationClass::Car | AnnotationClass::Van)
        {
            round(shape, rng);
        }
    }
}

fn round(shape: &mut ObjectShape, rng: &mut ChaCha8Rng) {
    let bounds = shape.bounds();
    let [half_length_m, half_width_m] = [bounds.half_extents().x, bounds.half_extents().y];
    let cut_m = half_width_m * rng.random_range(0.08_f32..0.24);
    let mut parts = Vec::new();
    for part in shape.parts.drain(..) {
        match &part.solid {
            Solid::Prism(prism) if is_body(prism, &part.material, half_width_m) => {
                let steps = STEPS.into_iter().map(|share| step(prism, share, half_length_m, cut_m));
                parts.extend(steps.map(|solid| Part { solid: Solid::Prism(solid), ..part.clone() }));
            }
            _ => parts.push(part),
        }
    }
    parts.extend(mirrors(&bounds, rng));
    shape.parts = parts;
}

/// Whether a part is sheet metal from side to side.
fn is_body(prism: &Prism, material: &Material, half_width_m: f32) -> bool {
    let is_wide = prism.bottom_half_width_m.min(prism.top_half_width_m) > 0.85 * half_width_m;
    is_wide && prism.center_y_m == 0.0 && material.passage == Passage::Blocked
}

/// The part of `prism` within a share of half the length; the less it reaches, the wider it is.
fn step(prism: &Prism, share: f32, half_length_m: f32, cut_m: f32) -> Prism {
    let reach_m = share * half_length_m;
    let narrower_m = cut_m * share * share * share;
    Prism {
        profile_m: part_between(&prism.profile_m, [-reach_m, reach_m]),
        bottom_half_width_m: prism.bottom_half_width_m - narrower_m,
        top_half_width_m: prism.top_half_width_m - narrower_m,
        ..*prism
    }
}

/// A mirror on either side, before the driver, which labels leave out of the box.
fn mirrors(bounds: &parry3d::bounding_volume::Aabb, rng: &mut ChaCha8Rng) -> [Part; 2] {
    let x_m = bounds.maxs.x - 2.0 * bounds.half_extents().x * rng.random_range(0.27_f32..0.36);
    let z_m = bounds.maxs.z * rng.random_range(0.6_f32..0.68);
    let [inner_m, outer_m] =
        [bounds.half_extents().y - 0.08, bounds.half_extents().y + rng.random_range(0.1_f32..0.2)];
    [-1.0_f32, 1.0].map(|side| {
        let y_m = [side * inner_m, side * outer_m];
        let solid = Solid::cuboid(
            [x_m - 0.06, y_m[0].min(y_m[1]), z_m],
            [x_m + 0.06, y_m[0].max(y_m[1]), z_m + 0.14],
        );
        Part { solid, material: Material::solid(0.15), is_outside_box: true }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::TOWN;
    use rand::SeedableRng;

    #[test]
    fn a_rounded_car_keeps_its_box_and_is_narrower_at_its_ends() {
        let mut rng = ChaCha8Rng::from_seed([6; 32]);
        for _ in 0..30 {
            let flat = TOWN.car(&mut rng);
            let mut shape = flat.clone();
            round(&mut shape, &mut rng);
            let [before, after] = [flat.bounds(), shape.bounds()];
            assert!((before.extents() - after.extents()).length() < 0.05, "{before:?} {after:?}");
            let width_at = |shape: &ObjectShape, x_m: f32| {
                let ray = parry3d::query::Ray::new([x_m, 5.0, 0.45].into(), [0.0, -1.0, 0.0].into());
                let pose = parry3d::math::Pose::IDENTITY;
                let enters = shape.parts.iter().filter_map(|it| it.solid.placed(&pose).crossing(&ray));
                5.0 - enters.map(|it| it.enter).fold(5.0, f32::min)
            };
            let near_end_m = after.maxs.x - 0.12;
            assert!(width_at(&shape, near_end_m) < width_at(&flat, near_end_m) - 0.02);
            assert!((width_at(&shape, 0.3) - width_at(&flat, 0.3)).abs() < 0.03);
        }
    }
}
