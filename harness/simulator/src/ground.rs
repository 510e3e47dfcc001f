//! Road, kerbs and pavement: a height field and where a ray meets it.

use parry3d::math::Vector;
use parry3d::query::Ray;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::road_axis::{RoadAxis, RoadPosition};
use super::scene::{GROUND_LEAF, chance};

/// The cross-section of a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossSection {
    /// Distance of the kerb to the left of the axis, in metres.
    pub left_kerb_m: f32,
    /// Distance of the kerb to the right of the axis, in metres.
    pub right_kerb_m: f32,
    /// How much the road falls per metre from its middle to the gutter.
    pub crown: f32,
    /// How high kerbs stand, in metres.
    pub kerb_height_m: f32,
}

/// How the land beside a road falls away, and with it a road that crosses there: evenly after a round beginning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Banks {
    /// Distance from the axis at which the land begins to fall, in metres.
    pub from_axis_m: f32,
    /// Fall per metre to the left and to the right.
    pub fall: [f32; 2],
}

/// A road with its axis and cross-section.
#[derive(Debug, Clone)]
pub struct Road {
    /// Its middle line.
    pub axis: RoadAxis,
    /// Its cross-section.
    pub section: CrossSection,
    /// The land beside it.
    pub banks: Banks,
}

/// The ground everywhere: roads, and raised ground beside them.
#[derive(Debug, Clone)]
pub struct Ground {
    /// The road that is driven along, and any that cross it. Their heights add up.
    pub roads: Vec<Road>,
    /// Where pavement ends and gardens begin, as metres beyond the kerb.
    pub pavement_width_m: f32,
    /// Radius of the kerb where two roads meet, in metres.
    pub corner_radius_m: f32,
}

/// Where a ray meets the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundHit {
    /// Distance in lengths of the ray's direction.
    pub range_m: f32,
    /// Unit normal.
    pub normal: Vector,
    /// Share of light that comes back.
    pub reflectivity: f32,
    /// How high blades of grass stand above the surface, in metres; 0 where none grow.
    pub grass_height_m: f32,
}

/// The surface at a position on the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Surface {
    Road { from_axis_m: f32 },
    Raised { from_kerb_m: f32, along_m: f32 },
}

/// How high grass stands, in metres.
const GRASS_HEIGHT_M: f32 = 0.06;
/// Length of the patches of grass on pavements along the road, in metres, and the share of patches that are grown over.
const PATCH_LENGTH_M: f32 = 5.0;
const GROWN_SHARE: f32 = 0.25;
/// Where the patches begin and end, as metres beyond the kerb, and how wide a pavement must be to have any.
const PATCH_FROM_KERB_M: std::ops::Range<f32> = 0.25..1.05;
const LEAST_PAVEMENT_WITH_GRASS_M: f32 = 2.8;

/// Over how many metres the land beside a road bends until it falls evenly.
const BEND_M: f32 = 4.0;

impl Banks {
    /// Level land.
    pub const LEVEL: Self = Self { from_axis_m: 0.0, fall: [0.0; 2] };

    /// Draws how the land falls beyond `from_axis_m`: to either side or to none, as steeply as streets do.
    pub fn any(from_axis_m: f32, rng: &mut ChaCha8Rng) -> Self {
        let mut fall = || if rng.random_bool(0.75) { rng.random_range(0.04..0.15) } else { 0.0 };
        Self { from_axis_m, fall: [fall(), fall()] }
    }

    /// How far the land has fallen `left_m` to the left of the axis, in metres.
    fn fall_m(&self, left_m: f32) -> f32 {
        let beyond_m = (left_m.abs() - self.from_axis_m).max(0.0);
        let fall = if left_m > 0.0 { self.fall[0] } else { self.fall[1] };
        let bent_m = beyond_m.min(BEND_M);
        fall * (bent_m * bent_m / (2.0 * BEND_M) + beyond_m - bent_m)
    }
}

const MARKING_REFLECTIVITY: f32 = 0.6;
const ASPHALT_REFLECTIVITY: f32 = 0.25;
const PAVING_REFLECTIVITY: f32 = 0.35;
const GRASS_REFLECTIVITY: f32 = 0.4;
const KERB_REFLECTIVITY: f32 = 0.35;

impl Ground {
    /// Height of the surface at x, y in metres.
    pub fn height_m(&self, plan: [f32; 2]) -> f32 {
        let (level, raised) = self.levels_m(plan);
        match self.surface(plan) {
            Surface::Road { .. } => level,
            Surface::Raised { .. } => raised,
        }
    }

