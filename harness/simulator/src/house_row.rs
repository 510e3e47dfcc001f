//! Houses along a road, with gaps, set-backs and front gardens.

use parry3d::math::{Pose, Vector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::facade::{FacadePattern, PlacedFacade};
use super::material::Material;
use super::roadside::{Roadside, Side};
use super::scene::{Leaf, LeafForm};
use super::solid::Solid;
use super::world::{World, rotation_from_axes};
use super::{furniture_shape, vegetation_shape};

/// How closely a roadside is built up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HouseRowParams {
    /// Chance that a gap follows a house.
    pub gap: f64,
    /// Least and greatest width of a gap, in metres.
    pub gap_m: [f32; 2],
    /// Chance that a house stands back behind a front garden.
    pub set_back: f64,
    /// Least and greatest depth of a front garden, in metres.
    pub garden_m: [f32; 2],
}

impl HouseRowParams {
    /// Depths of the front gardens of a town, in metres.
    pub const TOWN_GARDENS_M: [f32; 2] = [2.0, 6.0];
}

/// How far gardens reach back from the building line, in metres.
const GARDEN_DEPTH_M: f32 = 24.0;

/// Builds houses along `roadside`, and plants and fences the gaps and gardens.
pub fn house_row(world: &mut World, roadside: &Roadside, params: &HouseRowParams, rng: &mut ChaCha8Rng) {
    let [mut along_m, end_m] = roadside.reach_m;
    while along_m < end_m {
        let length_m = rng.random_range(8.0_f32..22.0).min(end_m - along_m);
        if length_m < 3.0 {
            break;
        }
        let set_back_m = if rng.random_bool(params.set_back) {
            rng.random_range(params.garden_m[0]..params.garden_m[1])
        } else {
            0.0
        };
        house(world, roadside, [along_m, along_m + length_m], set_back_m, rng);
        if set_back_m > 0.0 {
            garden_border(world, roadside, [along_m, along_m + length_m], rng);
            garden_plants(world, roadside, [along_m, along_m + length_m], set_back_m - 0.5, rng);
        }
        along_m += length_m;
        if rng.random_bool(params.gap) {
            let gap_m = rng.random_range(params.gap_m[0]..params.gap_m[1]).min(end_m - along_m);
            garden_border(world, roadside, [along_m, along_m + gap_m], rng);
            garden_plants(world, roadside, [along_m, along_m + gap_m], GARDEN_DEPTH_M, rng);
            along_m += gap_m;
        }
    }
    let beyond = Roadside { building_line_m: roadside.building_line_m + GARDEN_DEPTH_M + 4.0, ..*roadside };
    back_row(world, &beyond, rng);
}

/// The houses of the next street, which show through the gaps.
fn back_row(world: &mut World, roadside: &Roadside, rng: &mut ChaCha8Rng) {
    let [mut along_m, end_m] = roadside.reach_m;
    while along_m < end_m {
        let length_m = rng.random_range(12.0_f32..30.0).min((end_m - along_m).max(3.0));
        house(world, roadside, [along_m, along_m + length_m], rng.random_range(0.0_f32..12.0), rng);
        along_m += length_m + rng.random_range(0.0_f32..8.0);
    }
}

/// A frame at the building line: x to the right as seen from the street, y into the house, z up.
fn house_frame(world: &World, roadside: &Roadside, [from_m, to_m]: [f32; 2], set_back_m: f32) -> (Pose, f32) {
    let axis = &world.ground.roads[roadside.road_idx].axis;
    let corner = |along_m: f32| {
        let position = roadside.position(along_m, roadside.building_line_m + set_back_m);
        let (plan, _) = axis.world_plan(position);
        Vector::new(plan[0], plan[1], world.ground.height_m(plan))
    };
    let (left, right) = match roadside.side {
        Side::Left => (corner(from_m), corner(to_m)),
        Side::Right => (corner(to_m), corner(from_m)),
    };
    let level = Vector::new(right.x - left.x, right.y - left.y, 0.0);
    let along = level.normalize();
    let inward = Vector::Z.cross(along);
    let foot = Vector::new(left.x, left.y, left.z.min(right.z) - 0.3);
    (Pose::from_parts(foot, rotation_from_axes(along, inward, Vector::Z)), level.length())
}

