//! Front gardens: low walls and beds, banks, bushes, sheds, gate posts, cars in driveways.

use std::f32::consts::FRAC_PI_2;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::clutter_shape::{block_hedge, bushes, heap, low_tree};
use super::material::Material;
use super::solid::{Prism, Solid};
use super::verge::{Spot, frame, park, spots};
use super::world::World;

/// Lays out front gardens along all roads.
pub fn gardens(world: &mut World, rng: &mut ChaCha8Rng) {
    for spot in spots(world, &(3.0..9.0), rng) {
        match rng.random_range(0..100_u32) {
            0..20 => bed(world, &spot, rng),
            20..34 => bank(world, &spot, rng),
            34..48 => {
                let turned_rad = if rng.random_bool(0.5) { 0.0 } else { FRAC_PI_2 };
                let position_m = [0.0, rng.random_range(0.5_f32..7.0)];
                world.stand(block_hedge(rng), &spot.behind_line(position_m, turned_rad + jitter_rad(rng)));
            }
            48..58 => {
                let position_m = [0.0, rng.random_range(0.3_f32..7.0)];
                world.stand(bushes(rng), &spot.behind_line(position_m, rng.random_range(-1.5..1.5)));
            }
            58..78 => driveway(world, &spot, rng),
            78..84 => shed(world, &spot, rng),
            84..91 => gate(world, &spot, rng),
            91..94 => {
                let position_m = [0.0, rng.random_range(1.0_f32..7.0)];
                world.stand(heap(rng), &spot.behind_line(position_m, rng.random_range(-1.5..1.5)));
            }
            _ => world.stand(low_tree(rng), &spot.behind_line([0.0, rng.random_range(0.5..8.0)], 0.0)),
        }
    }
}

fn jitter_rad(rng: &mut ChaCha8Rng) -> f32 {
    rng.random_range(-0.08_f32..0.08)
}

/// A raised bed or a terrace behind a low wall, with plants.
fn bed(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let half_m = rng.random_range(0.8_f32..4.5);
    let depth_m = rng.random_range(1.0_f32..5.0);
    let height_m = rng.random_range(0.25_f32..1.3);
    let thickness_m = rng.random_range(0.12_f32..0.4);
    let placement = spot.behind_line([0.0, rng.random_range(0.1..2.5)], jitter_rad(rng));
    let at = frame(world, &placement);
    let front = Solid::cuboid([-half_m, -thickness_m, -0.5], [half_m, 0.0, height_m]);
    let end =
        |from_m: f32| Solid::cuboid([from_m, -depth_m, -0.5], [from_m + thickness_m, -thickness_m, height_m]);
    let ends = [end(-half_m), end(half_m - thickness_m)];
    let masonry = Material::solid(rng.random_range(0.2..0.5));
    world.build(&at, [front].into_iter().chain(ends), masonry);
    let earth_m = height_m * rng.random_range(0.5_f32..1.0);
    let earth = Solid::cuboid([-half_m, -depth_m, -0.5], [half_m, -thickness_m, earth_m]);
    world.build(&at, [earth].into_iter(), Material::solid(0.3));
    for _ in 0..rng.random_range(0..6_u32) {
        let radius_m = rng.random_range(0.15_f32..0.7);
        let center_m = [
            rng.random_range(-half_m..half_m),
            -rng.random_range(0.0..depth_m),
            earth_m + rng.random_range(0.0_f32..0.4),
        ];
        let plant = Solid::spheroid(center_m, radius_m, rng.random_range(0.2_f32..0.8));
        world.build(&at, [plant].into_iter(), Material::foliage(rng.random_range(0.05..0.4)));
    }
}

