//! A main road: traffic both ways, parked rows, pavements with trees and lamps, houses on both sides.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::ground::{CrossSection, Ground, Road};
use super::house_row::{HouseRowParams, house_row};
use super::parked_row::{ParkedRowParams, parked_row};
use super::pavement::{PavementParams, pavement};
use super::road_axis::{RoadAxis, RoadAxisShape, RoadPosition, Wave};
use super::roadside::{Roadside, Side};
use super::traffic::{Lane, bicycle_traffic, lane_traffic};
use super::world::{Course, Stance, World};

/// How far the street goes on before and after the drive, in metres: what the sensor can see.
const MARGIN_M: f32 = 130.0;
const DRIVE_DURATION_S: f32 = 40.0;

/// The widths of one main road.
struct Layout {
    n_lanes_each_way: u32,
    lane_width_m: f32,
    /// Width of the parking lane on the left and on the right; 0 where none is.
    parking_width_m: [f32; 2],
    pavement_width_m: f32,
    reach_m: [f32; 2],
}

impl Layout {
    fn draw(rng: &mut ChaCha8Rng, drive_length_m: f32) -> Self {
        let parking_width_m =
            [0, 1].map(|_| if rng.random_bool(0.7) { rng.random_range(2.2..2.6) } else { 0.0 });
        Self {
            n_lanes_each_way: if rng.random_bool(0.3) { 2 } else { 1 },
            lane_width_m: rng.random_range(3.3..3.9),
            parking_width_m,
            pavement_width_m: rng.random_range(2.8..5.5),
            reach_m: [-MARGIN_M, drive_length_m + MARGIN_M],
        }
    }

    /// Distance of the outer edge of the lanes from the axis.
    fn lanes_m(&self) -> f32 {
        self.n_lanes_each_way as f32 * self.lane_width_m
    }

    fn parking_width_m(&self, side: Side) -> f32 {
        match side {
            Side::Left => self.parking_width_m[0],
            Side::Right => self.parking_width_m[1],
        }
    }

    fn roadside(&self, side: Side) -> Roadside {
        let kerb_m = self.lanes_m() + self.parking_width_m(side);
        let building_line_m = kerb_m + self.pavement_width_m;
        Roadside { road_idx: 0, side, reach_m: self.reach_m, kerb_m, building_line_m }
    }
}

/// Draws a main road.
pub fn main_road(rng: &mut ChaCha8Rng) -> World {
    let ego_speed_m_per_s = rng.random_range(7.0_f32..13.0);
    let layout = Layout::draw(rng, ego_speed_m_per_s * DRIVE_DURATION_S);
    let outer_lane_m = (layout.n_lanes_each_way as f32 - 0.5) * layout.lane_width_m;
    let ego = Course {
        road_idx: 0,
        start: RoadPosition { along_m: 0.0, left_m: -outer_lane_m },
        speed_m_per_s: ego_speed_m_per_s,
        reach_m: layout.reach_m,
        stance: Stance::OnSlope,
    };
    let mut world = World {
        ground: ground(&layout, rng),
        walls: Vec::new(),
        objects: Vec::new(),
        ego,
        drive_duration_s: DRIVE_DURATION_S,
    };
    for side in [Side::Left, Side::Right] {
        let roadside = layout.roadside(side);
        if layout.parking_width_m(side) > 0.0 {
            let parked =
                ParkedRowParams { occupied_share: rng.random_range(0.35..0.85), person_beside: 0.12 };
            parked_row(&mut world, &roadside, &parked, rng);
        }
        let furnished = PavementParams {
            furniture_spacing_m: rng.random_range(4.0..9.0),
            tree_share: rng.random_range(0.1..0.5),
            people_spacing_m: rng.random_range(8.0..25.0),
        };
        pavement(&mut world, &roadside, &furnished, rng);
        let built = HouseRowParams { gap: rng.random_range(0.2..0.6), set_back: rng.random_range(0.0..0.6) };
        house_row(&mut world, &roadside, &built, rng);
    }
    traffic(&mut world, &layout, rng);
    world
}

fn ground(layout: &Layout, rng: &mut ChaCha8Rng) -> Ground {
    let axis = RoadAxis::new(&RoadAxisShape {
        origin_m: [0.0, 0.0],
        heading_rad: 0.0,
        reach_m: layout.reach_m,
        bends: wave(rng, 0.0..7.0, 350.0..700.0),
        gradient: rng.random_range(-0.05..0.05),
        hills: wave(rng, 0.0..1.2, 180.0..400.0),
    });
    let section = CrossSection {
        left_kerb_m: layout.roadside(Side::Left).kerb_m,
        right_kerb_m: layout.roadside(Side::Right).kerb_m,
        crown: rng.random_range(0.01..0.03),
        kerb_height_m: rng.random_range(0.08..0.15),
    };
    Ground { roads: vec![Road { axis, section }], pavement_width_m: layout.pavement_width_m }
}

fn wave(rng: &mut ChaCha8Rng, amplitude_m: std::ops::Range<f32>, length_m: std::ops::Range<f32>) -> Wave {
    Wave {
        amplitude_m: rng.random_range(amplitude_m),
        length_m: rng.random_range(length_m),
        phase: rng.random_range(0.0..1.0),
    }
}

fn traffic(world: &mut World, layout: &Layout, rng: &mut ChaCha8Rng) {
    let ego = world.ego;
    let spacing_m = rng.random_range(18.0_f32..50.0);
    for lane_idx in 0..layout.n_lanes_each_way {
        let from_axis_m = (lane_idx as f32 + 0.5) * layout.lane_width_m;
        let is_ego_lane = lane_idx + 1 == layout.n_lanes_each_way;
        let with_ego = Lane {
            road_idx: 0,
            left_m: -from_axis_m,
            speed_m_per_s: if is_ego_lane { ego.speed_m_per_s } else { ego.speed_m_per_s + 2.0 },
            reach_m: layout.reach_m,
            spacing_m,
        };
        let kept_free_m = if is_ego_lane { [-6.0, 8.0] } else { [0.0, 0.0] };
        lane_traffic(world, &with_ego, kept_free_m, DRIVE_DURATION_S, rng);
        let oncoming =
            Lane { left_m: from_axis_m, speed_m_per_s: -rng.random_range(8.0_f32..14.0), ..with_ego };
        lane_traffic(world, &oncoming, [0.0, 0.0], DRIVE_DURATION_S, rng);
    }
    for side in [Side::Left, Side::Right] {
        let from_axis_m = layout.lanes_m() - 0.45;
        let bicycles = Lane {
            road_idx: 0,
            left_m: side.sign() * from_axis_m,
            speed_m_per_s: -side.sign() * rng.random_range(3.5_f32..6.0),
            reach_m: layout.reach_m,
            spacing_m: 60.0,
        };
        bicycle_traffic(world, &bicycles, DRIVE_DURATION_S, rng);
    }
}
