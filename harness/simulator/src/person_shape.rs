//! People on foot and on bicycles.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::material::Material;
use super::object_shape::ObjectShape;
use super::portable_math;
use super::solid::Solid;

/// Size, clothes and gait of a person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Build {
    /// Height in metres.
    pub height_m: f32,
    /// Half of the shoulders' width in metres.
    pub half_width_m: f32,
    /// Reflectivity of the clothes.
    pub clothes: Material,
    /// Where in a step the walk begins, as a share of a double step.
    pub gait_phase: f32,
}

const SKIN: Material = Material::solid(0.4);
/// A double step of a walking adult, in metres.
const DOUBLE_STEP_M: f32 = 1.5;

/// Draws a person.
pub fn any_build(rng: &mut ChaCha8Rng) -> Build {
    Build {
        height_m: rng.random_range(1.5..1.92),
        half_width_m: rng.random_range(0.19..0.26),
        clothes: Material::solid(rng.random_range(0.08..0.55)),
        gait_phase: rng.random_range(0.0..1.0),
    }
}

/// Draws a child.
pub fn any_child(rng: &mut ChaCha8Rng) -> Build {
    let grown = any_build(rng);
    let height_m = rng.random_range(0.85..1.45);
    Build { height_m, half_width_m: 0.13 * height_m, ..grown }
}

/// A person who sits on something 0.45 m high and looks along x.
pub fn sitting_person(build: &Build) -> ObjectShape {
    ObjectShape::new(AnnotationClass::SittingPerson, seated_parts(build, [0.0, 0.45]))
}

/// A person whose hip is at x and z in metres, and whose feet are in front of it on the ground or on a footboard.
pub fn seated_parts(build: &Build, [hip_x_m, hip_m]: [f32; 2]) -> Vec<(Solid, Material)> {
    let Build { height_m, half_width_m, clothes, .. } = *build;
    let shoulder_m = hip_m + 0.32 * height_m;
    let head_m = height_m * 0.13;
    let limb = |side: f32| {
        let hip = [hip_x_m, side * 0.09, hip_m + 0.05];
        let knee = [hip_x_m + 0.24 * height_m, side * 0.11, hip_m + 0.04];
        let foot = [hip_x_m + 0.22 * height_m, side * 0.11, (hip_m - 0.25 * height_m).max(0.02)];
        let shoulder = [hip_x_m, side * half_width_m, shoulder_m - 0.05];
        let hand = [hip_x_m + 0.2 * height_m, side * half_width_m, hip_m + 0.2];
        [(hip, knee, 0.075), (knee, foot, 0.06), (shoulder, hand, 0.05)]
    };
    let limbs = [-1.0, 1.0].into_iter().flat_map(limb);
    let limbs = limbs.map(|(from_m, to_m, radius_m)| (Solid::cylinder(from_m, to_m, radius_m), clothes));
    let half_m = half_width_m - 0.03;
    let torso = Solid::cuboid([hip_x_m - 0.11, -half_m, hip_m], [hip_x_m + 0.11, half_m, shoulder_m]);
    let neck = Solid::cylinder([hip_x_m, 0.0, shoulder_m], [hip_x_m, 0.0, shoulder_m + head_m], 0.055);
    let head = Solid::spheroid([hip_x_m, 0.0, shoulder_m + head_m], 0.085, head_m * 0.9);
    limbs.chain([(torso, clothes), (neck, SKIN), (head, SKIN)]).collect()
}

/// A person who has walked `walked_m`, or stands when that is 0.
pub fn pedestrian(build: &Build, walked_m: f32) -> ObjectShape {
    let stride_m = if walked_m == 0.0 { 0.12 } else { 0.36 };
    let turns = f64::from(walked_m / DOUBLE_STEP_M + build.gait_phase);
    let swing_m = stride_m * portable_math::sin_cos(turns * std::f64::consts::TAU).0 as f32;
    let Build { height_m, half_width_m, clothes, .. } = *build;
    let (hip_m, shoulder_m) = (height_m * 0.5, height_m * 0.82);
    let head_m = height_m * 0.13;
    let leg = |side: f32| {
        let foot = [side * swing_m, side * 0.10, 0.02];
        (Solid::cylinder(foot, [0.0, side * 0.09, hip_m], 0.075), clothes)
    };
    let arm = |side: f32| {
        let shoulder = [0.0, side * half_width_m, shoulder_m - 0.05];
        let hand = [-side * swing_m * 0.8, side * (half_width_m + 0.05), hip_m - 0.05];
        (Solid::cylinder(hand, shoulder, 0.05), clothes)
    };
    let torso =
        Solid::cuboid([-0.11, -half_width_m + 0.03, hip_m - 0.05], [0.11, half_width_m - 0.03, shoulder_m]);
    let neck = Solid::cylinder([0.0, 0.0, shoulder_m], [0.0, 0.0, height_m - head_m], 0.055);
    let head = Solid::spheroid([0.0, 0.0, height_m - head_m], 0.085, head_m);
    ObjectShape::new(
        AnnotationClass::Pedestrian,
        [leg(-1.0), leg(1.0), arm(-1.0), arm(1.0), (torso, clothes), (neck, SKIN), (head, SKIN)],
    )
}