fn house(world: &mut World, roadside: &Roadside, reach_m: [f32; 2], set_back_m: f32, rng: &mut ChaCha8Rng) {
    let (frame, length_m) = house_frame(world, roadside, reach_m, set_back_m);
    let height_m = rng.random_range(6.0_f32..18.0);
    let pattern = FacadePattern {
        bay_m: rng.random_range(2.2..4.0),
        storey_m: rng.random_range(2.8..3.8),
        window_width_m: rng.random_range(0.9..1.8),
        window_height_m: rng.random_range(1.2..1.8),
        sill_m: rng.random_range(0.6..1.2),
        recess_m: rng.random_range(0.08..0.3),
        door_every_n_bays: rng.random_range(3..6),
    };
    let masonry = Material::solid(rng.random_range(0.2..0.5));
    let left = frame.translation;
    let right = frame * Vector::new(length_m, 0.0, 0.0);
    let facade = LeafForm::Facade(PlacedFacade::new(left, right, height_m, pattern));
    world.walls.push(Leaf { form: facade, material: masonry, object_idx: None });

    let depth_m = 11.0;
    let mut wall = |solid: Solid, material: Material| {
        let form = LeafForm::Solid(solid.placed(&frame));
        world.walls.push(Leaf { form, material, object_idx: None });
    };
    // Down into the ground, which may fall toward the back.
    wall(Solid::cuboid([0.0, 0.001, -3.0], [0.2, depth_m, height_m]), masonry);
    wall(Solid::cuboid([length_m - 0.2, 0.001, -3.0], [length_m, depth_m, height_m]), masonry);
    // Curtains, blinds and the rooms behind the panes.
    wall(Solid::cuboid([0.2, 0.6, 0.0], [length_m - 0.2, depth_m, height_m]), Material::solid(0.25));
    for solid in relief(length_m, &pattern, rng) {
        wall(solid, masonry);
    }
    for (solid, leaves) in climbing_plants(length_m, rng) {
        wall(solid, leaves);
    }
    // Only where people do not walk.
    if set_back_m > 2.0 && rng.random_bool(0.08) {
        for solid in scaffold(length_m) {
            wall(solid, Material::METAL);
        }
    }
}

/// A scaffold before a façade: standards and ledgers every few metres, boards at every lift.
fn scaffold(length_m: f32) -> Vec<Solid> {
    let n_gaps = (length_m / 2.5).ceil() as u32;
    let x = |standard: u32| length_m * standard as f32 / n_gaps as f32;
    let mut solids = Vec::new();
    for y in [-0.3, -1.2] {
        solids.extend((0..=n_gaps).map(|it| Solid::cylinder([x(it), y, 0.0], [x(it), y, 8.0], 0.025)));
    }
    for lift in 1..4_u32 {
        let z = 2.0 * lift as f32;
        solids.push(Solid::cuboid([0.0, -1.15, z], [length_m, -0.35, z + 0.05]));
        solids.push(Solid::cylinder([0.0, -1.2, z + 1.0], [length_m, -1.2, z + 1.0], 0.025));
    }
    solids
}