    /// Unit normal of the road surface at x, y, without crown.
    pub fn normal(&self, plan: [f32; 2]) -> Vector {
        let step_m = 0.5;
        let slope = |dx: f32, dy: f32| {
            let ahead = self.slope_height_m([plan[0] + dx, plan[1] + dy]);
            let behind = self.slope_height_m([plan[0] - dx, plan[1] - dy]);
            (ahead - behind) / (2.0 * step_m)
        };
        Vector::new(-slope(step_m, 0.0), -slope(0.0, step_m), 1.0).normalize()
    }

    /// Where `ray`, coming from above the ground, meets it within `max_range_m`.
    pub fn cast(&self, ray: &Ray, max_range_m: f32) -> Option<GroundHit> {
        // The level of the road goes on below the raised ground, and the raised level above the road: both are smooth,
        // and a ray that comes down crosses the raised one first.
        let descent_per_m = self.descent_per_m(ray);
        if descent_per_m <= 1e-4 {
            return None;
        }
        let raised_m = self.descent(ray, descent_per_m, [0.0, max_range_m], Level::Raised)?;
        let at_raised = plan_at(ray, raised_m);
        if let Surface::Raised { from_kerb_m, along_m } = self.surface(at_raised) {
            let (reflectivity, grass_height_m) = if self.is_grown_over(from_kerb_m, along_m) {
                (GRASS_REFLECTIVITY, GRASS_HEIGHT_M)
            } else {
                (PAVING_REFLECTIVITY, 0.0)
            };
            let normal = self.normal(at_raised);
            return Some(GroundHit { range_m: raised_m, normal, reflectivity, grass_height_m });
        }
        let road_m = self.descent(ray, descent_per_m, [raised_m, f32::INFINITY], Level::Road)?;
        match self.surface(plan_at(ray, road_m)) {
            Surface::Road { from_axis_m } if road_m <= max_range_m => Some(GroundHit {
                range_m: road_m,
                normal: self.normal(plan_at(ray, road_m)),
                reflectivity: road_reflectivity(from_axis_m),
                grass_height_m: 0.0,
            }),
            Surface::Road { .. } => None,
            Surface::Raised { .. } => self.kerb_hit(ray, raised_m, road_m, max_range_m),
        }
    }

    /// Whether grass grows there: in gardens everywhere, on wide pavements in patches along the kerb.
    fn is_grown_over(&self, from_kerb_m: f32, along_m: f32) -> bool {
        if from_kerb_m >= self.pavement_width_m {
            return true;
        }
        let patch = (along_m / PATCH_LENGTH_M).floor() as i32 as u32;
        self.pavement_width_m > LEAST_PAVEMENT_WITH_GRASS_M
            && PATCH_FROM_KERB_M.contains(&from_kerb_m)
            && chance(patch, GROUND_LEAF) < GROWN_SHARE
    }

    fn slope_height_m(&self, plan: [f32; 2]) -> f32 {
        let heights = self.roads.iter().map(|road| {
            let position = road.axis.road_position(plan);
            road.axis.height_and_gradient(position.along_m).0 - road.banks.fall_m(position.left_m)
        });
        heights.sum()
    }

    /// Height of the road's level and of the raised level.
    fn levels_m(&self, plan: [f32; 2]) -> (f32, f32) {
        let mut slope_height_m = 0.0;
        let mut fall_m = f32::INFINITY;
        let mut kerb_height_m = 0.0;
        for road in &self.roads {
            let position = road.axis.road_position(plan);
            slope_height_m += road.axis.height_and_gradient(position.along_m).0;
            slope_height_m -= road.banks.fall_m(position.left_m);
            let half_m = road.section.left_kerb_m.min(road.section.right_kerb_m);
            fall_m = fall_m.min(position.left_m.abs().min(half_m) * road.section.crown);
            kerb_height_m = road.section.kerb_height_m;
        }
        let road_m = slope_height_m - fall_m;
        (road_m, road_m + kerb_height_m)
    }

    fn surface(&self, plan: [f32; 2]) -> Surface {
        let (mut from_kerb_m, mut nearest_along_m) = (f32::INFINITY, 0.0);
        for road in &self.roads {
            let RoadPosition { along_m, left_m } = road.axis.road_position(plan);
            let beyond_m = if left_m > 0.0 {
                left_m - road.section.left_kerb_m
            } else {
                -left_m - road.section.right_kerb_m
            };
            if beyond_m < 0.0 {
                return Surface::Road { from_axis_m: left_m };
            }
            // Where two roads meet, the kerb goes round the corner in an arc.
            if beyond_m.max(from_kerb_m) < self.corner_radius_m {
                let (dx, dy) = (self.corner_radius_m - beyond_m, self.corner_radius_m - from_kerb_m);
                let from_center_m = (dx * dx + dy * dy).sqrt();
                if from_center_m > self.corner_radius_m {
                    return Surface::Road { from_axis_m: f32::INFINITY };
                }
            }
            if beyond_m < from_kerb_m {
                (from_kerb_m, nearest_along_m) = (beyond_m, along_m);
            }
        }
        Surface::Raised { from_kerb_m, along_m: nearest_along_m }
    }

