//! Vehicles and bicycles that drive along a road or wait at a stop line, and the truck that may drive ahead of the sensor.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::person_shape;
use super::road_axis::RoadPosition;
use super::roadside::Roadside;
use super::world::{Body, Course, Motion, RightTurn, Stance, StreetObject, World};

/// One lane and how it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lane {
    /// Which road.
    pub road_idx: usize,
    /// Middle of the lane to the left of the road's axis, in metres.
    pub left_m: f32,
    /// Speed of all vehicles in it along the road, negative against it, in metres per second. One speed, so that
    /// vehicles do not collide.
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
        let shape = world.fleet.driven(rng);
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
    let start = RoadPosition { along_m: start_m, left_m: lane.left_m };
    Course::along(lane.road_idx, start, lane.speed_m_per_s, lane.reach_m)
}

/// A queue at the crossing at 0 m along a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaitingQueueParams {
    /// Distance of the stop line from the crossing, in metres along the road.
    pub stop_line_m: f32,
    /// Middle of the lane, in metres from the axis.
    pub from_axis_m: f32,
    /// How many wait.
    pub n_vehicles: u32,
}

/// Lets vehicles wait in the lane of `roadside` that leads to the crossing.
pub fn waiting_queue(
    world: &mut World,
    roadside: &Roadside,
    params: &WaitingQueueParams,
    rng: &mut ChaCha8Rng,
) {
    // On the right, traffic goes along the road: waiting vehicles stand at negative distances, head first.
    let backward = roadside.side.sign();
    let mut front_m = params.stop_line_m;
    for _ in 0..params.n_vehicles {
        let shape = world.fleet.driven(rng);
        let length_m = shape.length_m();
        let along_m = backward * (front_m + length_m / 2.0);
        front_m += length_m + rng.random_range(0.8..2.5);
        world.stand(shape, &roadside.along_traffic(along_m, params.from_axis_m, Stance::OnSlope));
    }
}

/// From the sensor to the truck's rear, in metres.
const REAR_AHEAD_M: f32 = 9.0;
/// Free length before and behind the truck, in metres.
const CLEARANCE_M: f32 = 2.5;
/// Vehicles nearer than this to the middle of the lane drive in it, in metres.
const HALF_LANE_M: f32 = 1.7;

/// Puts a truck of `height_m` ahead of the sensor, at its speed. Vehicles that drive at that position are removed.
pub fn leading_truck(world: &mut World, height_m: f32, rng: &mut ChaCha8Rng) {
    let shape = world.fleet.truck_of_height(height_m, rng);
    let length_m = shape.length_m();
    let rear_m = world.ego.start.along_m + REAR_AHEAD_M;
    let middle_m = rear_m + length_m / 2.0;
    let ego = world.ego;
    let is_at_position = |object: &StreetObject| match (&object.motion, &object.body) {
        (Motion::Following(course), Body::Rigid(other)) => {
            course.road_idx == ego.road_idx
                && course.speed_m_per_s == ego.speed_m_per_s
                && (course.start.left_m - ego.start.left_m).abs() < HALF_LANE_M
                && (course.start.along_m - middle_m).abs()
                    < f32::midpoint(length_m, other.length_m()) + CLEARANCE_M
        }
        _ => false,
    };
    world.objects.retain(|object| !is_at_position(object));
    let start = RoadPosition { along_m: middle_m, left_m: ego.start.left_m };
    world.follow(Body::Rigid(shape), Course { start, ..ego });
}
