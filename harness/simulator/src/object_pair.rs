//! Two things next to each other with a gap of a given width.

use parry3d::bounding_volume::{Aabb, BoundingVolume as _};
use parry3d::math::Pose;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::named::named;

use super::fleet::TOWN;
use super::furniture_shape::{bin, sign};
use super::object_shape::ObjectShape;
use super::person_shape::{any_build, pedestrian};
use super::staged_scene::{StagedObject, on_the_road};
use super::world::sine_and_cosine;

named! {
    /// What stands next to each other.
    pub enum PairKind {
        /// Two cars, bumper to bumper.
        Cars = "cars",
        /// A car and a person, at its side or at one of its ends.
        CarAndPedestrian = "car-pedestrian",
        /// Two people.
        Pedestrians = "pedestrians",
        /// A car and a traffic sign.
        CarAndSign = "car-sign",
        /// A car and a bin.
        CarAndBin = "car-bin",
    }

    /// How a pair stands as the sensor sees it.
    pub enum PairLayout {
        /// Side by side: the sensor looks into the gap.
        Beside = "beside",
        /// One behind the other: the sensor looks across the gap.
        Behind = "behind",
    }
}

impl PairKind {
    fn shapes(self, rng: &mut ChaCha8Rng) -> [ObjectShape; 2] {
        let person = |rng: &mut ChaCha8Rng| pedestrian(&any_build(rng), 0.0);
        match self {
            Self::Cars => [TOWN.car(rng), TOWN.car(rng)],
            Self::CarAndPedestrian => [TOWN.car(rng), person(rng)],
            Self::Pedestrians => [person(rng), person(rng)],
            Self::CarAndSign => [TOWN.car(rng), sign(rng)],
            Self::CarAndBin => [TOWN.car(rng), bin(rng)],
        }
    }
}

/// A drawn pair whose gap can be made as wide as wanted.
#[derive(Debug, Clone)]
pub struct ObjectPair {
    // In a frame whose x axis runs through the gap: along the first object, then the second.
    shapes: [ObjectShape; 2],
    turned_rad: [f32; 2],
    aside_m: f32,
    // Angle from the line of sight to the x axis.
    heading_rad: f32,
}

/// How far the axis of a pair may be off from along, or from across, the line of sight, to either side, in radians.
const MOST_OBLIQUE_RAD: f32 = 0.35;

impl ObjectPair {
    /// Draws a pair.
    pub fn any(kind: PairKind, layout: PairLayout, rng: &mut ChaCha8Rng) -> Self {
        use std::f32::consts::{FRAC_PI_2, PI, TAU};
        let mut shapes = kind.shapes(rng);
        let either_way = |rng: &mut ChaCha8Rng| if rng.random_bool(0.5) { PI } else { 0.0 };
        let mut turned_rad = match kind {
            PairKind::Cars => [either_way(rng), either_way(rng)],
            PairKind::Pedestrians => [0, 1].map(|_| rng.random_range(0.0..TAU)),
            PairKind::CarAndPedestrian | PairKind::CarAndSign | PairKind::CarAndBin => {
                let side_on = if rng.random_bool(0.5) { FRAC_PI_2 } else { 0.0 };
                [either_way(rng) + side_on, rng.random_range(0.0..TAU)]
            }
        };
        let mut aside_m = rng.random_range(-0.15_f32..0.15);
        if rng.random_bool(0.5) {
            shapes.swap(0, 1);
            turned_rad.swap(0, 1);
            aside_m = -aside_m;
        }
        let oblique_rad = rng.random_range(-MOST_OBLIQUE_RAD..MOST_OBLIQUE_RAD);
        let heading_rad = match layout {
            PairLayout::Beside => FRAC_PI_2 + oblique_rad,
            PairLayout::Behind => oblique_rad,
        };
        Self { shapes, turned_rad, aside_m, heading_rad }
    }

