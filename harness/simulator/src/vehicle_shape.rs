//! Cars, vans, trucks and buses of many makes.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::material::Material;
use super::object_shape::ObjectShape;
use super::solid::{Prism, Solid};

/// How often cars, vans, trucks and buses are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VehicleMix {
    /// As in a town.
    Town,
    /// As where goods are handled: trucks and buses are half of what drives and a third of what is parked.
    Haulage,
}

impl VehicleMix {
    /// What drives or waits.
    pub fn driven(self, rng: &mut ChaCha8Rng) -> ObjectShape {
        match self {
            Self::Town => one_of([78, 13, 5], rng),
            Self::Haulage => one_of([35, 15, 30], rng),
        }
    }

    /// What is parked along streets.
    pub fn parked(self, rng: &mut ChaCha8Rng) -> ObjectShape {
        match self {
            Self::Town => one_of([88, 12, 0], rng),
            Self::Haulage => one_of([54, 13, 23], rng),
        }
    }
}

/// A car, van or truck in so many of a hundred cases each, else a bus.
fn one_of([cars, vans, trucks]: [u32; 3], rng: &mut ChaCha8Rng) -> ObjectShape {
    match rng.random_range(0..100_u32) {
        it if it < cars => car(rng),
        it if it < cars + vans => van(rng),
        it if it < cars + vans + trucks => truck(rng),
        _ => bus(rng),
    }
}

/// Where the cabin of a car begins and ends, as shares of the length from the front.
struct BodyStyle {
    /// How many of a hundred cars are like this.
    percent: u32,
    length_m: std::ops::Range<f32>,
    height_m: std::ops::Range<f32>,
    width_m: std::ops::Range<f32>,
    windscreen_foot: f32,
    roof_front: f32,
    roof_rear: f32,
    rear_window_foot: f32,
    /// Height of the tail over the height of the waist.
    tail: f32,
}

/// What stands in the streets of a European town: mostly small cars.
const BODY_STYLES: [BodyStyle; 6] = [
    // Small hatchback.
    BodyStyle {
        percent: 34,
        length_m: 3.5..4.0,
        height_m: 1.42..1.55,
        width_m: 1.58..1.68,
        windscreen_foot: 0.25,
        roof_front: 0.43,
        roof_rear: 0.89,
        rear_window_foot: 0.99,
        tail: 0.98,
    },
    // Hatchback.
    BodyStyle {
        percent: 26,
        length_m: 3.95..4.3,
        height_m: 1.42..1.52,
        width_m: 1.68..1.77,
        windscreen_foot: 0.27,
        roof_front: 0.44,
        roof_rear: 0.88,
        rear_window_foot: 0.99,
        tail: 0.98,
    },
    // Saloon.
    BodyStyle {
        percent: 12,
        length_m: 4.3..4.85,
        height_m: 1.40..1.48,
        width_m: 1.70..1.82,
        windscreen_foot: 0.28,
        roof_front: 0.44,
        roof_rear: 0.70,
        rear_window_foot: 0.85,
        tail: 0.98,
    },
    // Estate.
    BodyStyle {
        percent: 13,
        length_m: 4.3..4.8,
        height_m: 1.42..1.52,
        width_m: 1.70..1.80,
        windscreen_foot: 0.27,
        roof_front: 0.43,
        roof_rear: 0.92,
        rear_window_foot: 0.995,
        tail: 0.99,
    },
    // Off-roader.
    BodyStyle {
        percent: 5,
        length_m: 4.0..4.7,
        height_m: 1.62..1.80,
        width_m: 1.74..1.86,
        windscreen_foot: 0.27,
        roof_front: 0.41,
        roof_rear: 0.92,
        rear_window_foot: 0.995,
        tail: 0.99,
    },
    // People carrier.
    BodyStyle {
        percent: 10,
        length_m: 3.9..4.6,
        height_m: 1.56..1.72,
        width_m: 1.68..1.80,
        windscreen_foot: 0.17,
        roof_front: 0.38,
        roof_rear: 0.92,
        rear_window_foot: 0.995,
        tail: 0.99,
    },
];

