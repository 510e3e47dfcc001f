//! A main road: traffic both ways, parked rows, pavements with trees and lamps, houses on both sides.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::ground::Ground;
use super::house_row::{HouseRowParams, house_row};
use super::parked_row::{ParkedRowParams, parked_row, second_row_stream};
use super::pavement_furniture::{PavementFurnitureParams, pavement_furniture};
use super::pavement_people::{PavementPeopleParams, pavement_people};
use super::road_axis::{RoadAxisShape, Wave};
use super::road_plan::{MARGIN_M, Parking, RoadPlan};
use super::roadside::{Roadside, Side};
use super::street_conditions::StreetConditions;
use super::traffic::{Lane, bicycle_traffic, lane_traffic};
use super::world::World;

const DRIVE_DURATION_S: f32 = 40.0;

/// Draws a main road.
pub fn main_road(conditions: &StreetConditions, rng: &mut ChaCha8Rng) -> World {
    let speed_m_per_s = rng.random_range(7.0_f32..13.0);
    let n_lanes_each_way = if rng.random_bool(0.3) { 2 } else { 1 };
    let lane_width_m = rng.random_range(3.5_f32..4.0);
    let plan = RoadPlan {
        road_idx: 0,
        lanes_m: n_lanes_each_way as f32 * lane_width_m,
        parking: [parking(rng), parking(rng)].map(|it| it.widened(conditions.parking_room_m())),
        pavement_width_m: rng.random_range(2.8..5.5),
        reach_m: [-MARGIN_M, speed_m_per_s * DRIVE_DURATION_S + MARGIN_M],
    };
    let lanes = lanes(&plan, n_lanes_each_way, speed_m_per_s, rng);
    let ego = plan.drive(lanes.with_ego[0].left_m, speed_m_per_s);
    let mut world = World::new(ground(&plan, conditions, rng), ego, DRIVE_DURATION_S, conditions.fleet());
    for side in [Side::Left, Side::Right] {
        let roadside = plan.roadside(side);
        let parked = ParkedRowParams {
            parking: plan.parking(side),
            occupied_share: rng.random_range(0.35..0.85),
            person_beside: 0.12,
        };
        parked_row(&mut world, &roadside, &parked, rng);
        furnish(&mut world, &roadside, conditions, rng);
    }
    traffic(&mut world, &lanes, rng);
    world
}

/// Along every fifth kerb with parked vehicles some stand in a second row.
fn parking(rng: &mut ChaCha8Rng) -> Parking {
    let mut apart = second_row_stream(rng);
    match Parking::any(0.3, 0.15, rng) {
        Parking::AlongKerb { .. } if apart.random_bool(0.2) => Parking::in_two_rows(&mut apart),
        parking => parking,
    }
}

fn ground(plan: &RoadPlan, conditions: &StreetConditions, rng: &mut ChaCha8Rng) -> Ground {
    let shape = RoadAxisShape {
        bends: Wave::any(0.0..7.0, 350.0..700.0, rng),
        gradient: rng.random_range(-0.05..0.05),
        hills: Wave::any(0.3..2.2, 160.0..350.0, rng),
        ..RoadAxisShape::straight(plan.reach_m)
    };
    plan.ground(shape, conditions, rng)
}

fn furnish(world: &mut World, roadside: &Roadside, conditions: &StreetConditions, rng: &mut ChaCha8Rng) {
    let furniture = PavementFurnitureParams {
        spacing_m: rng.random_range(3.5..7.5),
        from_kerb_m: 0.65,
        tree_share: rng.random_range(0.1..0.5),
        avenue: conditions.avenue,
    };
    pavement_furniture(world, roadside, &furniture, rng);
    let people = PavementPeopleParams { spacing_m: rng.random_range(8.0..25.0), from_kerb_m: 1.3 };
    pavement_people(world, roadside, &people, rng);
    let houses = conditions.houses(HouseRowParams {
        gap: rng.random_range(0.3..0.8),
        gap_m: [4.0, 16.0],
        set_back: rng.random_range(0.1..0.7),
        garden_m: HouseRowParams::TOWN_GARDENS_M,
    });
    house_row(world, roadside, &houses, rng);
}

/// All lanes of the road.
struct Lanes {
    /// The ego vehicle's own lane first.
    with_ego: Vec<Lane>,
    oncoming: Vec<Lane>,
    bicycles: [Lane; 2],
}

fn lanes(plan: &RoadPlan, n_lanes_each_way: u32, ego_speed_m_per_s: f32, rng: &mut ChaCha8Rng) -> Lanes {
    let spacing_m = rng.random_range(18.0_f32..50.0);
    let lane = |left_m: f32, speed_m_per_s: f32| Lane {
        road_idx: plan.road_idx,
        left_m,
        speed_m_per_s,
        reach_m: plan.reach_m,
        spacing_m,
        turning_off: None,
    };
    // Vehicles keep to the inner side of their lanes and leave the edge to bicycles.
    let lane_width_m = plan.lanes_m / n_lanes_each_way as f32;
    let outer_m = plan.lanes_m - lane_width_m / 2.0 - 0.3;
    let from_axis_m = |lane_idx: u32| outer_m - lane_idx as f32 * lane_width_m;
    let with_ego = (0..n_lanes_each_way)
        .map(|lane_idx| lane(-from_axis_m(lane_idx), ego_speed_m_per_s + 2.0 * lane_idx as f32));
    let oncoming = (0..n_lanes_each_way)
        .map(|lane_idx| lane(from_axis_m(lane_idx), -rng.random_range(8.0_f32..14.0)))
        .collect();
    let bicycles = [Side::Left, Side::Right].map(|side| Lane {
        spacing_m: 60.0,
        ..lane(side.sign() * (plan.lanes_m - 0.4), -side.sign() * rng.random_range(3.5_f32..6.0))
    });
    Lanes { with_ego: with_ego.collect(), oncoming, bicycles }
}

fn traffic(world: &mut World, lanes: &Lanes, rng: &mut ChaCha8Rng) {
    for (lane, lane_idx) in lanes.with_ego.iter().zip(0..) {
        let kept_free_m = if lane_idx == 0 { [-6.0, 8.0] } else { [0.0, 0.0] };
        lane_traffic(world, lane, kept_free_m, DRIVE_DURATION_S, rng);
    }
    for lane in &lanes.oncoming {
        lane_traffic(world, lane, [0.0, 0.0], DRIVE_DURATION_S, rng);
    }
    for lane in &lanes.bicycles {
        bicycle_traffic(world, lane, DRIVE_DURATION_S, rng);
    }
}
