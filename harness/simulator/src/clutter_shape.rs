//! Clutter that is as large as a vehicle, or lies in pieces of that size.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::material::Material;
use super::object_shape::ObjectShape;
use super::solid::{Prism, Solid};

/// A hedge that is cut to a block, along x.
pub fn block_hedge(rng: &mut ChaCha8Rng) -> ObjectShape {
    let half_m = [rng.random_range(0.6_f32..3.2), rng.random_range(0.3_f32..1.1)];
    let height_m = rng.random_range(0.6_f32..2.1);
    let leaves = Material::foliage(rng.random_range(0.03..0.12));
    let block = Solid::cuboid([-half_m[0], -half_m[1], 0.0], [half_m[0], half_m[1], height_m * 0.85]);
    // The top is a little slimmer, and rounded.
    let top = Solid::cuboid(
        [0.1 - half_m[0], 0.08 - half_m[1], height_m * 0.8],
        [half_m[0] - 0.1, half_m[1] - 0.08, height_m],
    );
    ObjectShape::new(AnnotationClass::Hedge, [(block, leaves), (top, leaves)])
}

/// Dense bushes that have grown into one.
pub fn bushes(rng: &mut ChaCha8Rng) -> ObjectShape {
    let leaves = Material::foliage(rng.random_range(0.05..0.3));
    let n = rng.random_range(1..5_u32);
    let mut x_m = 0.0;
    let mut parts = Vec::new();
    for _ in 0..n {
        let radius_m = rng.random_range(0.5_f32..1.3);
        let half_height_m = rng.random_range(0.35_f32..1.1);
        let y_m = rng.random_range(-0.5_f32..0.5);
        // Its widest part is near the ground.
        parts.push((Solid::spheroid([x_m, y_m, half_height_m * 0.6], radius_m, half_height_m), leaves));
        x_m += radius_m * rng.random_range(0.7_f32..1.4);
    }
    ObjectShape::new(AnnotationClass::Hedge, parts)
}

/// A tree whose crown begins at the ground or at the height of a bonnet.
pub fn low_tree(rng: &mut ChaCha8Rng) -> ObjectShape {
    let radius_m = rng.random_range(0.5_f32..2.2);
    let half_height_m = rng.random_range(0.9_f32..2.6);
    let clear_m = rng.random_range(0.0_f32..1.4);
    let leaves = Material::foliage(rng.random_range(0.15..0.9));
    let middle_m = clear_m + half_height_m;
    let trunk = Solid::cylinder([0.0; 3], [0.0, 0.0, middle_m], rng.random_range(0.05..0.2));
    let crown = Solid::spheroid([0.0, 0.0, middle_m], radius_m, half_height_m);
    ObjectShape::new(AnnotationClass::Tree, [(trunk, Material::WOOD), (crown, leaves)])
}

/// A heap of sand, earth, rubble or brushwood.
pub fn heap(rng: &mut ChaCha8Rng) -> ObjectShape {
    let height_m = rng.random_range(0.5_f32..1.9);
    let radius_m = height_m * rng.random_range(1.0_f32..1.8);
    let is_loose = rng.random_bool(0.3);
    let stuff = if is_loose { Material::foliage(0.15) } else { Material::solid(rng.random_range(0.2..0.5)) };
    let mut parts = vec![(Solid::spheroid([0.0; 3], radius_m, height_m), stuff)];
    for _ in 0..rng.random_range(1..5_u32) {
        let mut offset_m = || radius_m * rng.random_range(-0.9_f32..0.9);
        let center_m = [offset_m(), 0.6 * offset_m(), 0.0];
        let share = rng.random_range(0.35_f32..0.75);
        parts.push((Solid::spheroid(center_m, radius_m * share, height_m * share), stuff));
    }
    ObjectShape::new(AnnotationClass::StreetFurniture, parts)
}

