//! Furniture of pavements: posts, signs, bins, benches.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::material::Material;
use super::object_shape::ObjectShape;
use super::solid::Solid;

/// A lamp post whose arm reaches over the road, toward +y.
pub fn lamp_post(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(5.0_f32..9.0);
    let radius_m = rng.random_range(0.06_f32..0.11);
    let arm_m = rng.random_range(0.6_f32..1.6);
    ObjectShape::new(
        AnnotationClass::Pole,
        [
            upright(1.0, radius_m + 0.03),
            upright(height_m, radius_m),
            (Solid::cylinder([0.0, 0.0, height_m], [0.0, arm_m, height_m + 0.2], 0.04), Material::METAL),
        ],
    )
}

/// A traffic sign that faces along x.
pub fn sign(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(2.3_f32..3.0);
    let half_m = rng.random_range(0.25_f32..0.38);
    let plate = Solid::cuboid([0.03, -half_m, height_m - 2.0 * half_m], [0.05, half_m, height_m]);
    ObjectShape::new(AnnotationClass::Pole, [upright(height_m, 0.035), (plate, Material::RETROREFLECTOR)])
}

/// A traffic light that faces along x.
pub fn traffic_light(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(3.0_f32..3.6);
    let head = Solid::cuboid([0.05, -0.15, height_m - 1.0], [0.25, 0.15, height_m - 0.1]);
    ObjectShape::new(AnnotationClass::Pole, [upright(height_m, 0.07), (head, Material::RUBBER)])
}

/// A bollard.
pub fn bollard(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(0.8_f32..1.1);
    ObjectShape::new(AnnotationClass::Pole, [upright(height_m, 0.06)])
}

/// A bin on wheels or a litter bin.
pub fn bin(rng: &mut ChaCha8Rng) -> ObjectShape {
    let half_m = rng.random_range(0.22_f32..0.4);
    let height_m = rng.random_range(0.9_f32..1.35);
    let body = Solid::cuboid([-half_m, -half_m, 0.06], [half_m, half_m, height_m]);
    let feet = Solid::cuboid([-half_m + 0.08, -half_m + 0.08, 0.0], [half_m - 0.08, half_m - 0.08, 0.06]);
    let coat = Material::solid(rng.random_range(0.1..0.5));
    ObjectShape::new(AnnotationClass::StreetFurniture, [(body, coat), (feet, Material::RUBBER)])
}

/// A mail box on a post, its slot toward +y.
pub fn mail_box(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(1.2_f32..1.5);
    let half_width_m = rng.random_range(0.18_f32..0.28);
    let half_depth_m = 0.75 * half_width_m;
    let coat = Material::solid(rng.random_range(0.3..0.55));
    let bottom_m = height_m - 0.6;
    let body = Solid::cuboid(
        [-half_width_m, -half_depth_m, bottom_m],
        [half_width_m, half_depth_m, height_m - half_depth_m],
    );
    let roof_m = height_m - half_depth_m;
    let roof = Solid::cylinder([-half_width_m, 0.0, roof_m], [half_width_m, 0.0, roof_m], half_depth_m);
    ObjectShape::new(AnnotationClass::StreetFurniture, [upright(bottom_m, 0.05), (body, coat), (roof, coat)])
}

/// A bench along x that looks to +y.
pub fn bench(rng: &mut ChaCha8Rng) -> ObjectShape {
    let half_m = rng.random_range(0.7_f32..1.0);
    let slab = |least_m, greatest_m| (Solid::cuboid(least_m, greatest_m), Material::WOOD);
    ObjectShape::new(
        AnnotationClass::StreetFurniture,
        [
            slab([-half_m, -0.25, 0.40], [half_m, 0.25, 0.46]),
            slab([-half_m, -0.30, 0.46], [half_m, -0.25, 0.85]),
            slab([-half_m + 0.1, -0.22, 0.0], [-half_m + 0.2, 0.22, 0.40]),
            slab([half_m - 0.2, -0.22, 0.0], [half_m - 0.1, 0.22, 0.40]),
        ],
    )
}

/// A round pillar for posters.
pub fn advertising_column(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(2.8_f32..3.6);
    let radius_m = rng.random_range(0.45_f32..0.6);
    let rod =
        |to_z, radius| (Solid::cylinder([0.0, 0.0, 0.0], [0.0, 0.0, to_z], radius), Material::solid(0.4));
    ObjectShape::new(AnnotationClass::StreetFurniture, [rod(height_m, radius_m), rod(0.3, radius_m + 0.05)])
}

/// A fence along x, `length_m` long.
pub fn fence(length_m: f32, rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(0.9_f32..1.5);
    let half_m = length_m / 2.0;
    let n_gaps = (length_m / 2.0).ceil() as u32;
    let posts = (0..=n_gaps).map(|post| {
        let x = -half_m + length_m * post as f32 / n_gaps as f32;
        (Solid::cylinder([x, 0.0, 0.0], [x, 0.0, height_m], 0.04), Material::WOOD)
    });
    // Between the posts pales or mesh let about every second pulse through.
    let mesh = Material { reflectivity: 0.3, ..Material::foliage(0.04) };
    let panel = (Solid::cuboid([-half_m, -0.015, 0.08], [half_m, 0.015, height_m - 0.05]), mesh);
    ObjectShape::new(AnnotationClass::Fence, posts.chain([panel]))
}

fn upright(height_m: f32, radius_m: f32) -> (Solid, Material) {
    (Solid::cylinder([0.0; 3], [0.0, 0.0, height_m], radius_m), Material::METAL)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[track_caller]
    fn check(make: impl Fn(&mut ChaCha8Rng) -> ObjectShape, heights_m: [f32; 2]) {
        let mut rng = ChaCha8Rng::from_seed([5; 32]);
        for _ in 0..50 {
            let bounds = make(&mut rng).bounds();
            assert!((heights_m[0]..heights_m[1]).contains(&bounds.maxs.z), "height {}", bounds.maxs.z);
            assert!(bounds.mins.z.abs() < 1e-3, "it stands on the ground: {}", bounds.mins.z);
        }
    }

    #[test]
    fn furniture_is_as_high_as_in_the_street() {
        check(lamp_post, [5.0, 9.5]);
        check(sign, [2.2, 3.1]);
        check(traffic_light, [2.9, 3.7]);
        check(bollard, [0.7, 1.2]);
        check(bin, [0.8, 1.4]);
        check(mail_box, [1.1, 1.6]);
        check(bench, [0.8, 0.9]);
        check(advertising_column, [2.7, 3.7]);
        check(|rng| fence(7.0, rng), [0.8, 1.6]);
    }
}
