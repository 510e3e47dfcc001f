//! Vans, trucks and buses of many makes.

use std::ops::Range;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;
use serde::Deserialize;

use super::material::Material;
use super::object_shape::ObjectShape;
use super::solid::Solid;
use super::vehicle_parts::{paint, pillars, prism, range, seats, wheels};

/// Dimensions of vans of one kind.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VanStyle {
    /// How many of a hundred vans are like this.
    #[serde(default = "all")]
    pub percent: u32,
    /// Lengths over all.
    #[serde(deserialize_with = "range")]
    pub length_m: Range<f32>,
    /// Heights over the road.
    #[serde(deserialize_with = "range")]
    pub height_m: Range<f32>,
    /// Halves of widths without mirrors.
    #[serde(deserialize_with = "range")]
    pub half_width_m: Range<f32>,
    /// How far the bonnet stands out.
    #[serde(deserialize_with = "range")]
    pub nose_m: Range<f32>,
}

/// How a truck carries its load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Load {
    /// A closed box.
    #[default]
    Box,
    /// An open bed, in which something may lie.
    Bed,
    /// A tank.
    Tank,
}

/// Dimensions of trucks of one kind.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruckStyle {
    /// How many of a hundred trucks are like this.
    #[serde(default = "all")]
    pub percent: u32,
    /// How it carries its load.
    #[serde(default)]
    pub load: Load,
    /// Lengths over all.
    #[serde(deserialize_with = "range")]
    pub length_m: Range<f32>,
    /// Heights over the road, of the load.
    #[serde(deserialize_with = "range")]
    pub height_m: Range<f32>,
    /// Halves of widths without mirrors.
    #[serde(deserialize_with = "range")]
    pub half_width_m: Range<f32>,
    /// Lengths of the cab.
    #[serde(deserialize_with = "range")]
    pub cab_m: Range<f32>,
    /// Heights of the cab.
    #[serde(deserialize_with = "range")]
    pub cab_height_m: Range<f32>,
}

/// Dimensions of buses of one kind.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BusStyle {
    /// How many of a hundred buses are like this.
    #[serde(default = "all")]
    pub percent: u32,
    /// Lengths over all.
    #[serde(deserialize_with = "range")]
    pub length_m: Range<f32>,
    /// Heights over the road.
    #[serde(deserialize_with = "range")]
    pub height_m: Range<f32>,
    /// Half of the width.
    pub half_width_m: f32,
    /// Windows on a side.
    pub n_bays: u32,
}

fn all() -> u32 {
    100
}

/// A van of this style.
pub fn van(style: &VanStyle, rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(style.length_m.clone());
    let height_m = rng.random_range(style.height_m.clone());
    let half_width_m = rng.random_range(style.half_width_m.clone());
    let paint = paint(rng);
    let front = length_m / 2.0;
    let (waist_m, nose_m) = (1.15, rng.random_range(style.nose_m.clone()));
    let lower = vec![
        [-front, 0.3],
        [front - 0.1, 0.25],
        [front, 0.4],
        [front, 0.75],
        [front - nose_m, waist_m],
        [-front, waist_m],
    ];
    let upper = vec![
        [-front, waist_m - 0.02],
        [front - nose_m, waist_m - 0.02],
        [front - nose_m - 0.6, height_m - 0.08],
        [front - nose_m - 0.9, height_m],
        [-front + 0.05, height_m],
    ];
    // The panes lie a finger's breadth before the sheet metal: a pulse that gets through meets the inside at once.
    let windscreen = vec![
        [front - nose_m - 0.55, height_m - 0.15],
        [front - nose_m - 0.15, waist_m],
        [front - nose_m + 0.03, waist_m],
        [front - nose_m - 0.52, height_m - 0.15],
    ];
    let mut parts = vec![
        (prism(lower, half_width_m, half_width_m), paint),
        (prism(upper, half_width_m, half_width_m - 0.08), paint),
        (prism(windscreen, half_width_m - 0.12, half_width_m - 0.2), Material::GLASS),
    ];
    parts.extend(wheels([front - 0.85, -front + 1.0], 0.34, half_width_m));
    ObjectShape::new(AnnotationClass::Van, parts)
}

