//! The line a road follows: gentle bends and gradients.

use std::ops::Range;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::portable_math;

/// A wave of the road about its straight line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Half of the distance between crest and trough, in metres.
    pub amplitude_m: f32,
    /// Distance from crest to crest in metres.
    pub length_m: f32,
    /// Where the wave begins, as a share of a wave.
    pub phase: f32,
}

/// Parameters of a [`RoadAxis`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadAxisShape {
    /// A point of the straight line, x and y in metres.
    pub origin_m: [f32; 2],
    /// Direction of the straight line, counter-clockwise from x, in radians.
    pub heading_rad: f32,
    /// From where to where the road goes along the straight line, in metres from the origin.
    pub reach_m: [f32; 2],
    /// How it swings to the left and right.
    pub bends: Wave,
    /// Metres of climb per metre.
    pub gradient: f32,
    /// How it rises and falls beside the gradient.
    pub hills: Wave,
}

/// The middle line of a road, tabulated so that it is cheap to follow.
#[derive(Debug, Clone)]
pub struct RoadAxis {
    origin: [f32; 2],
    /// Unit vector along the straight line.
    direction: [f32; 2],
    first_m: f32,
    offsets_m: Vec<f32>,
    heights_m: Vec<f32>,
}

impl RoadAxisShape {
    /// A level road along x that goes straight on.
    pub const fn straight(reach_m: [f32; 2]) -> Self {
        let (bends, hills) = (Wave::FLAT, Wave::FLAT);
        Self { origin_m: [0.0; 2], heading_rad: 0.0, reach_m, bends, gradient: 0.0, hills }
    }
}

const STEP_M: f32 = 1.0;

/// A position on the plan of a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadPosition {
    /// Metres along the road.
    pub along_m: f32,
    /// Metres to the left of its middle.
    pub left_m: f32,
}

impl RoadAxis {
    /// Tabulates a road.
    pub fn new(shape: &RoadAxisShape) -> Self {
        let (sine, cosine) = portable_math::sin_cos(f64::from(shape.heading_rad));
        let [first_m, last_m] = shape.reach_m;
        let n_steps = ((last_m - first_m) / STEP_M).ceil() as u32 + 1;
        let positions_m = || (0..=n_steps).map(|step| first_m + step as f32 * STEP_M);
        Self {
            origin: shape.origin_m,
            direction: [cosine as f32, sine as f32],
            first_m,
            offsets_m: positions_m().map(|along_m| shape.bends.height_at(along_m)).collect(),
            heights_m: positions_m()
                .map(|along_m| shape.gradient * along_m + shape.hills.height_at(along_m))
                .collect(),
        }
    }

    /// Where x, y lies with respect to the road.
    pub fn road_position(&self, [x, y]: [f32; 2]) -> RoadPosition {
        let (dx, dy) = (x - self.origin[0], y - self.origin[1]);
        let along_m = self.direction[0] * dx + self.direction[1] * dy;
        let across_m = self.direction[0] * dy - self.direction[1] * dx;
        let (offset_m, slope) = interpolated(&self.offsets_m, along_m - self.first_m);
        // Distance from a line that is tilted by `slope`.
        RoadPosition { along_m, left_m: (across_m - offset_m) / (1.0 + slope * slope).sqrt() }
    }

    /// Height of the axis and climb per metre at `along_m`.
    pub fn height_and_gradient(&self, along_m: f32) -> (f32, f32) {
        interpolated(&self.heights_m, along_m - self.first_m)
    }

    /// x, y of a position on the plan and the unit vector along the road there.
    pub fn world_plan(&self, position: RoadPosition) -> ([f32; 2], [f32; 2]) {
        let (offset_m, slope) = interpolated(&self.offsets_m, position.along_m - self.first_m);
        let unit = 1.0 / (1.0 + slope * slope).sqrt();
        let along_m = position.along_m - position.left_m * slope * unit;
        let across_m = offset_m + position.left_m * unit;
        let [dx, dy] = self.direction;
        let turned = |along: f32, across: f32| [dx * along - dy * across, dy * along + dx * across];
        let [x, y] = turned(along_m, across_m);
        ([x + self.origin[0], y + self.origin[1]], turned(unit, slope * unit))
    }
}

impl Wave {
    /// No wave at all.
    pub const FLAT: Self = Self { amplitude_m: 0.0, length_m: 1.0, phase: 0.0 };

    /// Draws a wave from these ranges of amplitude and length in metres.
    pub fn any(amplitude_m: Range<f32>, length_m: Range<f32>, rng: &mut ChaCha8Rng) -> Self {
        Self {
            amplitude_m: rng.random_range(amplitude_m),
            length_m: rng.random_range(length_m),
            phase: rng.random_range(0.0..1.0),
        }
    }

    fn height_at(&self, along_m: f32) -> f32 {
        let turns = f64::from(along_m) / f64::from(self.length_m) + f64::from(self.phase);
        self.amplitude_m * portable_math::sin_cos(turns * std::f64::consts::TAU).0 as f32
    }
}

/// Value and slope per metre of a table at `position_m` from its start; beyond the ends it goes on straight.
fn interpolated(table: &[f32], position_m: f32) -> (f32, f32) {
    let position = position_m / STEP_M;
    let step = (position.max(0.0) as usize).min(table.len() - 2);
    let rise = table[step + 1] - table[step];
    (table[step] + (position - step as f32) * rise, rise / STEP_M)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_position_on_the_plan_is_found_again(along_m in 0.0_f32..300.0, left_m in -20.0_f32..20.0) {
            let axis = RoadAxis::new(&RoadAxisShape {
                origin_m: [5.0, -3.0],
                heading_rad: 1.1,
                bends: Wave { amplitude_m: 5.0, length_m: 400.0, phase: 0.3 },
                gradient: 0.05,
                ..RoadAxisShape::straight([-100.0, 400.0])
            });
            let (plan, direction) = axis.world_plan(RoadPosition { along_m, left_m });
            let found = axis.road_position(plan);
            prop_assert!((found.left_m - left_m).abs() < 0.1, "{found:?}");
            prop_assert!((found.along_m - along_m).abs() < 2.5, "{found:?}");
            prop_assert!((direction[0].mul_add(direction[0], direction[1] * direction[1]) - 1.0).abs() < 1e-4);
        }
    }
}