fn any_body_style(rng: &mut ChaCha8Rng) -> &'static BodyStyle {
    let mut drawn = rng.random_range(0..BODY_STYLES.iter().map(|it| it.percent).sum::<u32>());
    let is_drawn = |style: &&BodyStyle| {
        let is_it = drawn < style.percent;
        drawn = drawn.saturating_sub(style.percent);
        is_it
    };
    BODY_STYLES.iter().find(is_drawn).unwrap_or(&BODY_STYLES[0])
}

/// Paints from black to white.
///
/// Under clear coat the light that is not sent back diffusely is mirrored away. What dark pigments send back diffusely is
/// next to nothing: of a black car a scan shows what faces the sensor, lamps, plates and rims, and little of its
/// sides and bonnet.
fn paint(rng: &mut ChaCha8Rng) -> Material {
    const REFLECTIVITIES: [f32; 10] = [0.002, 0.002, 0.005, 0.012, 0.05, 0.12, 0.2, 0.3, 0.45, 0.65];
    Material::solid(REFLECTIVITIES[rng.random_range(0..REFLECTIVITIES.len())] * rng.random_range(0.8..1.2))
}

/// A passenger car.
pub fn car(rng: &mut ChaCha8Rng) -> ObjectShape {
    let style = any_body_style(rng);
    let length_m = rng.random_range(style.length_m.clone());
    let height_m = rng.random_range(style.height_m.clone());
    let half_width_m = rng.random_range(style.width_m.clone()) / 2.0;
    let waist_m = height_m * rng.random_range(0.60..0.66);
    let clearance_m = height_m * rng.random_range(0.13..0.17);
    let paint = paint(rng);
    let x = |share: f32| length_m * (0.5 - share);

    // The bonnet rises to the foot of the windscreen.
    let body = vec![
        [x(1.0), clearance_m + 0.12],
        [x(0.97), clearance_m],
        [x(0.03), clearance_m],
        [x(0.0), clearance_m + 0.10],
        [x(0.0), waist_m * 0.62],
        [x(0.035), waist_m * 0.79],
        [x(style.windscreen_foot), waist_m],
        [x(style.rear_window_foot), waist_m * style.tail],
        [x(1.0), waist_m * style.tail * 0.86],
    ];
    let cabin = vec![
        [x(style.rear_window_foot), waist_m * style.tail - 0.02],
        [x(style.windscreen_foot), waist_m - 0.02],
        [x(style.roof_front), height_m - 0.02],
        [x(style.roof_rear), height_m - 0.02],
    ];
    let roof = vec![
        [x(style.roof_rear), height_m - 0.05],
        [x(style.roof_front), height_m - 0.05],
        [x(style.roof_front) - 0.1, height_m],
        [x(style.roof_rear) + 0.1, height_m],
    ];
    let cabin_top_half_width_m = half_width_m * rng.random_range(0.68..0.76);
    let shoulder_half_width_m = half_width_m - 0.04;
    let mut parts = vec![
        (prism(body, half_width_m, half_width_m - 0.03), paint),
        (prism(cabin, shoulder_half_width_m, cabin_top_half_width_m), Material::GLASS),
        (prism(roof, cabin_top_half_width_m, cabin_top_half_width_m - 0.04), paint),
        (
            seats([x(style.roof_rear), x(style.roof_front)], [waist_m - 0.05, height_m], half_width_m),
            Material::RUBBER,
        ),
    ];
    let heights_m = [waist_m - 0.02, height_m - 0.02];
    let half_widths_m = [shoulder_half_width_m + 0.005, cabin_top_half_width_m + 0.005];
    let middle = f32::midpoint(style.roof_front, style.roof_rear);
    for (foot, top) in [
        (style.windscreen_foot, style.roof_front),
        (middle, middle),
        (style.rear_window_foot - 0.015, style.roof_rear),
    ] {
        parts.extend(pillars([x(foot), x(top)], heights_m, half_widths_m).map(|pillar| (pillar, paint)));
    }
    parts.extend(lamps_and_plates([x(1.0), x(0.0)], waist_m, half_width_m));
    let wheel_radius_m = rng.random_range(0.28..0.33);
    parts.extend(wheels([x(0.19), x(0.80)], wheel_radius_m, half_width_m));
    ObjectShape::new(AnnotationClass::Car, parts)
}

