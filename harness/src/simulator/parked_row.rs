//! Vehicles parked along the kerb, bumper to bumper.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::person_shape;
use super::roadside::Roadside;
use super::vehicle_shape;
use super::world::{Placement, Stance, World};

/// How full the kerb is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParkedRowParams {
    /// Share of the spaces that are taken, 0 to 1.
    pub occupied_share: f64,
    /// Chance that a person stands beside a vehicle, on the side of the road or of the pavement.
    pub person_beside: f64,
}

/// Parks vehicles 0.3 to 1.0 m apart along the kerb of `roadside`.
pub fn parked_row(world: &mut World, roadside: &Roadside, params: &ParkedRowParams, rng: &mut ChaCha8Rng) {
    let [mut along_m, end_m] = roadside.reach_m;
    while along_m < end_m {
        if !rng.random_bool(params.occupied_share) {
            along_m += rng.random_range(4.0..9.0);
            continue;
        }
        let shape = vehicle_shape::parked_vehicle(rng);
        let size = shape.bounds().extents();
        let middle_m = along_m + size.x / 2.0;
        along_m += size.x + rng.random_range(0.3..1.0);
        if along_m > end_m {
            return;
        }
        let from_kerb_m = rng.random_range(0.12..0.35) + size.y / 2.0;
        let from_axis_m = roadside.kerb_m - from_kerb_m;
        let mut placement = roadside.along_traffic(middle_m, from_axis_m, Stance::OnSlope);
        placement.turned_rad += rng.random_range(-0.02..0.02);
        world.stand(shape, &placement);
        if rng.random_bool(params.person_beside) {
            let gap_m = rng.random_range(0.35..0.75);
            let toward_road = if rng.random_bool(0.5) { -1.0 } else { 1.0 };
            let beside_m = from_axis_m + toward_road * (size.y / 2.0 + gap_m);
            stand_person(world, roadside, [middle_m + rng.random_range(-1.5..1.5), beside_m], rng);
        }
    }
}

fn stand_person(
    world: &mut World,
    roadside: &Roadside,
    [along_m, from_axis_m]: [f32; 2],
    rng: &mut ChaCha8Rng,
) {
    let build = person_shape::any_build(rng);
    let upright = roadside.facing_road(along_m, from_axis_m);
    let turned_rad = rng.random_range(-3.1..3.1);
    world.stand(person_shape::pedestrian(&build, 0.0), &Placement { turned_rad, ..upright });
}