/// A truck of this style, and of this height in metres if it is given.
pub fn truck(style: &TruckStyle, height_m: Option<f32>, rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(style.length_m.clone());
    let height_m = height_m.unwrap_or_else(|| rng.random_range(style.height_m.clone()));
    let half_width_m = rng.random_range(style.half_width_m.clone());
    let front = length_m / 2.0;
    let cab_m = rng.random_range(style.cab_m.clone());
    let drawn_m = rng.random_range(style.cab_height_m.clone());
    // A box is at least as high as its cab.
    let cab_height_m = if style.load == Load::Box { height_m.min(drawn_m) } else { drawn_m };
    let (paint, load_paint) = (paint(rng), paint(rng));
    let cab = vec![
        [front - cab_m, 0.55],
        [front - 0.05, 0.35],
        [front, 1.3],
        [front - 0.2, cab_height_m - 0.1],
        [front - 0.5, cab_height_m],
        [front - cab_m, cab_height_m],
    ];
    let mut parts = vec![
        (prism(cab, half_width_m - 0.05, half_width_m - 0.12), paint),
        // The frame below the load.
        (Solid::cuboid([-front + 0.3, -0.45, 0.6], [front - cab_m, 0.45, 1.0]), Material::RUBBER),
    ];
    let reach_m = [-front, front - cab_m - 0.25];
    parts.extend(load(style.load, reach_m, [half_width_m, height_m], load_paint, rng));
    // Light trucks stand on small wheels.
    let wheel_m = if half_width_m < LIGHT_HALF_WIDTH_M { 0.36 } else { 0.48 };
    parts.extend(wheels([front - 1.2, -front + 1.6], wheel_m, half_width_m - 0.03));
    ObjectShape::new(AnnotationClass::Truck, parts)
}

/// Narrower trucks are light ones.
const LIGHT_HALF_WIDTH_M: f32 = 1.1;

/// Parts behind the cab, from x to x in metres.
fn load(
    load: Load,
    [rear_m, front_m]: [f32; 2],
    [half_width_m, height_m]: [f32; 2],
    paint: Material,
    rng: &mut ChaCha8Rng,
) -> Vec<(Solid, Material)> {
    let block = |x_m: [f32; 2], y_m: [f32; 2], z_m: [f32; 2]| {
        Solid::cuboid([x_m[0], y_m[0], z_m[0]], [x_m[1], y_m[1], z_m[1]])
    };
    match load {
        Load::Box => {
            vec![(block([rear_m, front_m], [-half_width_m, half_width_m], [1.0, height_m]), paint)]
        }
        Load::Tank => {
            let radius_m = half_width_m.min(0.5 * (height_m - 1.0));
            let at = |x_m: f32| [x_m, 0.0, height_m - radius_m];
            vec![(Solid::cylinder(at(rear_m), at(front_m), radius_m), paint)]
        }
        Load::Bed => {
            let sides_m = rng.random_range(1.2_f32..1.7).min(height_m);
            let [inner_m, outer_m] = [half_width_m - 0.06, half_width_m];
            let mut parts = vec![
                (block([rear_m, front_m], [-outer_m, outer_m], [0.95, 1.05]), paint),
                (block([rear_m, front_m], [-outer_m, -inner_m], [1.0, sides_m]), paint),
                (block([rear_m, front_m], [inner_m, outer_m], [1.0, sides_m]), paint),
                (block([rear_m, rear_m + 0.06], [-outer_m, outer_m], [1.0, sides_m]), paint),
                (block([front_m - 0.06, front_m], [-outer_m, outer_m], [1.0, sides_m + 0.4]), paint),
            ];
            let mut from_m = rear_m + 0.3;
            while from_m < front_m - 0.8 && rng.random_bool(0.7) {
                let to_m = (from_m + rng.random_range(0.5_f32..2.5)).min(front_m - 0.2);
                let half_m = inner_m * rng.random_range(0.4_f32..1.0);
                let top_m = rng.random_range(1.2_f32..1.3_f32.max(height_m));
                parts.push((block([from_m, to_m], [-half_m, half_m], [1.05, top_m]), Material::solid(0.3)));
                from_m = to_m + rng.random_range(0.05_f32..0.8);
            }
            parts
        }
    }
}

