//! What stands and walks on a pavement.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::furniture_shape;
use super::object_shape::ObjectShape;
use super::person_shape;
use super::roadside::Roadside;
use super::vegetation_shape;
use super::world::{Body, Course, Placement, Stance, World};

/// How a pavement is furnished and how busy it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PavementParams {
    /// Mean distance between things that stand along the kerb, in metres.
    pub furniture_spacing_m: f32,
    /// Share of them that are trees, 0 to 1.
    pub tree_share: f64,
    /// Mean distance between people, in metres.
    pub people_spacing_m: f32,
}

/// How far from the kerb the middle of furniture stands, in metres.
const FURNITURE_STRIP_M: f32 = 0.65;

/// Furnishes the pavement of `roadside` and fills it with people.
pub fn pavement(world: &mut World, roadside: &Roadside, params: &PavementParams, rng: &mut ChaCha8Rng) {
    furniture(world, roadside, params, rng);
    people(world, roadside, params, rng);
}

fn furniture(world: &mut World, roadside: &Roadside, params: &PavementParams, rng: &mut ChaCha8Rng) {
    let [mut along_m, end_m] = roadside.reach_m;
    loop {
        along_m += params.furniture_spacing_m * rng.random_range(0.4..1.6);
        if along_m > end_m {
            return;
        }
        let shape = if rng.random_bool(params.tree_share) {
            vegetation_shape::tree(rng)
        } else {
            street_furniture(rng)
        };
        let from_axis_m = roadside.kerb_m + FURNITURE_STRIP_M;
        world.stand(shape, &roadside.facing_road(along_m, from_axis_m));
    }
}

fn street_furniture(rng: &mut ChaCha8Rng) -> ObjectShape {
    match rng.random_range(0..100_u32) {
        0..28 => furniture_shape::lamp_post(rng),
        28..50 => furniture_shape::sign(rng),
        50..62 => furniture_shape::bollard(rng),
        62..80 => furniture_shape::bin(rng),
        80..88 => furniture_shape::bench(rng),
        88..97 => person_shape::parked_bicycle(),
        _ => furniture_shape::advertising_column(rng),
    }
}

/// People alone and in groups of up to three abreast, walking either way or standing.
fn people(world: &mut World, roadside: &Roadside, params: &PavementParams, rng: &mut ChaCha8Rng) {
    let nearest_m = roadside.kerb_m + 2.0 * FURNITURE_STRIP_M;
    let farthest_m = (roadside.building_line_m - 0.6).max(nearest_m + 0.1);
    let [mut along_m, end_m] = roadside.reach_m;
    loop {
        along_m += params.people_spacing_m * rng.random_range(0.3..1.7);
        if along_m > end_m {
            return;
        }
        let from_axis_m = rng.random_range(nearest_m..farthest_m);
        let speed_m_per_s = match rng.random_range(0..10_u32) {
            0..4 => rng.random_range(0.9..1.6),
            4..8 => -rng.random_range(0.9..1.6),
            _ => 0.0,
        };
        for member in 0..rng.random_range(1..4_u32).min(rng.random_range(1..4_u32)) {
            let abreast_m = from_axis_m + 0.65 * member as f32;
            if abreast_m > roadside.building_line_m - 0.3 {
                break;
            }
            let start_m = along_m + rng.random_range(-0.2..0.2);
            person(world, roadside, [start_m, abreast_m, speed_m_per_s], rng);
        }
    }
}

fn person(
    world: &mut World,
    roadside: &Roadside,
    [along_m, from_axis_m, speed_m_per_s]: [f32; 3],
    rng: &mut ChaCha8Rng,
) {
    let build = person_shape::any_build(rng);
    if speed_m_per_s == 0.0 {
        let turned_rad = rng.random_range(-3.1..3.1);
        let upright = roadside.facing_road(along_m, from_axis_m);
        world.stand(person_shape::pedestrian(&build, 0.0), &Placement { turned_rad, ..upright });
        return;
    }
    let course = Course {
        road_idx: roadside.road_idx,
        start: roadside.position(along_m, from_axis_m),
        speed_m_per_s,
        reach_m: roadside.reach_m,
        stance: Stance::Upright,
    };
    world.follow(Body::Walker(build), course);
}
