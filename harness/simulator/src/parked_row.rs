//! Vehicles parked along the kerb, bumper to bumper, and those that stop beside them.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::pavement_people::stand_person;
use super::road_plan::Parking;
use super::roadside::Roadside;
use super::world::{Stance, World, sine_and_cosine};

/// How full the kerb is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParkedRowParams {
    /// How the vehicles stand.
    pub parking: Parking,
    /// Share of the spaces that are taken, 0 to 1.
    pub occupied_share: f64,
    /// Chance that a person stands beside a vehicle that is parked along the kerb, on the side of the road or of the
    /// pavement.
    pub person_beside: f64,
}

/// Parks vehicles 0.3 to 1.0 m apart at the kerb of `roadside`.
pub fn parked_row(world: &mut World, roadside: &Roadside, params: &ParkedRowParams, rng: &mut ChaCha8Rng) {
    match params.parking {
        Parking::Nowhere => {}
        Parking::AlongKerb { .. } | Parking::InTwoRows { .. } => row_along_kerb(world, roadside, params, rng),
        Parking::Askew { turned_rad } => row_askew(world, roadside, params.occupied_share, turned_rad, rng),
    }
}

/// Parks cars side by side with the nose to the kerb, turned by `turned_rad` toward it.
fn row_askew(
    world: &mut World,
    roadside: &Roadside,
    occupied_share: f64,
    turned_rad: f32,
    rng: &mut ChaCha8Rng,
) {
    let (sine, cosine) = sine_and_cosine(turned_rad.into());
    let [mut along_m, end_m] = roadside.reach_m;
    while along_m < end_m - 5.0 {
        // Vans would stand in the way of the traffic.
        let shape = world.fleet.car(rng);
        let size = shape.bounds().extents();
        let width_along_m = size.y / sine;
        let middle_m = along_m + f32::midpoint(width_along_m, size.x * cosine);
        along_m += width_along_m + rng.random_range(0.45..1.0) / sine;
        if rng.random_bool(occupied_share) {
            let from_kerb_m = 0.15 + f32::midpoint(size.x * sine, size.y * cosine);
            let mut placement =
                roadside.along_traffic(middle_m, roadside.kerb_m - from_kerb_m, Stance::OnSlope);
            placement.turned_rad -= turned_rad + rng.random_range(-0.03..0.03);
            world.stand(shape, &placement);
        }
    }
}

fn row_along_kerb(world: &mut World, roadside: &Roadside, params: &ParkedRowParams, rng: &mut ChaCha8Rng) {
    let [mut along_m, end_m] = roadside.reach_m;
    let mut second_row = SecondRow::new(roadside, params.parking, second_row_stream(rng));
    while along_m < end_m {
        if !rng.random_bool(params.occupied_share) {
            along_m += rng.random_range(4.0..9.0);
            continue;
        }
        let shape = world.fleet.parked(rng);
        let size = shape.bounds().extents();
        let middle_m = along_m + size.x / 2.0;
        along_m += size.x + rng.random_range(0.3..1.0);
        if along_m > end_m {
            break;
        }
        let from_kerb_m = rng.random_range(0.12..0.35) + size.y / 2.0;
        let from_axis_m = roadside.kerb_m - from_kerb_m;
        let mut placement = roadside.along_traffic(middle_m, from_axis_m, Stance::OnSlope);
        placement.turned_rad += rng.random_range(-0.02..0.02);
        world.stand(shape, &placement);
        second_row.at_kerb.push(AtKerb {
            along_m: [middle_m - size.x / 2.0, middle_m + size.x / 2.0],
            side_m: from_axis_m - size.y / 2.0,
        });
        if rng.random_bool(params.person_beside) {
            let gap_m = rng.random_range(0.35..0.75);
            let toward_road = if rng.random_bool(0.5) { -1.0 } else { 1.0 };
            let stands_at_m = middle_m + rng.random_range(-1.5..1.5);
            if toward_road < 0.0 {
                second_row.people_m.push(stands_at_m);
            }
            let beside_m = from_axis_m + toward_road * (size.y / 2.0 + gap_m);
            stand_person(world, roadside, [stands_at_m, beside_m], rng);
        }
    }
    second_row.stop(world, roadside);
}

/// A random stream for second rows, apart from those for everything else, so that the rest of a street does not depend on
/// them.
pub fn second_row_stream(rng: &ChaCha8Rng) -> ChaCha8Rng {
    let mut apart = rng.clone();
    apart.set_stream(1);
    apart
}

