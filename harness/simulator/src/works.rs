//! Works along roads: rows of barriers, guard rails, heaps, containers, stacks, cabins, shelters.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::clutter_shape::{BarrierKind, barrier, cabin, container, heap, shelter, stack};
use super::material::Material;
use super::pavement_people::stand_person;
use super::solid::Solid;
use super::verge::{Spot, frame, spots};
use super::world::World;

/// Sets up works along all roads.
pub fn works(world: &mut World, rng: &mut ChaCha8Rng) {
    for spot in spots(world, &(5.0..18.0), rng) {
        match rng.random_range(0..100_u32) {
            0..30 => barriers(world, &spot, rng),
            30..38 => guard_rail(world, &spot, rng),
            38..50 => stand(world, &spot, heap, rng),
            50..62 => stand(world, &spot, container, rng),
            62..72 => stand(world, &spot, stack, rng),
            72..84 => stand(world, &spot, cabin, rng),
            84..91 => stand(world, &spot, shelter, rng),
            _ => enclosure(world, &spot, rng),
        }
        if rng.random_bool(0.3) {
            let position_m = [rng.random_range(-1.5_f32..1.5), rng.random_range(0.3..spot.pavement_m())];
            stand_person(world, &spot.roadside, spot.on_pavement(position_m), rng);
        }
    }
}

/// One thing on the pavement or behind it, along the road.
fn stand(
    world: &mut World,
    spot: &Spot,
    make: fn(&mut ChaCha8Rng) -> super::object_shape::ObjectShape,
    rng: &mut ChaCha8Rng,
) {
    let shape = make(rng);
    let half_depth_m = shape.bounds().extents().y / 2.0;
    let position_m = [0.0, half_depth_m + rng.random_range(0.2..spot.pavement_m() + 1.0)];
    world.stand(shape, &spot.behind_kerb(position_m, rng.random_range(-0.15..0.15)));
}

/// A row of barriers of one kind that touch or nearly do, somewhat askew.
fn barriers(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let kind = BarrierKind::any(rng);
    let size_m = [rng.random_range(0.9_f32..3.2), rng.random_range(0.75_f32..1.2)];
    let gap_m = rng.random_range(0.0_f32..0.3);
    let beyond_kerb_m = rng.random_range(0.3..spot.pavement_m());
    for piece in 0..rng.random_range(2..13_u32) {
        let ahead_m = piece as f32 * (size_m[0] + gap_m);
        let aside_m = rng.random_range(-0.06_f32..0.06);
        let placement = spot.behind_kerb([ahead_m, beyond_kerb_m + aside_m], rng.random_range(-0.05..0.05));
        world.stand(barrier(kind, size_m), &placement);
    }
}

/// A rail on posts, in pieces that follow the road.
fn guard_rail(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    const PIECE_M: f32 = 4.0;
    let height_m = rng.random_range(0.6_f32..0.9);
    let beyond_kerb_m = rng.random_range(0.25_f32..0.6);
    for piece in 0..rng.random_range(3..14_u32) {
        let at = frame(world, &spot.behind_kerb([piece as f32 * PIECE_M, beyond_kerb_m], 0.0));
        let rail = Solid::cuboid([0.0, -0.04, height_m - 0.3], [PIECE_M, 0.04, height_m]);
        let post = Solid::cuboid([0.0, -0.12, -0.2], [0.12, -0.04, height_m]);
        world.build(&at, [rail, post].into_iter(), Material::METAL);
    }
}

/// Mesh on four sides of something.
fn enclosure(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let half_m = [rng.random_range(1.0_f32..3.5), rng.random_range(0.6_f32..1.5)];
    let height_m = rng.random_range(1.0_f32..2.0);
    let beyond_kerb_m = half_m[1] + rng.random_range(0.2..spot.pavement_m());
    for side in [-1.0_f32, 1.0] {
        let long = barrier(BarrierKind::Grating, [2.0 * half_m[0], height_m]);
        world.stand(long, &spot.behind_kerb([0.0, beyond_kerb_m + side * half_m[1]], 0.0));
        let short = barrier(BarrierKind::Grating, [2.0 * half_m[1], height_m]);
        let turned_rad = std::f32::consts::FRAC_PI_2;
        world.stand(short, &spot.behind_kerb([side * half_m[0], beyond_kerb_m], turned_rad));
    }
}
