//! A truck that drives ahead of the sensor for the whole drive.

use rand_chacha::ChaCha8Rng;

use super::road_axis::RoadPosition;
use super::vehicle_shape::truck_of_height;
use super::world::{Body, Course, Motion, StreetObject, World};

/// From the sensor to the truck's rear, in metres.
const REAR_AHEAD_M: f32 = 9.0;
/// What the truck's place takes before and behind it, in metres.
const CLEARANCE_M: f32 = 2.5;
/// What is nearer than this to the middle of the lane drives in it, in metres.
const HALF_LANE_M: f32 = 1.7;

/// Puts a truck of `height_m` ahead of the sensor, at its speed. What drives at that place makes room.
pub fn leading_truck(world: &mut World, height_m: f32, rng: &mut ChaCha8Rng) {
    let shape = truck_of_height(height_m, rng);
    let length_m = shape.length_m();
    let rear_m = world.ego.start.along_m + REAR_AHEAD_M;
    let middle_m = rear_m + length_m / 2.0;
    let ego = world.ego;
    let is_in_place = |object: &StreetObject| match (&object.motion, &object.body) {
        (Motion::Following(course), Body::Rigid(other)) => {
            course.road_idx == ego.road_idx
                && course.speed_m_per_s == ego.speed_m_per_s
                && (course.start.left_m - ego.start.left_m).abs() < HALF_LANE_M
                && (course.start.along_m - middle_m).abs()
                    < f32::midpoint(length_m, other.length_m()) + CLEARANCE_M
        }
        _ => false,
    };
    world.objects.retain(|object| !is_in_place(object));
    let start = RoadPosition { along_m: middle_m, left_m: ego.start.left_m };
    world.follow(Body::Rigid(shape), Course { start, ..ego });
}