fn van(rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(4.8_f32..6.2);
    let height_m = rng.random_range(1.9_f32..2.6);
    let half_width_m = rng.random_range(0.95_f32..1.02);
    let paint = paint(rng);
    let front = length_m / 2.0;
    let (waist_m, nose_m) = (1.15, rng.random_range(0.5_f32..0.9));
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
    // The panes lie a finger's breadth before the sheet metal: what gets through meets the inside at once.
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

fn truck(rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(TRUCK_LENGTHS_M);
    let height_m = rng.random_range(2.9_f32..3.8);
    truck_of_size(length_m, height_m, rng)
}

/// A truck of this height in metres.
pub fn truck_of_height(height_m: f32, rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(TRUCK_LENGTHS_M);
    truck_of_size(length_m, height_m, rng)
}

const TRUCK_LENGTHS_M: std::ops::Range<f32> = 6.5..10.0;

fn truck_of_size(length_m: f32, height_m: f32, rng: &mut ChaCha8Rng) -> ObjectShape {
    let half_width_m = rng.random_range(1.1_f32..1.27);
    let front = length_m / 2.0;
    let cab_m = rng.random_range(1.7_f32..2.3);
    let cab_height_m = height_m.min(rng.random_range(2.4_f32..3.2));
    let (paint, box_paint) = (paint(rng), paint(rng));
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
        (
            Solid::cuboid([-front, -half_width_m, 1.0], [front - cab_m - 0.25, half_width_m, height_m]),
            box_paint,
        ),
        // The frame below the load.
        (Solid::cuboid([-front + 0.3, -0.45, 0.6], [front - cab_m, 0.45, 1.0]), Material::RUBBER),
    ];
    parts.extend(wheels([front - 1.2, -front + 1.6], 0.48, half_width_m - 0.03));
    ObjectShape::new(AnnotationClass::Truck, parts)
}

fn bus(rng: &mut ChaCha8Rng) -> ObjectShape {
    let length_m = rng.random_range(10.0_f32..12.5);
    let height_m = rng.random_range(2.9_f32..3.2);
    let half_width_m = 1.26;
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
    let n_bays = 6;
    for bay in 0..=n_bays {
        let x = -front + 0.15 + (length_m - 0.45) * bay as f32 / n_bays as f32;
        parts.extend(
            pillars([x, x], [1.1, 2.5], [half_width_m, half_width_m - 0.05]).map(|pillar| (pillar, paint)),
        );
    }
    parts.extend(wheels([front - 2.7, -front + 3.0], 0.48, half_width_m - 0.02));
    ObjectShape::new(AnnotationClass::Bus, parts)
}

fn prism(profile_m: Vec<[f32; 2]>, bottom_half_width_m: f32, top_half_width_m: f32) -> Solid {
    Solid::Prism(Prism { profile_m, center_y_m: 0.0, bottom_half_width_m, top_half_width_m })
}

/// The block of seats that is seen through the panes.
fn seats([rear, front]: [f32; 2], [bottom, top]: [f32; 2], half_width_m: f32) -> Solid {
    let seat_top = bottom + 0.45 * (top - bottom);
    Solid::cuboid([rear + 0.3, -half_width_m * 0.65, bottom], [front - 0.35, half_width_m * 0.65, seat_top])
}