/// A skip or a container for waste, along x.
pub fn container(rng: &mut ChaCha8Rng) -> ObjectShape {
    let half_m = [rng.random_range(0.6_f32..3.0), rng.random_range(0.5_f32..1.2)];
    let height_m = rng.random_range(1.0_f32..2.4);
    let slant_m =
        if rng.random_bool(0.5) { rng.random_range(0.1_f32..0.7).min(half_m[0] / 2.0) } else { 0.0 };
    let coat = Material::solid(rng.random_range(0.1..0.5));
    let body = Solid::Prism(Prism {
        profile_m: vec![
            [slant_m - half_m[0], 0.1],
            [half_m[0] - slant_m, 0.1],
            [half_m[0], height_m],
            [-half_m[0], height_m],
        ],
        center_y_m: 0.0,
        bottom_half_width_m: half_m[1],
        top_half_width_m: half_m[1],
    });
    let feet =
        Solid::cuboid([0.4 - half_m[0], 0.1 - half_m[1], 0.0], [half_m[0] - 0.4, half_m[1] - 0.1, 0.1]);
    ObjectShape::new(AnnotationClass::StreetFurniture, [(body, coat), (feet, Material::RUBBER)])
}

/// Boards, stones or pipes in a stack, along x.
pub fn stack(rng: &mut ChaCha8Rng) -> ObjectShape {
    let half_m = [rng.random_range(0.5_f32..2.5), rng.random_range(0.4_f32..0.9)];
    let n_layers = rng.random_range(1..5_u32);
    let layer_m = rng.random_range(0.15_f32..0.45);
    let stuff = Material::solid(rng.random_range(0.2..0.5));
    let is_round = rng.random_bool(0.3);
    let mut parts = Vec::new();
    for layer in 0..n_layers {
        let bottom_m = layer as f32 * layer_m;
        let in_m = rng.random_range(0.0_f32..0.25);
        if is_round {
            for lane in -2..=2_i32 {
                let at = |x_m: f32| [x_m, lane as f32 * half_m[1] / 2.5, bottom_m + layer_m / 2.0];
                parts.push((Solid::cylinder(at(-half_m[0]), at(half_m[0]), layer_m / 2.0), stuff));
            }
        } else {
            let side = |sign: f32, axis: usize| sign * (half_m[axis] - in_m * 0.5);
            let piece = Solid::cuboid(
                [side(-1.0, 0), side(-1.0, 1), bottom_m],
                [side(1.0, 0), side(1.0, 1), bottom_m + layer_m * 0.9],
            );
            parts.push((piece, stuff));
        }
    }
    ObjectShape::new(AnnotationClass::StreetFurniture, parts)
}

/// A cabin, a kiosk or a box for cables and transformers, along x.
pub fn cabin(rng: &mut ChaCha8Rng) -> ObjectShape {
    let half_m = [rng.random_range(0.3_f32..2.2), rng.random_range(0.2_f32..1.2)];
    let height_m = rng.random_range(0.8_f32..2.7);
    let coat = Material::solid(rng.random_range(0.15..0.5));
    let body = Solid::cuboid([-half_m[0], -half_m[1], 0.0], [half_m[0], half_m[1], height_m]);
    let eaves_m = 0.12;
    let roof = Solid::cuboid(
        [-half_m[0] - eaves_m, -half_m[1] - eaves_m, height_m],
        [half_m[0] + eaves_m, half_m[1] + eaves_m, height_m + 0.1],
    );
    let roofed = rng.random_bool(0.5).then_some((roof, Material::METAL));
    ObjectShape::new(AnnotationClass::StreetFurniture, [(body, coat)].into_iter().chain(roofed))
}

/// A shelter at a stop, along x, open toward +y: posts, panes behind and at the ends, a bench, a roof.
pub fn shelter(rng: &mut ChaCha8Rng) -> ObjectShape {
    let half_m = [rng.random_range(1.2_f32..2.4), rng.random_range(0.5_f32..0.8)];
    let height_m = rng.random_range(2.2_f32..2.6);
    let post =
        |x_m: f32, y_m: f32| (Solid::cylinder([x_m, y_m, 0.0], [x_m, y_m, height_m], 0.05), Material::METAL);
    let panes = Material { reflectivity: 0.3, ..Material::GLASS };
    let pane = |least_m: [f32; 2], greatest_m: [f32; 2]| {
        let [from_m, to_m] = [(least_m, 0.2), (greatest_m, height_m - 0.1)].map(|([x, y], z)| [x, y, z]);
        (Solid::cuboid(from_m, to_m), panes)
    };
    let slab = |least_m, greatest_m, material| (Solid::cuboid(least_m, greatest_m), material);
    ObjectShape::new(
        AnnotationClass::StreetFurniture,
        [
            post(-half_m[0], -half_m[1]),
            post(half_m[0], -half_m[1]),
            post(-half_m[0], half_m[1]),
            post(half_m[0], half_m[1]),
            pane([-half_m[0], -half_m[1] - 0.01], [half_m[0], 0.01 - half_m[1]]),
            pane([-half_m[0] - 0.01, -half_m[1]], [0.01 - half_m[0], half_m[1]]),
            pane([half_m[0] - 0.01, -half_m[1]], [half_m[0] + 0.01, half_m[1]]),
            slab(
                [0.3 - half_m[0], -half_m[1] + 0.1, 0.42],
                [half_m[0] - 0.3, -half_m[1] + 0.45, 0.48],
                Material::WOOD,
            ),
            slab(
                [-half_m[0] - 0.1, -half_m[1] - 0.1, height_m],
                [half_m[0] + 0.1, half_m[1] + 0.2, height_m + 0.1],
                Material::METAL,
            ),
        ],
    )
}

