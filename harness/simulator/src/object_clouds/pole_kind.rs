//! Poles of many kinds: lamps, signs, lights, masts, bollards; thin and thick, with and without arms.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use crate::furniture_shape::{bollard, lamp_post, sign, traffic_light};
use crate::material::Material;
use crate::object_shape::ObjectShape;
use crate::solid::Solid;

/// A pole of any kind.
pub fn any_pole(rng: &mut ChaCha8Rng) -> ObjectShape {
    match rng.random_range(0..100_u32) {
        0..8 => lamp_post(rng),
        8..20 => lantern(rng),
        20..32 => arched_lamp(rng),
        32..39 => sign(rng),
        39..53 => sign_post(rng),
        53..58 => traffic_light(rng),
        58..66 => mast_arm(rng),
        66..76 => line_mast(rng),
        76..84 => bare_mast(rng),
        84..89 => bollard(rng),
        89..96 => thick_bollard(rng),
        _ => meter(rng),
    }
}

type Parts = Vec<(Solid, Material)>;

fn pole(parts: Parts) -> ObjectShape {
    ObjectShape::new(AnnotationClass::Pole, parts)
}

fn upright(height_m: f32, radius_m: f32, material: Material) -> (Solid, Material) {
    (Solid::cylinder([0.0; 3], [0.0, 0.0, height_m], radius_m), material)
}

/// A lamp on top of its post.
fn lantern(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(2.8_f32..6.0);
    let radius_m = rng.random_range(0.04_f32..0.09);
    let head_m = rng.random_range(0.14_f32..0.3);
    let mut parts = vec![
        upright(height_m, radius_m, Material::METAL),
        (Solid::spheroid([0.0, 0.0, height_m], head_m, head_m * 1.1), Material::solid(0.4)),
    ];
    if rng.random_bool(0.5) {
        parts.push(upright(rng.random_range(0.5..1.2), radius_m + 0.05, Material::METAL));
    }
    pole(parts)
}

/// A lamp whose one or two arms rise in pieces and end in a flat head.
fn arched_lamp(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(5.0_f32..11.5);
    let radius_m = rng.random_range(0.06_f32..0.13);
    let arm_m = rng.random_range(0.7_f32..2.6);
    let rise_m = rng.random_range(0.1_f32..1.0);
    let mut parts = vec![
        upright(height_m, radius_m, Material::METAL),
        upright(rng.random_range(0.8..1.5), radius_m + 0.04, Material::METAL),
    ];
    let sides: &[f32] = if rng.random_bool(0.35) { &[-1.0, 1.0] } else { &[1.0] };
    for &side in sides {
        let knee_m = [0.0, side * arm_m * 0.4, height_m + rise_m * 0.8];
        let end_m = [0.0, side * arm_m, height_m + rise_m];
        let head =
            Solid::cuboid([-0.13, end_m[1] - 0.3, end_m[2] - 0.06], [0.13, end_m[1] + 0.3, end_m[2] + 0.06]);
        parts.push((Solid::cylinder([0.0, 0.0, height_m - 0.05], knee_m, 0.04), Material::METAL));
        parts.push((Solid::cylinder(knee_m, end_m, 0.035), Material::METAL));
        parts.push((head, Material::solid(0.35)));
    }
    pole(parts)
}

/// A post with one to three plates, round or square.
fn sign_post(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(2.1_f32..3.8);
    let radius_m = rng.random_range(0.025_f32..0.05);
    let mut parts = vec![upright(height_m, radius_m, Material::METAL)];
    let mut top_m = height_m;
    for _ in 0..rng.random_range(1..4_u32) {
        let half_m = rng.random_range(0.17_f32..0.4);
        let middle_m = top_m - half_m;
        let face_m = radius_m + 0.015;
        let plate = if rng.random_bool(0.5) {
            Solid::cylinder([face_m, 0.0, middle_m], [face_m + 0.02, 0.0, middle_m], half_m)
        } else {
            let half_height_m = half_m * rng.random_range(0.5_f32..1.0);
            Solid::cuboid(
                [face_m, -half_m, middle_m - half_height_m],
                [face_m + 0.02, half_m, middle_m + half_height_m],
            )
        };
        parts.push((plate, Material::RETROREFLECTOR));
        top_m -= 2.0 * half_m + 0.04;
    }
    pole(parts)
}