/// A post in the left and in the right side of a cabin, from the waist to the roof.
fn pillars(
    [foot_x, top_x]: [f32; 2],
    [foot_z, top_z]: [f32; 2],
    [foot_half_width_m, top_half_width_m]: [f32; 2],
) -> impl Iterator<Item = Solid> {
    [-1.0, 1.0].into_iter().map(move |side| {
        let inset_m = 0.035;
        Solid::cylinder(
            [foot_x, side * (foot_half_width_m - inset_m), foot_z],
            [top_x, side * (top_half_width_m - inset_m), top_z],
            0.045,
        )
    })
}

/// A lamp in each corner of front and rear, and a number plate between: they flash back at any laser.
fn lamps_and_plates(
    [rear, front]: [f32; 2],
    waist_m: f32,
    half_width_m: f32,
) -> impl Iterator<Item = (Solid, Material)> {
    [(rear, -1.0_f32), (front, 1.0)].into_iter().flat_map(move |(end, outward)| {
        // A finger's breadth before the sheet metal, flush with the bumper.
        let [inner, outer] = [end - outward * 0.12, end + outward * 0.01];
        let slab = |side_m: [f32; 2], height_m: [f32; 2]| {
            Solid::cuboid(
                [inner.min(outer), side_m[0], height_m[0]],
                [inner.max(outer), side_m[1], height_m[1]],
            )
        };
        let lamp_m = [waist_m * 0.58, waist_m * 0.74];
        [
            slab([half_width_m * 0.58, half_width_m * 0.95], lamp_m),
            slab([half_width_m * -0.95, half_width_m * -0.58], lamp_m),
            slab([-0.26, 0.26], [waist_m * 0.4, waist_m * 0.4 + 0.11]),
        ]
        .map(|solid| (solid, Material::RETROREFLECTOR))
    })
}

/// Four wheels that stand a little proud of the body.
fn wheels(
    axles_x: [f32; 2],
    radius_m: f32,
    body_half_width_m: f32,
) -> impl Iterator<Item = (Solid, Material)> {
    let sides = [-1.0, 1.0].into_iter();
    sides.flat_map(move |side| {
        axles_x.into_iter().map(move |x| {
            let outer_y = side * (body_half_width_m + 0.01);
            let inner_y = side * (body_half_width_m - 0.2);
            (Solid::cylinder([x, inner_y, radius_m], [x, outer_y, radius_m], radius_m), Material::RUBBER)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

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
    fn vehicles_are_as_often_seen_as_said() {
        let shares = |draw: &dyn Fn(&mut ChaCha8Rng) -> ObjectShape| {
            let mut rng = ChaCha8Rng::from_seed([3; 32]);
            let classes: Vec<_> = (0..2000).map(|_| draw(&mut rng).class).collect();
            [AnnotationClass::Car, AnnotationClass::Van, AnnotationClass::Truck, AnnotationClass::Bus]
                .map(|class| classes.iter().filter(|&&it| it == class).count() as f32 / 20.0)
        };
        for (mix, driven, parked) in [
            (VehicleMix::Town, [78.0, 13.0, 5.0, 4.0], [88.0, 12.0, 0.0, 0.0]),
            (VehicleMix::Haulage, [35.0, 15.0, 30.0, 20.0], [54.0, 13.0, 23.0, 10.0]),
        ] {
            for (found, said) in
                [(shares(&|it| mix.driven(it)), driven), (shares(&|it| mix.parked(it)), parked)]
            {
                for (found, said) in found.into_iter().zip(said) {
                    assert!(
                        (found - said).abs() < 3.5 && (found > 0.0) == (said > 0.0),
                        "{mix:?}: {found} of {said}"
                    );
                }
            }
        }
    }

    #[test]
    fn cars_are_as_large_as_cars() {
        check(car, [3.5, 4.9], [1.35, 1.85]);
    }

    #[test]
    fn vans_are_as_large_as_vans() {
        check(van, [4.7, 6.3], [1.85, 2.7]);
    }

    #[test]
    fn trucks_are_as_large_as_trucks() {
        check(truck, [6.4, 10.1], [2.8, 3.9]);
    }

    #[test]
    fn buses_are_as_large_as_buses() {
        check(bus, [9.9, 12.6], [2.8, 3.3]);
    }
}
