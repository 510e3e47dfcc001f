//! Two roads that cross: one flows, on the other vehicles wait.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::furniture_shape;
use super::ground::{Banks, Ground, Road};
use super::house_row::{HouseRowParams, house_row};
use super::parked_row::{ParkedRowParams, parked_row};
use super::pavement_furniture::{PavementFurnitureParams, pavement_furniture};
use super::pavement_people::{PavementPeopleParams, pavement_people};
use super::road_axis::{RoadAxis, RoadAxisShape, Wave};
use super::road_plan::{MARGIN_M, Parking, RoadPlan};
use super::roadside::{Roadside, Side};
use super::street_conditions::StreetConditions;
use super::traffic::{Lane, TurningOff, WaitingQueueParams, lane_traffic, waiting_queue};
use super::world::{RightTurn, World};

const DRIVE_DURATION_S: f32 = 20.0;
const MAIN: usize = 0;
const CROSSING: usize = 1;
/// Kept free of parked vehicles and furniture before and after the corner, in metres beyond the kerb.
const CORNER_CLEARANCE_M: f32 = 7.0;
/// Depth of the corner houses, in metres: where the houses of the crossing road begin.
const CORNER_HOUSE_M: f32 = 11.5;

/// Both roads of an intersection.
struct Plans {
    main: RoadPlan,
    crossing: RoadPlan,
    /// Where they cross, in metres along the main road; on the crossing road it is 0.
    crossed_at_m: f32,
}

/// Draws an intersection that the drive reaches after a few seconds.
pub fn intersection(conditions: &StreetConditions, rng: &mut ChaCha8Rng) -> World {
    let speed_m_per_s = rng.random_range(4.0_f32..8.0);
    let plans = plans(speed_m_per_s, conditions, rng);
    let ego = plans.main.drive(-plans.main.lanes_m / 2.0, speed_m_per_s);
    let mut world = World::new(ground(&plans, conditions, rng), ego, DRIVE_DURATION_S, conditions.fleet());
    for side in [Side::Left, Side::Right] {
        let [main, crossing] = [&plans.main, &plans.crossing].map(|plan| plan.roadside(side));
        let along_main = [plans.crossed_at_m, crossing.kerb_m, crossing.building_line_m];
        furnish(&mut world, &plans.main, side, conditions, along_main, rng);
        let along_crossing = [0.0, main.kerb_m, main.building_line_m + CORNER_HOUSE_M];
        furnish(&mut world, &plans.crossing, side, conditions, along_crossing, rng);
    }
    corner_posts(&mut world, &plans, rng);
    traffic(&mut world, &plans, rng);
    world
}

fn plans(ego_speed_m_per_s: f32, conditions: &StreetConditions, rng: &mut ChaCha8Rng) -> Plans {
    let mut plan = |road_idx, reach_m| {
        // Both sides have the same parking, so that the corners are alike.
        let parking = Parking::any(0.4, 0.0, rng).widened(conditions.parking_room_m());
        RoadPlan {
            road_idx,
            lanes_m: rng.random_range(3.2..4.2),
            parking: [parking; 2],
            pavement_width_m: rng.random_range(2.4..4.5),
            reach_m,
        }
    };
    let main = plan(MAIN, [-MARGIN_M, ego_speed_m_per_s * DRIVE_DURATION_S + MARGIN_M]);
    let crossing = plan(CROSSING, [-MARGIN_M, MARGIN_M]);
    Plans { main, crossing, crossed_at_m: rng.random_range(15.0..40.0) }
}

fn ground(plans: &Plans, conditions: &StreetConditions, rng: &mut ChaCha8Rng) -> Ground {
    let main = RoadAxis::new(&conditions.road(RoadAxisShape {
        gradient: rng.random_range(-0.05..0.05),
        hills: Wave::any(0.2..1.5, 160.0..350.0, rng),
        ..RoadAxisShape::straight(plans.main.reach_m)
    }));
    let crossing = RoadAxis::new(&conditions.road(RoadAxisShape {
        origin_m: [plans.crossed_at_m, 0.0],
        heading_rad: std::f32::consts::FRAC_PI_2,
        gradient: rng.random_range(-0.03..0.03),
        ..RoadAxisShape::straight(plans.crossing.reach_m)
    }));
    let main_section = conditions.section(plans.main.cross_section(rng));
    let mut crossing_section = plans.crossing.cross_section(rng);
    crossing_section.kerb_height_m = main_section.kerb_height_m;
    crossing_section.crown = main_section.crown;
    // The crossing road falls away with the land.
    let banks = Banks::any(main_section.left_kerb_m + plans.main.pavement_width_m, rng);
    let roads = vec![
        Road { axis: main, section: main_section, banks },
        Road { axis: crossing, section: crossing_section, banks: Banks::LEVEL },
    ];
    Ground {
        roads,
        pavement_width_m: plans.main.pavement_width_m,
        corner_radius_m: rng.random_range(2.0..6.0),
    }
}