    /// Where the ray, above `level` at the first of the ranges, comes down to it before the second.
    fn descent(
        &self,
        ray: &Ray,
        descent_per_m: f32,
        [from_m, max_range_m]: [f32; 2],
        level: Level,
    ) -> Option<f32> {
        let clearance_m = |range_m: f32| {
            let (road_m, raised_m) = self.levels_m(plan_at(ray, range_m));
            let level_m = match level {
                Level::Road => road_m,
                Level::Raised => raised_m,
            };
            ray.origin.z + ray.dir.z * range_m - level_m
        };
        let mut last = (from_m, clearance_m(from_m));
        // The secant through two positions near the crossing: quick because the levels are nearly plane.
        let mut range_m = from_m + last.1 / descent_per_m;
        let farthest_m = max_range_m * 1.5 + 10.0;
        // Land falls away beside roads: a ray that does not reach the plane below in time does not reach the land at all.
        if range_m > farthest_m {
            return None;
        }
        for _ in 0..8 {
            if !(0.0..=farthest_m).contains(&range_m) {
                break;
            }
            let clearance = clearance_m(range_m);
            if clearance.abs() < 5e-4 {
                return (range_m <= max_range_m).then_some(range_m);
            }
            let secant = (last.1 - clearance) / (range_m - last.0);
            let step = clearance / if secant > 1e-4 { secant } else { descent_per_m };
            last = (range_m, clearance);
            range_m += step;
        }
        first_below_m(clearance_m, [from_m, max_range_m.min(LONGEST_MARCH_M)])
    }

    /// How fast the ray approaches the slope below its origin, in metres per length of its direction.
    fn descent_per_m(&self, ray: &Ray) -> f32 {
        let normal = self.normal([ray.origin.x, ray.origin.y]);
        -ray.dir.dot(normal) / normal.z
    }

    /// Where the ray meets the kerb: it is over the road at `road_side_m`, and below the raised level at `raised_side_m`.
    fn kerb_hit(
        &self,
        ray: &Ray,
        road_side_m: f32,
        raised_side_m: f32,
        max_range_m: f32,
    ) -> Option<GroundHit> {
        let (mut near_m, mut far_m) = (road_side_m, raised_side_m);
        for _ in 0..12 {
            let middle_m = f32::midpoint(near_m, far_m);
            match self.surface(plan_at(ray, middle_m)) {
                Surface::Road { .. } => near_m = middle_m,
                Surface::Raised { .. } => far_m = middle_m,
            }
        }
        // Kerbstones are worn round: some of each faces any ray.
        let normal = Vector::new(-ray.dir.x, -ray.dir.y, 0.0).normalize_or_zero();
        let hit = GroundHit { range_m: near_m, normal, reflectivity: KERB_REFLECTIVITY, grass_height_m: 0.0 };
        (near_m <= max_range_m).then_some(hit)
    }
}

fn road_reflectivity(from_axis_m: f32) -> f32 {
    if from_axis_m.abs() < 0.06 { MARKING_REFLECTIVITY } else { ASPHALT_REFLECTIVITY }
}

/// How far a ray is followed step by step where the secant finds nothing, in metres: farther than any sensor sees ground.
const LONGEST_MARCH_M: f32 = 200.0;
/// Length of such a step in metres.
const MARCH_STEP_M: f32 = 3.0;

/// Where `clearance_m` first falls below 0: step by step, for where the land falls nearly as steeply as the ray.
fn first_below_m(clearance_m: impl Fn(f32) -> f32, [from_m, to_m]: [f32; 2]) -> Option<f32> {
    let mut above_m = from_m;
    let mut below_m = loop {
        let next_m = (above_m + MARCH_STEP_M).min(to_m);
        if clearance_m(next_m) < 0.0 {
            break next_m;
        }
        if next_m >= to_m {
            return None;
        }
        above_m = next_m;
    };
    for _ in 0..16 {
        let middle_m = f32::midpoint(above_m, below_m);
        if clearance_m(middle_m) < 0.0 { below_m = middle_m } else { above_m = middle_m }
    }
    Some(below_m)
}

#[derive(Debug, Clone, Copy)]
enum Level {
    Road,
    Raised,
}