/// The vehicles that stop beside parked ones.
#[derive(Debug, Clone)]
struct SecondRow {
    rng: ChaCha8Rng,
    /// Share of the vehicles at the kerb that are blocked.
    blocked_share: f64,
    /// Distance from the axis beyond which the lanes for traffic end, in metres.
    lanes_m: f32,
    /// The vehicles at the kerb, in their order along the road.
    at_kerb: Vec<AtKerb>,
    /// Where people stand on the side of the road, in metres along it: no vehicle stops there.
    people_m: Vec<f32>,
}

/// A vehicle at the kerb.
#[derive(Debug, Clone, Copy)]
struct AtKerb {
    /// From where to where along the road, in metres.
    along_m: [f32; 2],
    /// Distance of its side toward the road from the axis, in metres.
    side_m: f32,
}

impl SecondRow {
    fn new(roadside: &Roadside, parking: Parking, rng: ChaCha8Rng) -> Self {
        let blocked_share = match parking {
            Parking::InTwoRows { blocked_share, .. } => blocked_share,
            Parking::Nowhere | Parking::AlongKerb { .. } | Parking::Askew { .. } => 0.0,
        };
        let lanes_m = roadside.kerb_m - parking.width_m();
        Self { rng, blocked_share, lanes_m, at_kerb: Vec::new(), people_m: Vec::new() }
    }

    /// Lets cars stop beside vehicles at the kerb where chance, the traffic and people allow it. The gap to the nearest of
    /// these vehicles just lets a person through, so that from afar both look like one thing.
    fn stop(mut self, world: &mut World, roadside: &Roadside) {
        let rng = &mut self.rng;
        let mut taken_to_m = f32::NEG_INFINITY;
        for blocked in &self.at_kerb {
            if self.blocked_share == 0.0 || !rng.random_bool(self.blocked_share) {
                continue;
            }
            let shape = world.fleet.car(rng);
            let size = shape.bounds().extents();
            let middle_m =
                f32::midpoint(blocked.along_m[0], blocked.along_m[1]) + rng.random_range(-1.0..1.0);
            let [rear_m, front_m] = [middle_m - size.x / 2.0, middle_m + size.x / 2.0];
            let beside = self.at_kerb.iter().filter(|it| it.along_m[0] < front_m && it.along_m[1] > rear_m);
            let side_m = beside.map(|it| it.side_m).fold(blocked.side_m, f32::min);
            let from_axis_m = side_m - SECOND_ROW_GAP_M.start - size.y / 2.0;
            let spare_m = from_axis_m - size.y / 2.0 - self.lanes_m;
            let is_person_there = self.people_m.iter().any(|it| (rear_m - 0.4..front_m + 0.4).contains(it));
            let is_free = rear_m > taken_to_m + 0.4 && !is_person_there;
            if spare_m < 0.0 || !is_free || front_m > roadside.reach_m[1] {
                continue;
            }
            let widest_m = SECOND_ROW_GAP_M.end - SECOND_ROW_GAP_M.start;
            let from_axis_m = from_axis_m - rng.random_range(0.0..=1.0) * spare_m.min(widest_m);
            let mut placement = roadside.along_traffic(middle_m, from_axis_m, Stance::OnSlope);
            placement.turned_rad += rng.random_range(-0.02..0.02);
            world.stand(shape, &placement);
            taken_to_m = front_m;
        }
    }
}

/// Distance between a parked vehicle and one in the second row, in metres.
const SECOND_ROW_GAP_M: std::ops::Range<f32> = 0.3..0.7;

#[cfg(test)]
mod tests {
    use super::super::ground::{Banks, CrossSection, Ground, Road};
    use super::super::object_shape::ObjectShape;
    use super::super::road_axis::{RoadAxis, RoadAxisShape, RoadPosition};
    use super::super::roadside::Side;
    use super::super::world::{Body, Course, Motion};
    use super::*;
    use crate::fleet::TOWN;
    use rand::SeedableRng;
    use reports::vocabulary::class::AnnotationClass;

    const LANES_M: f32 = 3.5;
    const REACH_M: [f32; 2] = [0.0, 400.0];

