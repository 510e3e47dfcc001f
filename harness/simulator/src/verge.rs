//! Spots beside roads for the things that a condition adds.

use std::ops::Range;

use parry3d::math::Pose;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::object_shape::ObjectShape;
use super::road_plan::MARGIN_M;
use super::roadside::{Roadside, Side};
use super::world::{Placement, Stance, World, world_from_placement};

/// Nothing is put this near to the axis of another road, in metres.
const CLEAR_OF_ROADS_M: f32 = 14.0;

/// A spot beside a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// The side of the road.
    pub roadside: Roadside,
    /// How far along the road, in metres.
    pub along_m: f32,
}

/// Spots on both sides of all roads, from one to the next as far as `spacings_m` say.
pub fn spots(world: &World, spacings_m: &Range<f32>, rng: &mut ChaCha8Rng) -> Vec<Spot> {
    let mut spots = Vec::new();
    for (road, road_idx) in world.ground.roads.iter().zip(0..) {
        let reach_m = if road_idx == world.ego.road_idx { world.ego.reach_m } else { [-MARGIN_M, MARGIN_M] };
        let kerbs_m = [road.section.left_kerb_m, road.section.right_kerb_m];
        for (side, kerb_m) in [Side::Left, Side::Right].into_iter().zip(kerbs_m) {
            let building_line_m = kerb_m + world.ground.pavement_width_m;
            let roadside = Roadside { road_idx, side, reach_m, kerb_m, building_line_m };
            let mut along_m = reach_m[0];
            loop {
                along_m += rng.random_range(spacings_m.clone());
                if along_m > reach_m[1] {
                    break;
                }
                let spot = Spot { roadside, along_m };
                if spot.is_clear(world) {
                    spots.push(spot);
                }
            }
        }
    }
    spots
}

impl Spot {
    /// Width of the pavement, in metres.
    pub fn pavement_m(&self) -> f32 {
        self.roadside.building_line_m - self.roadside.kerb_m
    }

    /// Placement of a thing `beyond_line_m` behind the building line and `ahead_m` along the traffic, whose x points along
    /// the traffic and y toward the road, turned by `turned_rad`.
    pub fn behind_line(&self, [ahead_m, beyond_line_m]: [f32; 2], turned_rad: f32) -> Placement {
        self.at([ahead_m, self.roadside.building_line_m + beyond_line_m], turned_rad)
    }

    /// As [`Self::behind_line`], but `beyond_kerb_m` behind the kerb.
    pub fn behind_kerb(&self, [ahead_m, beyond_kerb_m]: [f32; 2], turned_rad: f32) -> Placement {
        self.at([ahead_m, self.roadside.kerb_m + beyond_kerb_m], turned_rad)
    }

    /// Position in the road's coordinates: along it, and `beyond_kerb_m` behind the kerb.
    pub fn on_pavement(&self, [ahead_m, beyond_kerb_m]: [f32; 2]) -> [f32; 2] {
        [self.along_axis_m(ahead_m), self.roadside.kerb_m + beyond_kerb_m]
    }

    fn at(&self, [ahead_m, from_axis_m]: [f32; 2], turned_rad: f32) -> Placement {
        let mut placement = self.roadside.facing_road(self.along_axis_m(ahead_m), from_axis_m);
        placement.turned_rad += turned_rad;
        placement
    }

    fn along_axis_m(&self, ahead_m: f32) -> f32 {
        self.along_m - self.roadside.side.sign() * ahead_m
    }

    fn is_clear(&self, world: &World) -> bool {
        let frame = world_from_placement(&world.ground, &self.behind_kerb([0.0; 2], 0.0));
        let plan = [frame.translation.x, frame.translation.y];
        world.ground.roads.iter().enumerate().all(|(other_idx, other)| {
            other_idx == self.roadside.road_idx
                || other.axis.road_position(plan).left_m.abs() > CLEAR_OF_ROADS_M
        })
    }
}

/// The frame of walls at `placement`.
pub fn frame(world: &World, placement: &Placement) -> Pose {
    world_from_placement(&world.ground, placement)
}

/// Puts a vehicle at `placement`, which leans with the ground.
pub fn park(world: &mut World, vehicle: ObjectShape, placement: &Placement) {
    world.stand(vehicle, &Placement { stance: Stance::OnSlope, ..*placement });
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use reports::vocabulary::class::AnnotationClass;

    use crate::sensor::SensorModel;
    use crate::street::{Street, StreetKind};
    use crate::street_conditions::StreetConditions;

    /// How many objects of each class are seen from some streets.
    fn seen(conditions: &StreetConditions) -> BTreeMap<AnnotationClass, usize> {
        let sensor = SensorModel { n_firings_per_turn: 400, ..SensorModel::hdl_64e_s2() };
        let mut seen = BTreeMap::new();
        for kind in StreetKind::ALL {
            for seed in 0..8 {
                for it in Street::under(kind, seed, conditions).scan(&sensor, 40).annotations {
                    *seen.entry(it.class).or_default() += 1;
                }
            }
        }
        seen
    }

    #[test]
    fn conditions_put_what_they_are_named_after_beside_the_roads() {
        use AnnotationClass::{Fence, Hedge, ParkedCycle, SittingPerson, StreetFurniture};
        let none = StreetConditions::default();
        let without = seen(&none);
        for (conditions, classes) in [
            (StreetConditions { gardens: true, ..none }, vec![Hedge]),
            (StreetConditions { works: true, ..none }, vec![Fence, StreetFurniture]),
            (StreetConditions { crowd: true, ..none }, vec![ParkedCycle, SittingPerson]),
        ] {
            let with = seen(&conditions);
            for class in classes {
                let [before, after] = [&without, &with].map(|it| it.get(&class).copied().unwrap_or(0));
                assert!(after > before + 20, "{class:?} under {conditions:?}: {after} instead of {before}");
            }
        }
    }
}
