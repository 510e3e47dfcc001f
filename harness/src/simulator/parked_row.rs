//! Vehicles parked along the kerb, bumper to bumper.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::person_shape;
use super::portable_math;
use super::road_plan::Parking;
use super::roadside::Roadside;
use super::vehicle_shape;
use super::world::{Placement, Stance, World};

/// How full the kerb is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParkedRowParams {
    /// How the vehicles stand.
    pub parking: Parking,
    /// Share of the spaces that are taken, 0 to 1.
    pub occupied_share: f64,
    /// Chance that a person stands beside a vehicle that is parked along the kerb, on the side of the road or of the
    /// pavement.
    pub person_beside: f64,
}

/// Parks vehicles 0.3 to 1.0 m apart at the kerb of `roadside`.
pub fn parked_row(world: &mut World, roadside: &Roadside, params: &ParkedRowParams, rng: &mut ChaCha8Rng) {
    match params.parking {
        Parking::Nowhere => {}
        Parking::AlongKerb { .. } => row_along_kerb(world, roadside, params, rng),
        Parking::Askew { turned_rad } => row_askew(world, roadside, params.occupied_share, turned_rad, rng),
    }
}

/// Side by side with the nose to the kerb, turned by `turned_rad` toward it.
fn row_askew(
    world: &mut World,
    roadside: &Roadside,
    occupied_share: f64,
    turned_rad: f32,
    rng: &mut ChaCha8Rng,
) {
    let (sine, cosine) = portable_math::sin_cos(f64::from(turned_rad));
    let (sine, cosine) = (sine as f32, cosine as f32);
    let [mut along_m, end_m] = roadside.reach_m;
    while along_m < end_m - 5.0 {
        // Vans would stand in the way of the traffic.
        let shape = vehicle_shape::car(rng);
        let size = shape.bounds().extents();
        let width_along_m = size.y / sine;
        let middle_m = along_m + f32::midpoint(width_along_m, size.x * cosine);
        along_m += width_along_m + rng.random_range(0.45..1.0) / sine;
        if rng.random_bool(occupied_share) {
            let from_kerb_m = 0.15 + f32::midpoint(size.x * sine, size.y * cosine);
            let mut placement =
                roadside.along_traffic(middle_m, roadside.kerb_m - from_kerb_m, Stance::OnSlope);
            placement.turned_rad -= turned_rad + rng.random_range(-0.03..0.03);
            world.stand(shape, &placement);
        }
    }
}

fn row_along_kerb(world: &mut World, roadside: &Roadside, params: &ParkedRowParams, rng: &mut ChaCha8Rng) {
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