    /// The pair with `gap_m` between the two, measured along the line through both, its nearest corner `range_m` from
    /// the sensor in the direction `bearing_rad`, counter-clockwise from forward.
    pub fn placed(&self, gap_m: f32, range_m: f32, bearing_rad: f32) -> [StagedObject; 2] {
        let bounds = [0, 1].map(|idx| bounds_of(&self.shapes[idx], self.turned_rad[idx]));
        let half_gap_m = gap_m / 2.0;
        let along_m = [-half_gap_m - bounds[0].maxs.x, half_gap_m - bounds[1].mins.x];
        let aside_m = [0.0, self.aside_m];
        let from_sight = unit(self.heading_rad);
        let in_sight = |idx: usize| {
            let pose = on_the_road(
                turned([along_m[idx], aside_m[idx]], from_sight),
                unit(self.heading_rad + self.turned_rad[idx]),
            );
            (pose, bounds_at(&self.shapes[idx], &pose))
        };
        let [(_, near), (_, far)] = [in_sight(0), in_sight(1)];
        let nearest_m = near.merged(&far).mins.x;
        let bearing = unit(bearing_rad);
        [0, 1].map(|idx| {
            let (pose, _) = in_sight(idx);
            let plan_m = turned([pose.translation.x - nearest_m + range_m, pose.translation.y], bearing);
            let heading = unit(bearing_rad + self.heading_rad + self.turned_rad[idx]);
            StagedObject { shape: self.shapes[idx].clone(), world_from_object: on_the_road(plan_m, heading) }
        })
    }
}

/// Draws a direction.
pub fn any_bearing_rad(rng: &mut impl Rng) -> f32 {
    rng.random_range(-std::f32::consts::PI..std::f32::consts::PI)
}

fn bounds_of(shape: &ObjectShape, turned_rad: f32) -> Aabb {
    bounds_at(shape, &on_the_road([0.0; 2], unit(turned_rad)))
}

fn bounds_at(shape: &ObjectShape, pose: &Pose) -> Aabb {
    let parts = shape.parts.iter().map(|part| part.solid.placed(pose).bounds());
    parts.fold(Aabb::new_invalid(), |all, it| all.merged(&it))
}

/// Sine and cosine.
fn unit(angle_rad: f32) -> [f32; 2] {
    sine_and_cosine(angle_rad.into()).into()
}

fn turned([x, y]: [f32; 2], [sine, cosine]: [f32; 2]) -> [f32; 2] {
    [cosine * x - sine * y, sine * x + cosine * y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn the_gap_is_as_wide_and_the_pair_as_far_as_said() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for kind in PairKind::ALL {
            for layout in PairLayout::ALL {
                for _ in 0..20 {
                    let pair = ObjectPair::any(kind, layout, &mut rng);
                    let (gap_m, range_m, bearing_rad) = (0.7, 12.0, any_bearing_rad(&mut rng));
                    let objects = pair.placed(gap_m, range_m, bearing_rad);
                    // Seen along the line through both, the gap is between the one's end and the other's beginning.
                    let from_world = on_the_road([0.0; 2], unit(bearing_rad + pair.heading_rad)).inverse();
                    let [one, other] = objects
                        .each_ref()
                        .map(|it| bounds_at(&it.shape, &(from_world * it.world_from_object)));
                    assert!((other.mins.x - one.maxs.x - gap_m).abs() < 1e-3, "{kind:?} {layout:?}");
                    let from_sight = on_the_road([0.0; 2], unit(bearing_rad)).inverse();
                    let seen = objects
                        .each_ref()
                        .map(|it| bounds_at(&it.shape, &(from_sight * it.world_from_object)));
                    let nearest_m = seen[0].mins.x.min(seen[1].mins.x);
                    assert!((nearest_m - range_m).abs() < 1e-3, "{nearest_m}");
                    let centers_m = seen.map(|it| it.center());
                    let apart =
                        [(centers_m[0].x - centers_m[1].x).abs(), (centers_m[0].y - centers_m[1].y).abs()];
                    assert_eq!(apart[0] > apart[1], layout == PairLayout::Behind, "{kind:?} {apart:?}");
                }
            }
        }
    }
}