    /// A straight, level road along x, and vehicles parked to the right of it.
    fn parked(parking: Parking, seed: u8) -> World {
        let kerb_m = LANES_M + parking.width_m();
        let axis = RoadAxis::new(&RoadAxisShape::straight(REACH_M));
        let section =
            CrossSection { left_kerb_m: kerb_m, right_kerb_m: kerb_m, crown: 0.0, kerb_height_m: 0.1 };
        let roads = vec![Road { axis, section, banks: Banks::LEVEL }];
        let ground = Ground { roads, pavement_width_m: 3.0, corner_radius_m: 0.0 };
        let ego = Course::along(0, RoadPosition { along_m: 0.0, left_m: 0.0 }, 1.0, REACH_M);
        let mut world = World::new(ground, ego, 1.0, &TOWN);
        let roadside = Roadside {
            road_idx: 0,
            side: Side::Right,
            reach_m: REACH_M,
            kerb_m,
            building_line_m: kerb_m + 3.0,
        };
        let params = ParkedRowParams { parking, occupied_share: 0.9, person_beside: 0.3 };
        parked_row(&mut world, &roadside, &params, &mut ChaCha8Rng::from_seed([seed; 32]));
        world
    }

    /// Reach along the road and distance from its axis of everything that stands, near and far end.
    fn footprints(world: &World) -> Vec<(AnnotationClass, [f32; 2], [f32; 2])> {
        let footprint = |shape: &ObjectShape, motion: &Motion| {
            let Motion::Standing(pose) = motion else { panic!("nothing moves") };
            let half = shape.bounds().half_extents();
            let (x, y) = (pose.translation.x, -pose.translation.y);
            (shape.class, [x - half.x, x + half.x], [y - half.y, y + half.y])
        };
        let shapes = world.objects.iter().map(|it| match &it.body {
            Body::Rigid(shape) => footprint(shape, &it.motion),
            Body::Walker(_) | Body::Rider(_) => panic!("nobody moves"),
        });
        shapes.collect()
    }

    /// Gaps between vehicles of the second row and those beside them, over some streets.
    fn second_row_gaps_m(parking: Parking) -> Vec<f32> {
        let mut gaps_m = Vec::new();
        for seed in 0..20 {
            let vehicles: Vec<_> = footprints(&parked(parking, seed))
                .into_iter()
                .filter(|(class, ..)| *class != AnnotationClass::Pedestrian)
                .collect();
            for (_, along_m, from_axis_m) in &vehicles {
                assert!(from_axis_m[0] > LANES_M - 0.05, "the lanes stay free: {from_axis_m:?}");
                let beside = vehicles.iter().filter(|(_, other_m, other_from_axis_m)| {
                    other_m[0] < along_m[1]
                        && along_m[0] < other_m[1]
                        && other_from_axis_m[0] > from_axis_m[0] + 1.0
                });
                let gaps = beside.map(|(_, _, other_from_axis_m)| other_from_axis_m[0] - from_axis_m[1]);
                gaps_m.extend(gaps.reduce(f32::min));
            }
        }
        gaps_m
    }

    #[test]
    fn cars_in_the_second_row_leave_a_narrow_gap() {
        let gaps_m = second_row_gaps_m(Parking::InTwoRows { width_m: 4.8, blocked_share: 0.3 });
        assert!(gaps_m.len() > 30, "{}", gaps_m.len());
        let n_narrow = gaps_m.iter().filter(|it| (0.25..0.75).contains(*it)).count();
        assert!(n_narrow * 10 >= gaps_m.len() * 7, "{gaps_m:?}");
        assert!(gaps_m.iter().all(|it| (0.0..1.3).contains(it)), "{gaps_m:?}");
    }

    #[test]
    fn where_one_row_fits_there_is_one() {
        assert!(second_row_gaps_m(Parking::AlongKerb { width_m: 2.5 }).is_empty());
    }

    #[test]
    fn nobody_stands_in_a_vehicle() {
        for seed in 0..20 {
            let all = footprints(&parked(Parking::InTwoRows { width_m: 4.8, blocked_share: 0.3 }, seed));
            let (people, vehicles): (Vec<_>, Vec<_>) =
                all.into_iter().partition(|(class, ..)| *class == AnnotationClass::Pedestrian);
            for (_, along_m, from_axis_m) in people {
                let middle_m =
                    [f32::midpoint(along_m[0], along_m[1]), f32::midpoint(from_axis_m[0], from_axis_m[1])];
                let inside = vehicles.iter().find(|(_, x_m, y_m)| {
                    (x_m[0]..x_m[1]).contains(&middle_m[0]) && (y_m[0]..y_m[1]).contains(&middle_m[1])
                });
                assert_eq!(inside, None, "seed {seed} {middle_m:?}");
            }
        }
    }
}
