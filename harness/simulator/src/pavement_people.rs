//! People who walk and stand on pavements.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::person_shape;
use super::roadside::Roadside;
use super::world::{Body, Course, Placement, Stance, World};

/// How busy a pavement is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PavementPeopleParams {
    /// Mean distance between people or groups, in metres.
    pub spacing_m: f32,
    /// How near to the kerb they come, in metres.
    pub from_kerb_m: f32,
}

/// Fills the pavement of `roadside` with people alone and in groups of up to three abreast, walking either way or
/// standing.
pub fn pavement_people(
    world: &mut World,
    roadside: &Roadside,
    params: &PavementPeopleParams,
    rng: &mut ChaCha8Rng,
) {
    let nearest_m = roadside.kerb_m + params.from_kerb_m;
    let farthest_m = (roadside.building_line_m - 0.5).max(nearest_m + 0.1);
    let [mut along_m, end_m] = roadside.reach_m;
    loop {
        along_m += params.spacing_m * rng.random_range(0.3..1.7);
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

/// Lets a person stand `along_m` along the road and `from_axis_m` from its axis, facing any way.
pub fn stand_person(
    world: &mut World,
    roadside: &Roadside,
    [along_m, from_axis_m]: [f32; 2],
    rng: &mut ChaCha8Rng,
) {
    let build = person_shape::any_build(rng);
    let turned_rad = rng.random_range(-3.1..3.1);
    let upright = roadside.facing_road(along_m, from_axis_m);
    world.stand(person_shape::pedestrian(&build, 0.0), &Placement { turned_rad, ..upright });
}

fn person(
    world: &mut World,
    roadside: &Roadside,
    [along_m, from_axis_m, speed_m_per_s]: [f32; 3],
    rng: &mut ChaCha8Rng,
) {
    if speed_m_per_s == 0.0 {
        return stand_person(world, roadside, [along_m, from_axis_m], rng);
    }
    let build = person_shape::any_build(rng);
    let start = roadside.position(along_m, from_axis_m);
    let course = Course::along(roadside.road_idx, start, speed_m_per_s, roadside.reach_m);
    world.follow(Body::Walker(build), Course { stance: Stance::Upright, ..course });
}
