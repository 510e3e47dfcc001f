//! A narrow street: one way, houses close by, cars parked on one or both sides, slim pavements.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::ground::Ground;
use super::house_row::{HouseRowParams, house_row};
use super::parked_row::{ParkedRowParams, parked_row};
use super::pavement_furniture::{PavementFurnitureParams, pavement_furniture};
use super::pavement_people::{PavementPeopleParams, pavement_people};
use super::road_axis::{RoadAxisShape, Wave};
use super::road_plan::{MARGIN_M, Parking, RoadPlan};
use super::roadside::Side;
use super::street_conditions::StreetConditions;
use super::traffic::{Lane, bicycle_traffic, lane_traffic};
use super::world::World;

const DRIVE_DURATION_S: f32 = 40.0;

/// Draws a narrow street.
pub fn narrow_street(conditions: &StreetConditions, rng: &mut ChaCha8Rng) -> World {
    let speed_m_per_s = rng.random_range(3.0_f32..7.0);
    let plan = RoadPlan {
        road_idx: 0,
        lanes_m: rng.random_range(1.8..2.3),
        parking: parking(rng).map(|it| it.widened(conditions.parking_room_m())),
        pavement_width_m: rng.random_range(1.2..2.6),
        reach_m: [-MARGIN_M, speed_m_per_s * DRIVE_DURATION_S + MARGIN_M],
    };
    let (ground, ego) = (ground(&plan, conditions, rng), plan.drive(0.0, speed_m_per_s));
    let mut world = World::new(ground, ego, DRIVE_DURATION_S, conditions.fleet());
    for side in [Side::Left, Side::Right] {
        furnish(&mut world, &plan, side, conditions, rng);
    }
    traffic(&mut world, &plan, rng);
    world
}

/// Vehicles park on both sides of every third street, else on one.
fn parking(rng: &mut ChaCha8Rng) -> [Parking; 2] {
    let lane = Parking::along_kerb(rng);
    match rng.random_range(0..3_u32) {
        0 => [lane, Parking::Nowhere],
        1 => [Parking::Nowhere, lane],
        _ => [lane; 2],
    }
}

fn ground(plan: &RoadPlan, conditions: &StreetConditions, rng: &mut ChaCha8Rng) -> Ground {
    let shape = RoadAxisShape {
        bends: Wave::any(1.0..6.0, 150.0..300.0, rng),
        gradient: rng.random_range(-0.1..0.1),
        hills: Wave::any(0.0..1.0, 150.0..300.0, rng),
        ..RoadAxisShape::straight(plan.reach_m)
    };
    plan.ground(shape, conditions, rng)
}

fn furnish(
    world: &mut World,
    plan: &RoadPlan,
    side: Side,
    conditions: &StreetConditions,
    rng: &mut ChaCha8Rng,
) {
    let roadside = plan.roadside(side);
    let parked = ParkedRowParams {
        parking: plan.parking(side),
        occupied_share: rng.random_range(0.5..0.9),
        person_beside: 0.08,
    };
    parked_row(world, &roadside, &parked, rng);
    let furniture = PavementFurnitureParams {
        spacing_m: rng.random_range(7.0..14.0),
        from_kerb_m: 0.42,
        tree_share: rng.random_range(0.0..0.15),
        avenue: conditions.avenue,
    };
    pavement_furniture(world, &roadside, &furniture, rng);
    let people = PavementPeopleParams { spacing_m: rng.random_range(10.0..30.0), from_kerb_m: 0.85 };
    pavement_people(world, &roadside, &people, rng);
    let houses = conditions.houses(HouseRowParams {
        gap: rng.random_range(0.0..0.3),
        gap_m: [3.0, 9.0],
        set_back: rng.random_range(0.0..0.3),
        garden_m: HouseRowParams::TOWN_GARDENS_M,
    });
    house_row(world, &roadside, &houses, rng);
}

fn traffic(world: &mut World, plan: &RoadPlan, rng: &mut ChaCha8Rng) {
    let vehicles = Lane {
        road_idx: plan.road_idx,
        left_m: 0.0,
        speed_m_per_s: world.ego.speed_m_per_s,
        reach_m: plan.reach_m,
        spacing_m: rng.random_range(25.0..70.0),
        turning_off: None,
    };
    lane_traffic(world, &vehicles, [-6.0, 9.0], DRIVE_DURATION_S, rng);
    // Bicycles may go against the traffic; they pass at its edge.
    let bicycles = Lane {
        left_m: plan.lanes_m - 0.3,
        speed_m_per_s: -rng.random_range(3.0_f32..5.0),
        spacing_m: 80.0,
        ..vehicles
    };
    bicycle_traffic(world, &bicycles, DRIVE_DURATION_S, rng);
}
