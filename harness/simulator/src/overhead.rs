//! Things over a road: bridges from house to house, wires and lamps; and garages along it.

use std::ops::Range;

use parry3d::math::{Pose, Vector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::material::Material;
use super::road_axis::RoadPosition;
use super::solid::Solid;
use super::world::{Placement, Stance, World, world_from_placement};

/// From one bridge to the next, in metres.
const BRIDGE_SPACINGS_M: Range<f32> = 35.0..70.0;
/// From one wire across the road to the next, in metres.
const SPAN_SPACINGS_M: Range<f32> = 18.0..30.0;
/// From one row of garages to the next, in metres.
const GARAGE_SPACINGS_M: Range<f32> = 15.0..40.0;
/// Radius of wires as a beam sees them, which is wider than they are, in metres.
const WIRE_RADIUS_M: f32 = 0.012;
/// Width of a garage door, in metres.
const DOOR_WIDTH_M: f32 = 2.5;

/// A cross-section of the road that is driven along.
struct CrossSection {
    /// World from a frame on the ground whose x points along the road, and z up.
    frame: Pose,
    /// Distance of the building line to the left and to the right, in metres.
    building_lines_m: [f32; 2],
}

/// Builds bridges over the road on piers along the building lines, so low that trucks just pass.
pub fn bridges(world: &mut World, rng: &mut ChaCha8Rng) {
    for section in cross_sections(world, BRIDGE_SPACINGS_M, rng) {
        let [left_m, right_m] = section.building_lines_m;
        let half_m = rng.random_range(1.5_f32..6.0);
        let clearance_m = rng.random_range(4.2_f32..5.2);
        let block =
            |y_m: [f32; 2], z_m: [f32; 2]| Solid::cuboid([-half_m, y_m[0], z_m[0]], [half_m, y_m[1], z_m[1]]);
        let deck = block([-right_m, left_m], [clearance_m, clearance_m + 1.1]);
        let piers =
            [[-right_m, 0.8 - right_m], [left_m - 0.8, left_m]].map(|it| block(it, [-1.0, clearance_m]));
        world.build(&section.frame, [deck].into_iter().chain(piers), Material::MASONRY);
    }
}

/// Hangs wires over the road: across it with a lamp on each, and along it from one to the next.
pub fn wires(world: &mut World, rng: &mut ChaCha8Rng) {
    let mut last_ends: Option<[Vector; 2]> = None;
    for section in cross_sections(world, SPAN_SPACINGS_M, rng) {
        let [left_m, right_m] = section.building_lines_m;
        let height_m = rng.random_range(4.8_f32..6.0);
        let across = wire([0.0, -right_m, height_m + 0.4], [0.0, left_m, height_m + 0.4]);
        let lamp = Solid::cuboid([-0.35, -0.15, height_m + 0.1], [0.35, 0.15, height_m + 0.4]);
        world.build(&section.frame, [across, lamp].into_iter(), Material::METAL);
        let ends = [-0.5, 0.5].map(|left_m| section.frame * Vector::new(0.0, left_m, height_m));
        if let Some(last) = last_ends.replace(ends) {
            let along = last.into_iter().zip(ends).map(|(from, to)| wire(from.into(), to.into()));
            world.build(&Pose::IDENTITY, along, Material::METAL);
        }
    }
}

/// Builds rows of garages at the building lines. Their doors stand back a little, stand out over the pavement where they are
/// half open, or are open and let one look in.
pub fn garages(world: &mut World, rng: &mut ChaCha8Rng) {
    for section in cross_sections(world, GARAGE_SPACINGS_M, rng) {
        let is_left = rng.random_bool(0.5);
        let n_doors = rng.random_range(1..4_u32);
        let height_m = rng.random_range(2.3_f32..2.8);
        let mut solids = Vec::new();
        for door in 0..n_doors {
            let x_m = door as f32 * (DOOR_WIDTH_M + 0.3);
            let from_line = if is_left { section.building_lines_m[0] } else { -section.building_lines_m[1] };
            let outward = if is_left { -1.0 } else { 1.0 };
            // From x to x, so far out over the pavement, and from z to z.
            let mut block = |x_m: [f32; 2], out_m: [f32; 2], z_m: [f32; 2]| {
                let y_m = out_m.map(|it| from_line + outward * it);
                solids.push(Solid::cuboid(
                    [x_m[0], y_m[0].min(y_m[1]), z_m[0]],
                    [x_m[1], y_m[0].max(y_m[1]), z_m[1]],
                ));
            };
            let inner_m = [x_m + 0.15, x_m + 0.15 + DOOR_WIDTH_M];
            let outer_m = [x_m, x_m + DOOR_WIDTH_M + 0.3];
            block(outer_m, [-5.5, 0.6], [height_m, height_m + 0.2]);
            block([outer_m[0], inner_m[0]], [-5.5, 0.6], [-0.5, height_m]);
            block([inner_m[1], outer_m[1]], [-5.5, 0.6], [-0.5, height_m]);
            match rng.random_range(0..10_u32) {
                // Half open: it stands out at the height of a head.
                0..3 => block(inner_m, [0.2, 1.2], [height_m - 0.25, height_m - 0.2]),
                // Open: the back wall shows, and the things that are kept there.
                3..5 => block(inner_m, [0.0, 0.1], [-0.5, rng.random_range(0.4..1.4)]),
                _ => block(inner_m, [0.35, 0.4], [-0.5, height_m]),
            }
        }
        world.build(&section.frame, solids.into_iter(), Material::METAL);
    }
}

/// Cross-sections of the road that is driven along, where no other road is.
fn cross_sections(world: &World, spacings_m: Range<f32>, rng: &mut ChaCha8Rng) -> Vec<CrossSection> {
    let road_idx = world.ego.road_idx;
    let [mut along_m, end_m] = world.ego.reach_m;
    let mut cross_sections = Vec::new();
    loop {
        along_m += rng.random_range(spacings_m.clone());
        if along_m > end_m {
            return cross_sections;
        }
        let position = RoadPosition { along_m, left_m: 0.0 };
        let placement = Placement { road_idx, position, turned_rad: 0.0, stance: Stance::Upright };
        let frame = world_from_placement(&world.ground, &placement);
        let plan = [frame.translation.x, frame.translation.y];
        let is_clear = world.ground.roads.iter().enumerate().all(|(other_idx, other)| {
            other_idx == road_idx || other.axis.road_position(plan).left_m.abs() > CLEAR_OF_ROADS_M
        });
        let section = &world.ground.roads[road_idx].section;
        let building_lines_m =
            [section.left_kerb_m, section.right_kerb_m].map(|it| it + world.ground.pavement_width_m);
        if is_clear {
            cross_sections.push(CrossSection { frame, building_lines_m });
        }
    }
}

/// Nothing is built this near to the axis of another road, in metres.
const CLEAR_OF_ROADS_M: f32 = 20.0;

fn wire(from_m: [f32; 3], to_m: [f32; 3]) -> Solid {
    Solid::cylinder(from_m, to_m, WIRE_RADIUS_M)
}

#[cfg(test)]
mod tests {
    use crate::sensor::SensorModel;
    use crate::street::{Street, StreetKind};
    use crate::street_conditions::StreetConditions;

    /// Points over the lanes at least 4 m above the sensor's road, over all streets; and on the pavements, between knees and
    /// 3 m.
    fn n_over_and_beside(conditions: &StreetConditions) -> [usize; 2] {
        let sensor = SensorModel { carrier_roof: None, ..SensorModel::embedded("os1-128").unwrap() };
        let scans =
            (0..4).map(|seed| Street::under(StreetKind::MainRoad, seed, conditions).scan(&sensor, 30));
        scans.fold([0; 2], |[over, beside], scan| {
            let near = scan.cloud.positions_m().filter(|[x, y, _]| x.abs() < 30.0 && y.abs() < 15.0);
            let above = near.map(|[_, y, z]| (y.abs(), z + sensor.height_above_road_m));
            let (high, low): (Vec<_>, Vec<_>) = above.partition(|it| it.1 > 4.0);
            let n_over = high.iter().filter(|it| it.0 < 2.5).count();
            let n_beside = low.iter().filter(|it| it.0 > 4.0 && it.1 > 0.5 && it.1 < 3.0).count();
            [over + n_over, beside + n_beside]
        })
    }

    #[test]
    fn bridges_and_wires_hang_over_the_lanes_and_garages_stand_beside_them() {
        let bare = StreetConditions::default();
        let [over, beside] = n_over_and_beside(&bare);
        let [bridges, _] = n_over_and_beside(&StreetConditions { bridges: true, ..bare });
        assert!(bridges > over + 1000, "{bridges} instead of {over}");
        let [wires, _] = n_over_and_beside(&StreetConditions { wires: true, ..bare });
        assert!(wires > over + 20 && wires < over + 2000, "{wires} instead of {over}");
        let [over_garages, garages] = n_over_and_beside(&StreetConditions { garages: true, ..bare });
        assert!(over_garages.abs_diff(over) < 50, "{over_garages} instead of {over}");
        assert!(garages.abs_diff(beside) > 200, "{garages} beside {beside}");
    }
}
