//! Vehicles that wait one behind the other at a stop line.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::roadside::{Roadside, Side};
use super::world::{Stance, World};

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
    // On the right, traffic goes along the road: what waits stands at negative distances, head first.
    let backward = match roadside.side {
        Side::Left => 1.0,
        Side::Right => -1.0,
    };
    let mut front_m = params.stop_line_m;
    for _ in 0..params.n_vehicles {
        let shape = world.vehicle_mix.driven(rng);
        let length_m = shape.length_m();
        let along_m = backward * (front_m + length_m / 2.0);
        front_m += length_m + rng.random_range(0.8..2.5);
        world.stand(shape, &roadside.along_traffic(along_m, params.from_axis_m, Stance::OnSlope));
    }
}