/// A person on a bicycle who has ridden `ridden_m`.
pub fn cyclist(build: &Build, ridden_m: f32) -> ObjectShape {
    let turns = f64::from(ridden_m / 4.5 + build.gait_phase);
    let (sine, cosine) = portable_math::sin_cos(turns * std::f64::consts::TAU);
    let (pedal_x, pedal_z) = (0.17 * cosine as f32, 0.17 * sine as f32);
    let Build { height_m, half_width_m, clothes, .. } = *build;
    let hip = [-0.15, 0.0, 0.95];
    let shoulder = [0.22, 0.0, 0.95 + height_m * 0.29];
    let leg = |side: f32| {
        let foot = [0.05 + side * pedal_x, side * 0.12, 0.28 + side * pedal_z];
        let knee = [0.22, side * 0.11, 0.70 + side * pedal_z * 0.6];
        let hip = [hip[0], side * 0.1, hip[2]];
        [(Solid::cylinder(foot, knee, 0.06), clothes), (Solid::cylinder(knee, hip, 0.08), clothes)]
    };
    let arm = |side: f32| {
        let hand = [0.5, side * 0.25, 1.0];
        let shoulder = [shoulder[0], side * half_width_m * 0.9, shoulder[2]];
        (Solid::cylinder(hand, shoulder, 0.045), clothes)
    };
    let head = [shoulder[0] + 0.08, 0.0, shoulder[2] + height_m * 0.14];
    let mut parts = bicycle_parts();
    parts.extend(leg(-1.0));
    parts.extend(leg(1.0));
    parts.extend([arm(-1.0), arm(1.0)]);
    parts.push((Solid::cylinder(hip, shoulder, half_width_m * 0.8), clothes));
    parts.push((Solid::spheroid(head, 0.1, height_m * 0.07), SKIN));
    ObjectShape::new(AnnotationClass::Cyclist, parts)
}

/// A bicycle that leans against nothing.
pub fn parked_bicycle() -> ObjectShape {
    ObjectShape::new(AnnotationClass::ParkedCycle, bicycle_parts())
}

fn bicycle_parts() -> Vec<(Solid, Material)> {
    // Spokes let most pulses through, rims and tyres do not: a ring of eight short rods.
    let wheel = |hub_x: f32| {
        (0..8_u32).map(move |segment| {
            let at = |corner: u32| {
                let turns = f64::from(corner) / 8.0;
                let (sine, cosine) = portable_math::sin_cos(turns * std::f64::consts::TAU);
                [hub_x + 0.33 * cosine as f32, 0.0, 0.35 + 0.33 * sine as f32]
            };
            Solid::cylinder(at(segment), at(segment + 1), 0.022)
        })
    };
    let rods = [
        ([-0.52, 0.0, 0.35], [-0.15, 0.0, 0.82]),
        ([0.0, 0.0, 0.3], [-0.18, 0.0, 0.9]),
        ([0.0, 0.0, 0.3], [0.40, 0.0, 0.82]),
        ([-0.15, 0.0, 0.82], [0.40, 0.0, 0.85]),
        ([0.52, 0.0, 0.35], [0.40, 0.0, 0.98]),
        ([0.45, -0.27, 0.98], [0.45, 0.27, 0.98]),
    ];
    let frame = rods.map(|(from_m, to_m)| Solid::cylinder(from_m, to_m, 0.02));
    let saddle = Solid::cuboid([-0.28, -0.07, 0.9], [-0.05, 0.07, 0.96]);
    let metal = wheel(-0.52).chain(wheel(0.52)).chain(frame).map(|solid| (solid, Material::METAL));
    metal.chain([(saddle, Material::RUBBER)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[track_caller]
    fn check(make: fn(&Build, f32) -> ObjectShape, lengths_m: [f32; 2], heights_m: [f32; 2]) {
        let mut rng = ChaCha8Rng::from_seed([3; 32]);
        for step in 0..100 {
            let build = any_build(&mut rng);
            let bounds = make(&build, step as f32 * 0.13).bounds();
            let size = bounds.extents();
            assert!((lengths_m[0]..lengths_m[1]).contains(&size.x), "length {}", size.x);
            assert!((0.4..0.8).contains(&size.y), "width {}", size.y);
            assert!((heights_m[0]..heights_m[1]).contains(&size.z), "height {}", size.z);
            assert!(bounds.mins.z > -0.02, "feet are not in the ground: {}", bounds.mins.z);
        }
    }

    #[test]
    fn pedestrians_are_as_large_as_people() {
        check(pedestrian, [0.2, 1.0], [1.45, 1.95]);
    }

    #[test]
    fn cyclists_are_as_large_as_cyclists() {
        check(cyclist, [1.6, 1.9], [1.5, 2.0]);
    }
}