/// Furnishes one side of one road before and after the other road, which meets it at `middle_m`, has its kerb
/// `kerb_m` and its first houses `houses_m` from there.
fn furnish(
    world: &mut World,
    plan: &RoadPlan,
    side: Side,
    conditions: &StreetConditions,
    [middle_m, kerb_m, houses_m]: [f32; 3],
    rng: &mut ChaCha8Rng,
) {
    let whole = plan.roadside(side);
    let before =
        |from_middle_m: f32| Roadside { reach_m: [whole.reach_m[0], middle_m - from_middle_m], ..whole };
    let after =
        |from_middle_m: f32| Roadside { reach_m: [middle_m + from_middle_m, whole.reach_m[1]], ..whole };
    let parked = ParkedRowParams {
        parking: plan.parking(side),
        occupied_share: rng.random_range(0.35..0.85),
        person_beside: 0.1,
    };
    let furniture = PavementFurnitureParams {
        spacing_m: rng.random_range(3.5..7.5),
        from_kerb_m: 0.6,
        tree_share: rng.random_range(0.1..0.4),
        avenue: conditions.avenue,
    };
    let houses = conditions.houses(HouseRowParams {
        gap: rng.random_range(0.2..0.7),
        gap_m: [4.0, 16.0],
        set_back: rng.random_range(0.1..0.6),
        garden_m: HouseRowParams::TOWN_GARDENS_M,
    });
    let corner_m = kerb_m + CORNER_CLEARANCE_M;
    for (clear, built) in [(before(corner_m), before(houses_m)), (after(corner_m), after(houses_m))] {
        parked_row(world, &clear, &parked, rng);
        pavement_furniture(world, &clear, &furniture, rng);
        house_row(world, &built, &houses, rng);
    }
    // People walk on across the other road.
    let people = PavementPeopleParams { spacing_m: rng.random_range(8.0..20.0), from_kerb_m: 1.2 };
    pavement_people(world, &whole, &people, rng);
}

/// Traffic lights and signs at the four corners.
fn corner_posts(world: &mut World, plans: &Plans, rng: &mut ChaCha8Rng) {
    for side in [Side::Left, Side::Right] {
        let roadside = plans.main.roadside(side);
        let crossing_kerb_m = plans.crossing.roadside(Side::Left).kerb_m;
        for direction in [-1.0, 1.0] {
            let along_m = plans.crossed_at_m + direction * (crossing_kerb_m + rng.random_range(3.5..5.0));
            let placement = roadside.facing_road(along_m, roadside.kerb_m + 0.5);
            let post = if rng.random_bool(0.6) {
                furniture_shape::traffic_light(rng)
            } else {
                furniture_shape::sign(rng)
            };
            world.stand(post, &placement);
        }
    }
}

/// Cars that go along the main road in `direction` turn right round the corner, at an even distance from the kerb, into the
/// lane of the crossing road that leads away.
fn turning_off(world: &World, plans: &Plans, direction: f32) -> TurningOff {
    let [to_main_kerb_m, to_crossing_kerb_m] =
        [&plans.main, &plans.crossing].map(|plan| plan.roadside(Side::Right).kerb_m - plan.lanes_m / 2.0);
    let radius_m = world.ground.corner_radius_m + to_main_kerb_m.min(to_crossing_kerb_m);
    let ends_m = plans.crossed_at_m - direction * plans.crossing.lanes_m / 2.0;
    let right_turn = RightTurn { from_m: ends_m - direction * radius_m, radius_m };
    TurningOff { share: 0.3, right_turn }
}

fn traffic(world: &mut World, plans: &Plans, rng: &mut ChaCha8Rng) {
    let with_ego = Lane {
        road_idx: MAIN,
        left_m: world.ego.start.left_m,
        speed_m_per_s: world.ego.speed_m_per_s,
        reach_m: plans.main.reach_m,
        spacing_m: rng.random_range(18.0..45.0),
        turning_off: Some(turning_off(world, plans, 1.0)),
    };
    lane_traffic(world, &with_ego, [-6.0, 9.0], DRIVE_DURATION_S, rng);
    let oncoming = Lane {
        left_m: -with_ego.left_m,
        speed_m_per_s: -rng.random_range(5.0_f32..10.0),
        turning_off: Some(turning_off(world, plans, -1.0)),
        ..with_ego
    };
    lane_traffic(world, &oncoming, [0.0, 0.0], DRIVE_DURATION_S, rng);
    for side in [Side::Left, Side::Right] {
        let queue = WaitingQueueParams {
            stop_line_m: plans.main.roadside(Side::Left).kerb_m + rng.random_range(3.0_f32..5.0),
            from_axis_m: plans.crossing.lanes_m / 2.0,
            n_vehicles: rng.random_range(0..7),
        };
        waiting_queue(world, &plans.crossing.roadside(side), &queue, rng);
    }
}
