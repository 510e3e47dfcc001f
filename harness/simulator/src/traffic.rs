//! Vehicles and bicycles that drive along a road.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::person_shape;
use super::road_axis::RoadPosition;
use super::world::{Body, Course, RightTurn, Stance, World};

/// One lane and how it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lane {
    /// Which road.
    pub road_idx: usize,
    /// Middle of the lane to the left of the road's axis, in metres.
    pub left_m: f32,
    /// Speed of all vehicles in it along the road, negative against it, in metres per second. One speed, so that
    /// nobody runs into anybody.
    pub speed_m_per_s: f32,
    /// Where vehicles appear and disappear, in metres along the road.
    pub reach_m: [f32; 2],
    /// Mean distance between vehicles in metres.
    pub spacing_m: f32,
    /// Where some of the cars and vans turn off, if any do.
    pub turning_off: Option<TurningOff>,
}

/// Where vehicles turn off a lane, and how many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurningOff {
    /// Share of the cars and vans that do, 0 to 1.
    pub share: f64,
    /// Where they go.
    pub right_turn: RightTurn,
}

/// Longer vehicles do not turn, in metres: they would need more room.
const LONGEST_TURNING_M: f32 = 6.5;

/// Fills `lane` with vehicles for `duration_s`, leaving `kept_free_m` along the road at the start empty.
pub fn lane_traffic(
    world: &mut World,
    lane: &Lane,
    kept_free_m: [f32; 2],
    duration_s: f32,
    rng: &mut ChaCha8Rng,
) {
    let mut free_from_m = f32::NEG_INFINITY;
    for_each_start(lane, duration_s, rng, |start_m, rng| {
        let shape = world.vehicle_mix.driven(rng);
        let half_m = shape.length_m() / 2.0;
        let rear_m = (start_m - half_m).max(free_from_m);
        free_from_m = rear_m + 2.0 * half_m + 2.5;
        let middle_m = rear_m + half_m;
        if middle_m + half_m > kept_free_m[0] && middle_m - half_m < kept_free_m[1] {
            return;
        }
        let turning_off = lane.turning_off.filter(|it| {
            let is_before = (it.right_turn.from_m - middle_m) * lane.speed_m_per_s > 0.0;
            2.0 * half_m < LONGEST_TURNING_M && is_before && rng.random_bool(it.share)
        });
        let right_turn = turning_off.map(|it| it.right_turn);
        world.follow(Body::Rigid(shape), Course { right_turn, ..course(lane, middle_m) });
    });
}

/// Fills `lane` with people on bicycles for `duration_s`.
pub fn bicycle_traffic(world: &mut World, lane: &Lane, duration_s: f32, rng: &mut ChaCha8Rng) {
    for_each_start(lane, duration_s, rng, |start_m, rng| {
        let build = person_shape::any_build(rng);
        world.follow(Body::Rider(build), course(lane, start_m));
    });
}

/// Draws where vehicles start, also those that reach the street only later.
fn for_each_start(
    lane: &Lane,
    duration_s: f32,
    rng: &mut ChaCha8Rng,
    mut put: impl FnMut(f32, &mut ChaCha8Rng),
) {
    let travel_m = lane.speed_m_per_s * duration_s;
    let [first_m, last_m] = lane.reach_m;
    let mut along_m = first_m - travel_m.max(0.0);
    loop {
        along_m += lane.spacing_m * rng.random_range(0.3..1.7);
        if along_m > last_m - travel_m.min(0.0) {
            return;
        }
        put(along_m, rng);
    }
}

fn course(lane: &Lane, start_m: f32) -> Course {
    Course {
        road_idx: lane.road_idx,
        start: RoadPosition { along_m: start_m, left_m: lane.left_m },
        speed_m_per_s: lane.speed_m_per_s,
        reach_m: lane.reach_m,
        right_turn: None,
        stance: Stance::OnSlope,
    }
}
