//! Cars, vans, trucks and buses of many makes.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;

use super::body_style::{self, BodyStyle};
use super::car_shape::car_of_style;
use super::material::Material;
use super::object_shape::ObjectShape;
use super::solid::Solid;
use super::vehicle_parts::{paint, pillars, prism, seats, wheels};

/// How often cars, vans, trucks and buses are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VehicleMix {
    /// As in a town.
    Town,
    /// As where goods are handled: trucks and buses are half of what drives and a third of what is parked.
    Haulage,
    /// As in a North American town, with its cars.
    NorthAmerican,
}

impl VehicleMix {
    /// What drives or waits.
    pub fn driven(self, rng: &mut ChaCha8Rng) -> ObjectShape {
        match self {
            Self::Town => self.one_of([78, 13, 5], rng),
            Self::Haulage => self.one_of([35, 15, 30], rng),
            Self::NorthAmerican => self.one_of([84, 6, 6], rng),
        }
    }

    /// What is parked along streets.
    pub fn parked(self, rng: &mut ChaCha8Rng) -> ObjectShape {
        match self {
            Self::Town => self.one_of([88, 12, 0], rng),
            Self::Haulage => self.one_of([54, 13, 23], rng),
            Self::NorthAmerican => self.one_of([95, 5, 0], rng),
        }
    }

    /// A car.
    pub fn car(self, rng: &mut ChaCha8Rng) -> ObjectShape {
        let styles = match self {
            Self::Town | Self::Haulage => &body_style::EUROPEAN,
            Self::NorthAmerican => &body_style::NORTH_AMERICAN,
        };
        car_of_style(BodyStyle::any(styles, rng), rng)
    }

    /// A car, van or truck in so many of a hundred cases each, else a bus.
    fn one_of(self, [cars, vans, trucks]: [u32; 3], rng: &mut ChaCha8Rng) -> ObjectShape {
        match rng.random_range(0..100_u32) {
            it if it < cars => self.car(rng),
            it if it < cars + vans => van(rng),
            it if it < cars + vans + trucks => truck(rng),
            _ => bus(rng),
        }
    }
}

/// A passenger car of a European town.
pub fn car(rng: &mut ChaCha8Rng) -> ObjectShape {
    VehicleMix::Town.car(rng)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Prism;
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
            (VehicleMix::NorthAmerican, [84.0, 6.0, 6.0, 4.0], [95.0, 5.0, 0.0, 0.0]),
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
    fn north_american_cars_are_larger() {
        check(|rng| VehicleMix::NorthAmerican.car(rng), [4.0, 6.25], [1.4, 2.05]);
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