/// Grown-over ground that rises from the building line.
fn bank(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let depth_m = rng.random_range(1.5_f32..7.0);
    let height_m = depth_m * rng.random_range(0.15_f32..0.6);
    let half_m = rng.random_range(1.0_f32..8.0);
    // x points away from the road.
    let placement = spot.behind_line([0.0, rng.random_range(0.0..2.0)], jitter_rad(rng) - FRAC_PI_2);
    let at = frame(world, &placement);
    let slope = Solid::Prism(Prism {
        profile_m: vec![[0.0, -0.5], [depth_m, -0.5], [depth_m, height_m], [0.0, 0.02]],
        center_y_m: 0.0,
        bottom_half_width_m: half_m,
        top_half_width_m: half_m * rng.random_range(0.5_f32..1.0),
    });
    let is_mown = rng.random_bool(0.5);
    let cover = if is_mown { Material::solid(0.4) } else { Material::foliage(rng.random_range(0.03..0.12)) };
    world.build(&at, [slope].into_iter(), cover);
    for _ in 0..rng.random_range(0..5_u32) {
        let along_m = rng.random_range(0.0..depth_m);
        let radius_m = rng.random_range(0.2_f32..0.9);
        let center_m =
            [along_m, rng.random_range(-half_m..half_m), height_m * along_m / depth_m + radius_m / 2.0];
        let plant = Solid::spheroid(center_m, radius_m, radius_m * rng.random_range(0.6_f32..1.4));
        world.build(&at, [plant].into_iter(), Material::foliage(rng.random_range(0.05..0.4)));
    }
}

/// A car with its nose or its rear to the road, and sometimes a second one beside it.
fn driveway(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let n_cars = if rng.random_bool(0.25) { 2 } else { 1_u32 };
    for car in 0..n_cars {
        let shape = world.fleet.car(rng);
        let size = shape.bounds().extents();
        let turned_rad = if rng.random_bool(0.5) { FRAC_PI_2 } else { -FRAC_PI_2 };
        let position_m = [2.6 * car as f32, rng.random_range(1.2_f32..4.0) + size.x / 2.0];
        park(world, shape, &spot.behind_line(position_m, turned_rad + jitter_rad(rng)));
    }
}

fn shed(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let half_m = [rng.random_range(0.8_f32..2.2), rng.random_range(0.6_f32..1.6)];
    let height_m = rng.random_range(1.6_f32..2.6);
    let at = frame(world, &spot.behind_line([0.0, rng.random_range(1.5..7.0)], jitter_rad(rng)));
    let walls = Solid::cuboid([-half_m[0], -half_m[1], -0.3], [half_m[0], half_m[1], height_m]);
    let roof = Solid::Prism(Prism {
        profile_m: vec![[-half_m[0] - 0.2, height_m], [half_m[0] + 0.2, height_m], [0.0, height_m + 0.5]],
        center_y_m: 0.0,
        bottom_half_width_m: half_m[1] + 0.15,
        top_half_width_m: half_m[1] + 0.15,
    });
    world.build(&at, [walls, roof].into_iter(), Material::WOOD);
}

/// Two posts with pieces of a wall on either side.
fn gate(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let half_gap_m = rng.random_range(0.6_f32..2.0);
    let [post_m, wall_m] = [rng.random_range(0.15_f32..0.35), rng.random_range(0.5_f32..3.0)];
    let [post_height_m, wall_height_m] = [rng.random_range(1.0_f32..2.1), rng.random_range(0.5_f32..1.3)];
    let at = frame(world, &spot.behind_line([0.0, rng.random_range(0.0..1.0)], jitter_rad(rng)));
    let block = |x_m: [f32; 2], half_depth_m: f32, height_m: f32| {
        let [from_m, to_m] = [x_m[0].min(x_m[1]), x_m[0].max(x_m[1])];
        Solid::cuboid([from_m, -half_depth_m, -0.3], [to_m, half_depth_m, height_m])
    };
    let solids = [-1.0, 1.0].into_iter().flat_map(|side: f32| {
        let [inner_m, middle_m, outer_m] =
            [half_gap_m, half_gap_m + 2.0 * post_m, half_gap_m + 2.0 * post_m + wall_m].map(|it| side * it);
        [block([inner_m, middle_m], post_m, post_height_m), block([middle_m, outer_m], 0.12, wall_height_m)]
    });
    world.build(&at, solids, Material::MASONRY);
}
