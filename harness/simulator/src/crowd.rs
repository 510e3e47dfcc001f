//! Crowded pavements: cycles in racks and at walls, children, groups, people who sit, riders who wait.

use std::f32::consts::{FRAC_PI_2, PI};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::verge::{Spot, spots};
use super::world::World;
use super::{cycle_shape, furniture_shape, person_shape};

/// Fills the pavements of all roads.
pub fn crowd(world: &mut World, rng: &mut ChaCha8Rng) {
    // A town of bicycles, or one of scooters.
    let motor_share = *[0.1, 0.5, 0.9].get(rng.random_range(0..3_usize)).expect("three");
    for spot in spots(world, &(4.0..13.0), rng) {
        match rng.random_range(0..100_u32) {
            0..40 => rack(world, &spot, motor_share, rng),
            40..65 => group(world, &spot, rng),
            65..75 => seated(world, &spot, rng),
            75..90 => at_wall(world, &spot, motor_share, rng),
            _ => waiting_rider(world, &spot, rng),
        }
    }
}

/// Cycles side by side, nearly at right angles to the road, as near to each other as they can stand.
fn rack(world: &mut World, spot: &Spot, motor_share: f64, rng: &mut ChaCha8Rng) {
    let spacing_m = rng.random_range(0.35_f32..1.0);
    let slanted_rad = rng.random_range(-0.6_f32..0.6);
    // At the kerb, on the edge of the road or at the wall.
    let beyond_kerb_m = rng.random_range(-0.2..spot.pavement_m());
    for place in 0..rng.random_range(2..14_u32) {
        if rng.random_bool(0.85) {
            let nose_rad = if rng.random_bool(0.8) { FRAC_PI_2 } else { -FRAC_PI_2 };
            let ahead_m = place as f32 * spacing_m + rng.random_range(-0.08_f32..0.08);
            let aside_m = rng.random_range(-0.15_f32..0.15);
            let turned_rad = nose_rad + slanted_rad + rng.random_range(-0.12_f32..0.12);
            let shape = cycle_shape::any_parked(motor_share, rng);
            world.stand(shape, &spot.behind_kerb([ahead_m, beyond_kerb_m + aside_m], turned_rad));
        }
    }
}

/// People who stand together, children among them, at an arm's length.
fn group(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let middle_m = rng.random_range(0.4..spot.pavement_m());
    let n = rng.random_range(2..7_u32);
    let radius_m = 0.16 * n as f32 * rng.random_range(0.8_f32..1.5);
    for member in 0..n {
        let angle_rad = 2.0 * PI * member as f32 / n as f32;
        let (sine, cosine) = super::world::sine_and_cosine(angle_rad.into());
        let build =
            if rng.random_bool(0.3) { person_shape::any_child(rng) } else { person_shape::any_build(rng) };
        let position_m = [radius_m * cosine, middle_m + radius_m * sine];
        let facing_rad = angle_rad + PI + rng.random_range(-0.6_f32..0.6);
        world.stand(person_shape::pedestrian(&build, 0.0), &spot.behind_kerb(position_m, facing_rad));
    }
}

/// A bench with people on it.
fn seated(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let beyond_kerb_m = rng.random_range(0.6..spot.pavement_m() + 0.2);
    world.stand(furniture_shape::bench(rng), &spot.behind_kerb([0.0, beyond_kerb_m], 0.0));
    for seat in 0..rng.random_range(1..3_u32) {
        let build = person_shape::any_build(rng);
        let ahead_m = if seat == 0 { -0.35 } else { 0.35 };
        let placement = spot.behind_kerb([ahead_m, beyond_kerb_m], FRAC_PI_2);
        world.stand(person_shape::sitting_person(&build), &placement);
    }
}

/// A cycle along the wall, sometimes with its owner beside it.
fn at_wall(world: &mut World, spot: &Spot, motor_share: f64, rng: &mut ChaCha8Rng) {
    let from_wall_m = rng.random_range(0.3_f32..0.6);
    let turned_rad = rng.random_range(-0.15_f32..0.15);
    let shape = cycle_shape::any_parked(motor_share, rng);
    world.stand(shape, &spot.behind_line([0.0, -from_wall_m], turned_rad));
    if rng.random_bool(0.5) {
        let build = person_shape::any_build(rng);
        let beside_m = [rng.random_range(-0.4_f32..0.4), -from_wall_m - rng.random_range(0.45_f32..0.8)];
        world.stand(person_shape::pedestrian(&build, 0.0), &spot.behind_line(beside_m, turned_rad));
    }
}

/// A rider who waits at the kerb.
fn waiting_rider(world: &mut World, spot: &Spot, rng: &mut ChaCha8Rng) {
    let build = person_shape::any_build(rng);
    let shape = cycle_shape::ridden_scooter(&build, rng);
    let placement = spot.behind_kerb([0.0, 0.5], rng.random_range(-0.2_f32..0.2));
    world.stand(shape, &placement);
}