fn plan_at(ray: &Ray, range_m: f32) -> [f32; 2] {
    [ray.origin.x + ray.dir.x * range_m, ray.origin.y + ray.dir.y * range_m]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road_axis::{RoadAxisShape, Wave};
    use proptest::prelude::*;

    fn ground(gradient: f32) -> Ground {
        let axis = RoadAxis::new(&RoadAxisShape {
            bends: Wave { amplitude_m: 3.0, length_m: 300.0, phase: 0.1 },
            gradient,
            hills: Wave { amplitude_m: 0.5, length_m: 200.0, phase: 0.2 },
            ..RoadAxisShape::straight([-200.0, 200.0])
        });
        let section = CrossSection { left_kerb_m: 5.0, right_kerb_m: 7.0, crown: 0.02, kerb_height_m: 0.12 };
        let banks = Banks { from_axis_m: 11.0, fall: [0.05, 0.12] };
        Ground { roads: vec![Road { axis, section, banks }], pavement_width_m: 3.0, corner_radius_m: 0.0 }
    }

    proptest! {
        #[test]
        fn a_ray_ends_on_the_surface(
            gradient in -0.1_f32..0.1,
            azimuth_rad in -3.1_f32..3.1,
            fall in 0.03_f32..0.5,
        ) {
            let ground = ground(gradient);
            let origin = Vector::new(0.0, 0.0, ground.height_m([0.0, 0.0]) + 1.73);
            let level = Vector::new(azimuth_rad.cos(), azimuth_rad.sin(), 0.0);
            let slope = ground.normal([0.0, 0.0]);
            let along_slope = (level - slope * level.dot(slope)).normalize();
            let ray = Ray::new(origin, (along_slope - slope * fall).normalize());
            let above_m = |range_m: f32| {
                let position = ray.point_at(range_m);
                position.z - ground.height_m([position.x, position.y])
            };
            // Where the land falls more steeply than the ray, they never meet.
            let Some(hit) = ground.cast(&ray, 120.0) else {
                let is_above = (0..120).all(|range_m| above_m(range_m as f32) > -0.01);
                prop_assert!(is_above, "missed");
                return Ok(());
            };
            let above_m = above_m(hit.range_m);
            let on_kerb = (-0.002..0.122).contains(&above_m) && hit.reflectivity == KERB_REFLECTIVITY;
            prop_assert!(above_m.abs() < 0.002 || on_kerb, "{above_m} {hit:?}");
            prop_assert!(hit.normal.dot(ray.dir) < 0.0);
        }
    }

    #[test]
    fn pavement_stands_above_the_gutter_by_a_kerb() {
        let ground = ground(0.0);
        let left_of_axis = |left_m| {
            let position = crate::road_axis::RoadPosition { along_m: 10.0, left_m };
            ground.height_m(ground.roads[0].axis.world_plan(position).0)
        };
        assert!((left_of_axis(5.1) - left_of_axis(4.9) - 0.12).abs() < 0.01);
        assert!((left_of_axis(0.0) - left_of_axis(4.0) - 0.08).abs() < 0.01);
        assert!((left_of_axis(-7.1) - left_of_axis(-6.9) - 0.12).abs() < 0.01);
    }

    #[test]
    fn grass_grows_in_gardens_and_in_patches_on_pavements() {
        let ground = ground(0.0);
        let n_grown = |left_m: f32| {
            let grown = (-90..90).filter(|&along_m| {
                let position = RoadPosition { along_m: along_m as f32, left_m };
                let (plan, _) = ground.roads[0].axis.world_plan(position);
                let above = Vector::new(plan[0], plan[1], ground.height_m(plan) + 2.0);
                let hit = ground.cast(&Ray::new(above, -Vector::Z), 5.0).expect("the ray falls");
                hit.grass_height_m > 0.0
            });
            grown.count()
        };
        assert_eq!(n_grown(3.0), 0, "not on the road");
        assert_eq!(n_grown(7.0), 0, "not where people walk");
        assert_eq!(n_grown(9.0), 180, "all over gardens");
        assert!((15..90).contains(&n_grown(5.6)), "{} of 180 along the kerb", n_grown(5.6));
    }

    #[test]
    fn the_land_beside_the_road_falls_away() {
        let banks = Banks { from_axis_m: 10.0, fall: [0.1, 0.0] };
        let falls_m = [0.0, 10.0, 13.0, 16.0, 26.0, -26.0].map(|left_m| banks.fall_m(left_m));
        let expected_m = [0.0, 0.0, 0.1125, 0.4, 1.4, 0.0];
        assert!(falls_m.iter().zip(expected_m).all(|(a, b)| (a - b).abs() < 1e-5), "{falls_m:?}");
    }

    #[test]
    fn a_ray_upward_meets_no_ground() {
        let ray = Ray::new(Vector::new(0.0, 0.0, 5.0), Vector::new(0.9, 0.0, 0.3).normalize());
        assert_eq!(ground(0.0).cast(&ray, 120.0), None);
    }
}
