//! Scooters and motorcycles, with and without riders.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::material::Material;
use super::object_shape::ObjectShape;
use super::person_shape::{self, Build};
use super::solid::Solid;

/// A parked cycle of any kind: bicycle, scooter or motorcycle.
pub fn any_parked(motor_share: f64, rng: &mut ChaCha8Rng) -> ObjectShape {
    if !rng.random_bool(motor_share) {
        person_shape::parked_bicycle()
    } else if rng.random_bool(0.7) {
        ObjectShape::new(AnnotationClass::ParkedCycle, scooter_parts(rng))
    } else {
        ObjectShape::new(AnnotationClass::ParkedCycle, motorcycle_parts(rng))
    }
}

/// A rider on a scooter.
pub fn ridden_scooter(build: &Build, rng: &mut ChaCha8Rng) -> ObjectShape {
    let mut parts = scooter_parts(rng);
    parts.extend(person_shape::seated_parts(build, [-0.2, 0.78]));
    ObjectShape::new(AnnotationClass::Cyclist, parts)
}

/// A step-through scooter: wheels, floor, shield, seat, handlebar.
fn scooter_parts(rng: &mut ChaCha8Rng) -> Vec<(Solid, Material)> {
    let coat = Material::solid(rng.random_range(0.1..0.5));
    let half_m = rng.random_range(0.78_f32..0.95);
    let mut parts = vec![
        wheel(-half_m + 0.24, 0.24),
        wheel(half_m - 0.24, 0.24),
        (Solid::cuboid([-half_m + 0.1, -0.16, 0.35], [-0.05, 0.16, 0.72]), coat),
        (Solid::cuboid([-half_m + 0.15, -0.14, 0.72], [-0.02, 0.14, 0.8]), Material::RUBBER),
        (Solid::cuboid([-0.1, -0.16, 0.2], [half_m - 0.45, 0.16, 0.28]), coat),
        (Solid::cuboid([half_m - 0.5, -0.2, 0.25], [half_m - 0.42, 0.2, 0.85]), coat),
        (Solid::cylinder([half_m - 0.24, 0.0, 0.3], [half_m - 0.48, 0.0, 1.0], 0.04), Material::METAL),
        (Solid::cylinder([half_m - 0.5, -0.32, 1.0], [half_m - 0.5, 0.32, 1.0], 0.025), Material::RUBBER),
    ];
    if rng.random_bool(0.3) {
        let case = Solid::cuboid([-half_m - 0.15, -0.2, 0.8], [-half_m + 0.25, 0.2, 1.15]);
        parts.push((case, Material::solid(0.2)));
    }
    parts
}

/// A motorcycle: wheels, engine, tank, seat, handlebar.
fn motorcycle_parts(rng: &mut ChaCha8Rng) -> Vec<(Solid, Material)> {
    let coat = Material::solid(rng.random_range(0.1..0.5));
    let half_m = rng.random_range(0.95_f32..1.15);
    vec![
        wheel(-half_m + 0.31, 0.31),
        wheel(half_m - 0.31, 0.31),
        (Solid::cuboid([-0.35, -0.2, 0.25], [0.3, 0.2, 0.6]), Material::METAL),
        (Solid::spheroid([0.15, 0.0, 0.78], 0.26, 0.16), coat),
        (Solid::cuboid([-half_m + 0.2, -0.14, 0.7], [-0.05, 0.14, 0.82]), Material::RUBBER),
        (Solid::cylinder([half_m - 0.31, 0.0, 0.31], [half_m - 0.62, 0.0, 1.0], 0.05), Material::METAL),
        (Solid::cylinder([half_m - 0.62, -0.36, 1.02], [half_m - 0.62, 0.36, 1.02], 0.025), Material::RUBBER),
    ]
}

/// A wheel along x on the ground, its hub above `x_m`.
fn wheel(x_m: f32, radius_m: f32) -> (Solid, Material) {
    (Solid::cylinder([x_m, -0.05, radius_m], [x_m, 0.05, radius_m], radius_m), Material::RUBBER)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn cycles_are_as_large_as_cycles() {
        let mut rng = ChaCha8Rng::from_seed([6; 32]);
        for _ in 0..60 {
            let build = person_shape::any_build(&mut rng);
            let ridden = ridden_scooter(&build, &mut rng);
            let parked = any_parked(0.6, &mut rng);
            for (shape, heights_m) in [(ridden, 1.2..1.9), (parked, 0.9..1.2)] {
                let bounds = shape.bounds();
                assert!((1.4..2.4).contains(&bounds.extents().x), "{:?}", bounds.extents());
                assert!(heights_m.contains(&bounds.maxs.z), "height {}", bounds.maxs.z);
                assert!(bounds.mins.z.abs() < 0.03, "it stands on the ground: {}", bounds.mins.z);
            }
        }
    }
}
