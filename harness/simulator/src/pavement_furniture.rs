//! Trees, lamps, signs, bins and the like along the kerb.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::object_shape::ObjectShape;
use super::roadside::Roadside;
use super::world::World;
use super::{furniture_shape, person_shape, vegetation_shape};

/// How a pavement is furnished.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PavementFurnitureParams {
    /// Mean distance between things, in metres.
    pub spacing_m: f32,
    /// How far from the kerb their middle stands, in metres.
    pub from_kerb_m: f32,
    /// Share of them that are trees, 0 to 1.
    pub tree_share: f64,
    /// Whether broad trees stand among them, in a row.
    pub avenue: bool,
}

/// The random stream of broad trees.
const AVENUE_STREAM: u64 = 71;

/// Furnishes the pavement of `roadside`.
pub fn pavement_furniture(
    world: &mut World,
    roadside: &Roadside,
    params: &PavementFurnitureParams,
    rng: &mut ChaCha8Rng,
) {
    if params.avenue {
        // A random stream of their own: everything else stands where it would stand without them.
        let mut apart = rng.clone();
        apart.set_stream(AVENUE_STREAM);
        broad_trees(world, roadside, params.from_kerb_m, &mut apart);
    }
    let [mut along_m, end_m] = roadside.reach_m;
    loop {
        along_m += params.spacing_m * rng.random_range(0.4..1.6);
        if along_m > end_m {
            return;
        }
        let shape = if rng.random_bool(params.tree_share) {
            vegetation_shape::tree(rng)
        } else {
            street_furniture(params, rng)
        };
        let from_axis_m = roadside.kerb_m + params.from_kerb_m;
        world.stand(shape, &roadside.facing_road(along_m, from_axis_m));
    }
}

/// Plants a row of trees as far from the kerb as everything else; some are missing.
fn broad_trees(world: &mut World, roadside: &Roadside, from_kerb_m: f32, rng: &mut ChaCha8Rng) {
    let [mut along_m, end_m] = roadside.reach_m;
    let spacing_m = rng.random_range(6.0_f32..11.0);
    loop {
        along_m += spacing_m * rng.random_range(0.9..1.1);
        if along_m > end_m {
            return;
        }
        if rng.random_bool(0.85) {
            let tree = vegetation_shape::broad_tree(rng);
            world.stand(tree, &roadside.facing_road(along_m, roadside.kerb_m + from_kerb_m));
        }
    }
}

fn street_furniture(params: &PavementFurnitureParams, rng: &mut ChaCha8Rng) -> ObjectShape {
    match rng.random_range(0..100_u32) {
        0..28 => furniture_shape::lamp_post(rng),
        28..50 => furniture_shape::sign(rng),
        50..62 => furniture_shape::bollard(rng),
        62..75 => furniture_shape::bin(rng),
        75..80 => furniture_shape::mail_box(rng),
        80..88 => furniture_shape::bench(rng),
        88..97 => person_shape::parked_bicycle(),
        // A column needs room on both sides.
        _ if params.from_kerb_m >= 0.65 => furniture_shape::advertising_column(rng),
        _ => furniture_shape::bollard(rng),
    }
}