/// Parts that stand out from a façade: plinth, downpipe, steps, bay windows, balconies.
fn relief(length_m: f32, pattern: &FacadePattern, rng: &mut ChaCha8Rng) -> Vec<Solid> {
    let mut solids = vec![Solid::cylinder([0.15, -0.12, 0.0], [0.15, -0.12, 6.0], 0.06)];
    if rng.random_bool(0.5) {
        solids.push(Solid::cuboid([0.0, -0.06, 0.0], [length_m, 0.0, 0.3 + rng.random_range(0.2_f32..0.6)]));
    }
    let n_bays = (length_m / pattern.bay_m).floor().max(1.0);
    let bay_m = length_m / n_bays;
    for bay in 0..n_bays as u32 {
        let middle_m = (bay as f32 + 0.5) * bay_m;
        match rng.random_range(0..100_u32) {
            0..12 => solids.push(Solid::cuboid(
                [middle_m - 0.7, -0.9, 0.0],
                [middle_m + 0.7, 0.0, 0.3 + rng.random_range(0.12_f32..0.5)],
            )),
            12..20 => solids.push(Solid::cuboid(
                [middle_m - bay_m * 0.4, -0.7, pattern.storey_m],
                [middle_m + bay_m * 0.4, 0.0, pattern.storey_m * 3.0],
            )),
            20..30 => solids.push(Solid::cuboid(
                [middle_m - bay_m * 0.45, -1.0, pattern.storey_m],
                [middle_m + bay_m * 0.45, 0.0, pattern.storey_m + 0.2],
            )),
            30..42 => solids.push(Solid::cuboid(
                [middle_m - bay_m * 0.5, -0.18, 0.0],
                [middle_m - bay_m * 0.5 + 0.4, 0.0, 6.0],
            )),
            _ => {}
        }
    }
    solids
}

/// Ivy, espaliers and shrubs against a façade, some metres apart.
fn climbing_plants(length_m: f32, rng: &mut ChaCha8Rng) -> Vec<(Solid, Material)> {
    let mut plants = Vec::new();
    let mut at_m = rng.random_range(0.5_f32..9.0);
    while at_m < length_m - 0.5 {
        let half_width_m = rng.random_range(0.2_f32..0.9);
        let half_height_m = rng.random_range(0.3_f32..1.6);
        let leaves = Material::foliage(rng.random_range(0.05..0.2));
        let upright =
            Solid::spheroid([at_m, 0.0, 0.3 + half_height_m], half_width_m.min(0.45), half_height_m);
        plants.push((upright, leaves));
        at_m += rng.random_range(2.0_f32..12.0);
    }
    plants
}

/// A hedge, a fence or nothing along the building line.
fn garden_border(world: &mut World, roadside: &Roadside, [from_m, to_m]: [f32; 2], rng: &mut ChaCha8Rng) {
    let length_m = to_m - from_m - rng.random_range(0.6_f32..1.6);
    if length_m < 1.0 {
        return;
    }
    let shape = match rng.random_range(0..10_u32) {
        0..4 => vegetation_shape::hedge(length_m, rng),
        4..8 => furniture_shape::fence(length_m, rng),
        _ => return,
    };
    let placement = roadside.facing_road(f32::midpoint(from_m, to_m), roadside.building_line_m + 0.55);
    world.stand(shape, &placement);
}

/// Trees, bushes and shrubs in rows one behind the other.
fn garden_plants(
    world: &mut World,
    roadside: &Roadside,
    [from_m, to_m]: [f32; 2],
    depth_m: f32,
    rng: &mut ChaCha8Rng,
) {
    let mut row_m = rng.random_range(1.3_f32..2.2);
    while row_m < depth_m {
        let mut along_m = from_m + rng.random_range(0.8_f32..3.0);
        while along_m < to_m - 0.8 {
            let shape = match rng.random_range(0..100_u32) {
                0..18 => vegetation_shape::tree(rng),
                18..34 => vegetation_shape::bush(rng),
                _ => vegetation_shape::shrub(rng),
            };
            let into_garden_m = row_m + rng.random_range(-0.7_f32..0.7);
            world.stand(shape, &roadside.facing_road(along_m, roadside.building_line_m + into_garden_m));
            along_m += rng.random_range(1.4_f32..4.5);
        }
        row_m += rng.random_range(2.0_f32..5.0);
    }
}