/// A mast whose arm holds traffic lights or a board over the road.
fn mast_arm(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(4.8_f32..6.8);
    let radius_m = rng.random_range(0.08_f32..0.16);
    let arm_m = rng.random_range(2.0_f32..5.5);
    let arm_height_m = height_m - 0.3;
    let mut parts = vec![
        upright(height_m, radius_m, Material::METAL),
        (Solid::cylinder([0.0, 0.0, arm_height_m], [0.0, arm_m, arm_height_m + 0.2], 0.06), Material::METAL),
    ];
    let head =
        |y_m: f32, z_m: f32| Solid::cuboid([0.08, y_m - 0.16, z_m - 0.5], [0.32, y_m + 0.16, z_m + 0.5]);
    parts.push((head(arm_m - 0.3, arm_height_m), Material::RUBBER));
    if rng.random_bool(0.6) {
        parts.push((head(0.0, 2.8), Material::RUBBER));
    }
    pole(parts)
}

/// A mast of a power or telephone line, of wood or concrete, with cross-arms and sometimes with the beginnings of wires.
fn line_mast(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(6.5_f32..12.5);
    let radius_m = rng.random_range(0.1_f32..0.2);
    let mut parts = vec![upright(height_m, radius_m, Material::WOOD)];
    for arm in 0..rng.random_range(0..3_u32) {
        let half_m = rng.random_range(0.5_f32..1.4);
        let z_m = height_m - 0.3 - 0.8 * arm as f32;
        parts.push((
            Solid::cuboid([radius_m, -half_m, z_m - 0.06], [radius_m + 0.1, half_m, z_m + 0.06]),
            Material::WOOD,
        ));
        for side in [-0.9_f32, 0.9] {
            let foot_m = [radius_m + 0.05, side * half_m, z_m + 0.06];
            let top_m = [foot_m[0], foot_m[1], foot_m[2] + 0.2];
            parts.push((Solid::cylinder(foot_m, top_m, 0.04), Material::MASONRY));
        }
    }
    if rng.random_bool(0.5) {
        parts.extend(wires(height_m, rng));
    }
    if rng.random_bool(0.3) {
        let z_m = height_m - rng.random_range(1.8_f32..3.0);
        let beside_m = radius_m + 0.25;
        parts.push((
            Solid::cylinder([beside_m, 0.0, z_m - 0.45], [beside_m, 0.0, z_m + 0.45], 0.22),
            Material::METAL,
        ));
    }
    pole(parts)
}

/// The pieces of wires that are taken for parts of their mast, along x.
fn wires(height_m: f32, rng: &mut ChaCha8Rng) -> Parts {
    let wire = |_| {
        let from_m = [0.0, rng.random_range(-0.8_f32..0.8), height_m * rng.random_range(0.6_f32..1.0)];
        let along_m = rng.random_range(1.0_f32..4.5) * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let to_m = [along_m, from_m[1], from_m[2] + along_m.abs() * rng.random_range(-0.1_f32..0.02)];
        (Solid::cylinder(from_m, to_m, 0.015), Material::RUBBER)
    };
    (0..4).map(wire).collect()
}

/// A mast without anything on it, such as one for flags or wires.
fn bare_mast(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(3.0_f32..10.0);
    let foot_radius_m = rng.random_range(0.03_f32..0.15);
    let lean_m = height_m * rng.random_range(-0.02_f32..0.02);
    let middle_m = [lean_m / 2.0, 0.0, height_m / 2.0];
    pole(vec![
        (Solid::cylinder([0.0; 3], middle_m, foot_radius_m), Material::METAL),
        (Solid::cylinder(middle_m, [lean_m, 0.0, height_m], foot_radius_m * 0.75), Material::METAL),
    ])
}

/// A bollard of stone, steel or plastic.
fn thick_bollard(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(0.6_f32..1.3);
    let radius_m = rng.random_range(0.05_f32..0.17);
    let coat = Material::solid(rng.random_range(0.15..0.7));
    let mut parts = vec![upright(height_m, radius_m, coat)];
    if rng.random_bool(0.4) {
        parts.push((Solid::spheroid([0.0, 0.0, height_m], radius_m, radius_m), coat));
    }
    pole(parts)
}

/// A parking meter or a button for crossing, on its post.
fn meter(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(1.1_f32..1.7);
    let half_m = rng.random_range(0.07_f32..0.15);
    let head = Solid::cuboid([-half_m, -half_m, height_m - 0.4], [half_m, half_m, height_m]);
    pole(vec![upright(height_m - 0.3, 0.04, Material::METAL), (head, Material::METAL)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn poles_stand_on_the_ground_and_none_is_larger_than_a_mast() {
        let mut rng = ChaCha8Rng::from_seed([5; 32]);
        for _ in 0..400 {
            let shape = any_pole(&mut rng);
            let bounds = shape.bounds();
            assert_eq!(shape.class, AnnotationClass::Pole);
            assert!(bounds.mins.z.abs() < 0.01, "it stands on the ground: {}", bounds.mins.z);
            assert!((0.5..13.5).contains(&bounds.maxs.z), "height {}", bounds.maxs.z);
            let size = bounds.extents();
            assert!(size.x < 9.2 && size.y < 6.2, "arms and wires {size:?}");
        }
    }
}