/// A bus of this style.
pub fn bus(style: &BusStyle, rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(style.length_m.clone());
    let height_m = rng.random_range(style.height_m.clone());
    let half_width_m = style.half_width_m;
    let front = length_m / 2.0;
    let paint = paint(rng);
    let skirt = vec![[-front, 0.35], [front - 0.1, 0.3], [front, 0.5], [front, 1.1], [-front, 1.1]];
    let windows = vec![[-front + 0.05, 1.1], [front - 0.03, 1.1], [front - 0.2, 2.5], [-front + 0.1, 2.5]];
    let mut parts = vec![
        (prism(skirt, half_width_m, half_width_m), paint),
        (prism(windows, half_width_m - 0.01, half_width_m - 0.06), Material::GLASS),
        (
            Solid::cuboid(
                [-front + 0.1, -half_width_m + 0.05, 2.5],
                [front - 0.2, half_width_m - 0.05, height_m],
            ),
            paint,
        ),
        (seats([-front + 0.5, front - 1.5], [1.1, 2.3], half_width_m), Material::RUBBER),
    ];
    let n_bays = style.n_bays;
    for bay in 0..=n_bays {
        let x = -front + 0.15 + (length_m - 0.45) * bay as f32 / n_bays as f32;
        parts.extend(
            pillars([x, x], [1.1, 2.5], [half_width_m, half_width_m - 0.05]).map(|pillar| (pillar, paint)),
        );
    }
    parts.extend(wheels([front - 2.7, -front + 3.0], 0.48, half_width_m - 0.02));
    ObjectShape::new(AnnotationClass::Bus, parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::{HAULAGE, NORTH_AMERICAN, TOWN, VARIED};
    use crate::solid::Prism;
    use rand::SeedableRng;

    /// The next of this class where goods are handled, whose vehicles are those of a town.
    fn of_class(class: AnnotationClass, rng: &mut ChaCha8Rng) -> ObjectShape {
        loop {
            let shape = HAULAGE.driven(rng);
            if shape.class == class {
                return shape;
            }
        }
    }

    #[track_caller]
    fn check(make: fn(&mut ChaCha8Rng) -> ObjectShape, lengths_m: [f32; 2], heights_m: [f32; 2]) {
        let mut rng = ChaCha8Rng::from_seed([7; 32]);
        for _ in 0..200 {
            let shape = make(&mut rng);
            let prisms = shape.parts.iter().filter_map(|part| match &part.solid {
                Solid::Prism(prism) => Some(prism),
                _ => None,
            });
            assert!(prisms.clone().all(Prism::is_convex));
            let bounds = shape.bounds();
            let size = bounds.extents();
            assert!((lengths_m[0]..lengths_m[1]).contains(&size.x), "length {}", size.x);
            assert!((1.55..2.6).contains(&size.y), "width {}", size.y);
            assert!((heights_m[0]..heights_m[1]).contains(&size.z), "height {}", size.z);
            assert!(bounds.mins.z.abs() < 1e-3, "wheels stand on the road");
        }
    }

    #[test]
    fn cars_are_as_large_as_cars() {
        check(|rng| TOWN.car(rng), [3.5, 4.9], [1.35, 1.85]);
    }

    #[test]
    fn north_american_cars_are_larger() {
        check(|rng| NORTH_AMERICAN.car(rng), [4.0, 6.25], [1.4, 2.05]);
    }

    #[test]
    fn vans_are_as_large_as_vans() {
        check(|rng| of_class(AnnotationClass::Van, rng), [4.7, 6.3], [1.85, 2.7]);
    }

    #[test]
    fn trucks_are_as_large_as_trucks() {
        check(|rng| of_class(AnnotationClass::Truck, rng), [6.4, 10.1], [2.8, 3.9]);
    }

    #[test]
    fn buses_are_as_large_as_buses() {
        check(|rng| of_class(AnnotationClass::Bus, rng), [9.9, 12.6], [2.8, 3.3]);
    }

    #[test]
    fn varied_vehicles_are_of_all_sizes() {
        check(|rng| VARIED.driven(rng), [3.5, 18.8], [1.35, 4.05]);
    }
}