/// How pieces of a barrier are built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BarrierKind {
    /// Concrete or plastic, broad at the foot.
    Block,
    /// Bars or mesh on feet.
    Grating,
    /// A board on two feet.
    Board,
}

impl BarrierKind {
    /// Draws one.
    pub fn any(rng: &mut ChaCha8Rng) -> Self {
        match rng.random_range(0..10_u32) {
            0..5 => Self::Block,
            5..8 => Self::Grating,
            _ => Self::Board,
        }
    }
}

/// A piece of a barrier of this kind, length and height in metres, along x.
pub fn barrier(kind: BarrierKind, [length_m, height_m]: [f32; 2]) -> ObjectShape {
    let half_m = length_m / 2.0;
    let slab = |z_m: [f32; 2], half_depth_m: f32, material: Material| {
        (Solid::cuboid([-half_m, -half_depth_m, z_m[0]], [half_m, half_depth_m, z_m[1]]), material)
    };
    let foot = |x_m: f32| (Solid::cuboid([x_m - 0.05, -0.3, 0.0], [x_m + 0.05, 0.3, 0.06]), Material::RUBBER);
    let feet = [foot(0.15 - half_m), foot(half_m - 0.15)];
    match kind {
        BarrierKind::Block => {
            let concrete = Material::solid(0.4);
            let parts = [slab([0.0, 0.25], 0.28, concrete), slab([0.25, height_m], 0.12, concrete)];
            ObjectShape::new(AnnotationClass::StreetFurniture, parts)
        }
        BarrierKind::Grating => {
            let mesh = Material { reflectivity: 0.3, ..Material::foliage(0.06) };
            let rail = slab([height_m - 0.05, height_m], 0.02, Material::METAL);
            let parts = [slab([0.1, height_m - 0.05], 0.015, mesh), rail];
            ObjectShape::new(AnnotationClass::Fence, parts.into_iter().chain(feet))
        }
        BarrierKind::Board => {
            let board = slab([height_m - 0.3, height_m], 0.02, Material::RETROREFLECTOR);
            let leg =
                |x_m: f32| (Solid::cylinder([x_m, 0.0, 0.0], [x_m, 0.0, height_m], 0.03), Material::METAL);
            let parts = [board, leg(0.15 - half_m), leg(half_m - 0.15)];
            ObjectShape::new(AnnotationClass::StreetFurniture, parts.into_iter().chain(feet))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn clutter_is_as_large_as_vehicles_and_stands_on_the_ground() {
        let mut rng = ChaCha8Rng::from_seed([6; 32]);
        for make in [block_hedge, bushes, low_tree, heap, container, stack, cabin, shelter] {
            for _ in 0..50 {
                let bounds = make(&mut rng).bounds();
                let size = bounds.extents();
                assert!((0.3..9.0).contains(&size.x), "length {}", size.x);
                assert!((0.1..7.0).contains(&bounds.maxs.z), "height {}", bounds.maxs.z);
                assert!(bounds.mins.z < 1e-3, "it stands on the ground: {}", bounds.mins.z);
            }
        }
        for kind in [BarrierKind::Block, BarrierKind::Grating, BarrierKind::Board] {
            let bounds = barrier(kind, [2.0, 1.0]).bounds();
            assert!((bounds.extents().x - 2.0).abs() < 1e-3 && (bounds.maxs.z - 1.0).abs() < 1e-3);
        }
    }
}
