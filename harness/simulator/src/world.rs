//! Everything that is in a street, standing or moving, and the drive through it.

use std::borrow::Cow;

use parry3d::math::{Pose, Rotation, Vector};

use super::fleet::Fleet;
use super::ground::Ground;
use super::material::Material;
use super::object_shape::ObjectShape;
use super::person_shape::{self, Build};
use super::portable_math;
use super::road_axis::RoadPosition;
use super::scene::{Leaf, LeafForm};
use super::solid::Solid;

/// A street with all that is in it.
#[derive(Debug, Clone)]
pub struct World {
    /// Roads and pavement.
    pub ground: Ground,
    /// Things that are no objects: houses.
    pub walls: Vec<Leaf>,
    /// The free-standing objects; the index is the track.
    pub objects: Vec<StreetObject>,
    /// The drive of the car with the sensor.
    pub ego: Course,
    /// When the drive ends, in seconds from its start.
    pub drive_duration_s: f32,
    /// The vehicles that are put into it, and their shares.
    pub fleet: &'static Fleet,
}

/// A free-standing object.
#[derive(Debug, Clone)]
pub struct StreetObject {
    /// Its form.
    pub body: Body,
    /// Where it is and goes.
    pub motion: Motion,
}

/// The form of an object, which may change as it moves.
#[derive(Debug, Clone)]
pub enum Body {
    /// It keeps its form.
    Rigid(ObjectShape),
    /// It walks.
    Walker(Build),
    /// It rides a bicycle.
    Rider(Build),
}

/// Where an object is and goes.
#[derive(Debug, Clone)]
pub enum Motion {
    /// It stays at this position, world from object.
    Standing(Pose),
    /// It follows a road.
    Following(Course),
}

/// A turn to the right into a road that crosses at a right angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RightTurn {
    /// Where on the road it begins, in metres along it.
    pub from_m: f32,
    /// Radius of the quarter of a circle, in metres.
    pub radius_m: f32,
}

/// An even course along a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// Which road.
    pub road_idx: usize,
    /// Where on the road it starts.
    pub start: RoadPosition,
    /// Speed along the road, negative against it, in metres per second.
    pub speed_m_per_s: f32,
    /// Where on the road it appears and disappears, in metres along it; after a turn, as if it had gone straight on.
    pub reach_m: [f32; 2],
    /// Where it turns off, if it does. Its position is still given along the road that it left.
    pub right_turn: Option<RightTurn>,
    /// Whether it leans with the ground.
    pub stance: Stance,
}

/// How a thing stands on sloping ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stance {
    /// Upright, as posts and people.
    Upright,
    /// At right angles to the slope, as vehicles.
    OnSlope,
}

/// A position on a road and the way something faces there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Which road.
    pub road_idx: usize,
    /// Where on it.
    pub position: RoadPosition,
    /// Heading relative to the road, counter-clockwise, in radians.
    pub turned_rad: f32,
    /// How it stands.
    pub stance: Stance,
}

impl World {
    /// An empty street, to be filled with vehicles of `fleet`.
    pub fn new(ground: Ground, ego: Course, drive_duration_s: f32, fleet: &'static Fleet) -> Self {
        Self { ground, walls: Vec::new(), objects: Vec::new(), ego, drive_duration_s, fleet }
    }

    /// Puts a standing object into the street.
    pub fn stand(&mut self, shape: ObjectShape, placement: &Placement) {
        let pose = world_from_placement(&self.ground, placement);
        self.objects.push(StreetObject { body: Body::Rigid(shape), motion: Motion::Standing(pose) });
    }

    /// Builds things that are no objects: solids in `frame`.
    pub fn build(&mut self, frame: &Pose, solids: impl Iterator<Item = Solid>, material: Material) {
        let leaf = |it: Solid| Leaf { form: LeafForm::Solid(it.placed(frame)), material, object_idx: None };
        self.walls.extend(solids.map(leaf));
    }

    /// Puts a moving object into the street.
    pub fn follow(&mut self, body: Body, course: Course) {
        self.objects.push(StreetObject { body, motion: Motion::Following(course) });
    }
}

impl StreetObject {
    /// Its form at `time_s` from the start of the drive.
    pub fn shape_at(&self, time_s: f32) -> Cow<'_, ObjectShape> {
        match &self.body {
            Body::Rigid(shape) => Cow::Borrowed(shape),
            Body::Walker(build) => Cow::Owned(person_shape::pedestrian(build, self.travelled_m(time_s))),
            Body::Rider(build) => Cow::Owned(person_shape::cyclist(build, self.travelled_m(time_s))),
        }
    }

    /// Its position at `time_s`, world from object; `None` while it is not in the street.
    pub fn world_from_object(&self, ground: &Ground, time_s: f32) -> Option<Pose> {
        match &self.motion {
            Motion::Standing(pose) => Some(*pose),
            Motion::Following(course) => {
                course.placement_at(time_s).map(|it| world_from_placement(ground, &it))
            }
        }
    }

    fn travelled_m(&self, time_s: f32) -> f32 {
        match &self.motion {
            Motion::Standing(_) => 0.0,
            Motion::Following(course) => course.speed_m_per_s.abs() * time_s,
        }
    }
}

impl Course {
    /// The course of a vehicle straight on along road number `road_idx`.
    pub fn along(road_idx: usize, start: RoadPosition, speed_m_per_s: f32, reach_m: [f32; 2]) -> Self {
        Self { road_idx, start, speed_m_per_s, reach_m, right_turn: None, stance: Stance::OnSlope }
    }

    /// The position at `time_s` from the start of the drive; `None` beyond the reach.
    pub fn placement_at(&self, time_s: f32) -> Option<Placement> {
        let along_m = self.start.along_m + self.speed_m_per_s * time_s;
        let turned_rad = if self.speed_m_per_s < 0.0 { std::f32::consts::PI } else { 0.0 };
        let straight_on = (self.reach_m[0]..=self.reach_m[1]).contains(&along_m).then_some(Placement {
            road_idx: self.road_idx,
            position: RoadPosition { along_m, left_m: self.start.left_m },
            turned_rad,
            stance: self.stance,
        })?;
        Some(self.right_turn.map_or(straight_on, |turn| self.turned_off(straight_on, turn)))
    }

    /// Where it is with `turn`, if it would be at `straight_on` without; before the turn the two are equal.
    fn turned_off(&self, straight_on: Placement, turn: RightTurn) -> Placement {
        let direction = self.speed_m_per_s.signum();
        let past_m = direction * (straight_on.position.along_m - turn.from_m);
        if past_m <= 0.0 {
            return straight_on;
        }
        let angle_rad = (past_m / turn.radius_m).min(std::f32::consts::FRAC_PI_2);
        let (sine, cosine) = sine_and_cosine(angle_rad.into());
        let after_m = past_m - angle_rad * turn.radius_m;
        let ahead_m = turn.radius_m * sine;
        let aside_m = turn.radius_m * (1.0 - cosine) + after_m;
        let position = RoadPosition {
            along_m: turn.from_m + direction * ahead_m,
            left_m: straight_on.position.left_m - direction * aside_m,
        };
        Placement { position, turned_rad: straight_on.turned_rad - angle_rad, ..straight_on }
    }
}

/// The frame that stands at `placement`: x ahead, y to the left, z up, the origin on the ground.
pub fn world_from_placement(ground: &Ground, placement: &Placement) -> Pose {
    let (plan, [along_x, along_y]) = ground.roads[placement.road_idx].axis.world_plan(placement.position);
    let (sine, cosine) = sine_and_cosine(placement.turned_rad.into());
    let ahead = Vector::new(cosine * along_x - sine * along_y, sine * along_x + cosine * along_y, 0.0);
    let up = match placement.stance {
        Stance::Upright => Vector::Z,
        Stance::OnSlope => ground.normal(plan),
    };
    let left = up.cross(ahead).normalize();
    let position = Vector::new(plan[0], plan[1], ground.height_m(plan));
    Pose::from_parts(position, rotation_from_axes(left.cross(up), left, up))
}

/// Sine and cosine in the precision of positions.
pub fn sine_and_cosine(angle_rad: f64) -> (f32, f32) {
    let (sine, cosine) = portable_math::sin_cos(angle_rad);
    (sine as f32, cosine as f32)
}

/// The rotation whose x, y and z axes are these unit vectors.
pub fn rotation_from_axes(x: Vector, y: Vector, z: Vector) -> Rotation {
    Rotation::from_mat3(&parry3d::math::Matrix::from_cols(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a car is that turns right at 20 m along the road, with a radius of 8 m, and its heading.
    #[track_caller]
    fn check(speed_m_per_s: f32, time_s: f32, expected: [f32; 3]) {
        let start = RoadPosition { along_m: if speed_m_per_s > 0.0 { 10.0 } else { 30.0 }, left_m: -2.0 };
        let right_turn = Some(RightTurn { from_m: 20.0, radius_m: 8.0 });
        let course = Course { right_turn, ..Course::along(0, start, speed_m_per_s, [0.0, 100.0]) };
        let Placement { position, turned_rad, .. } = course.placement_at(time_s).unwrap();
        let found = [position.along_m, position.left_m, turned_rad];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?}");
    }

    #[test]
    fn a_car_turns_off_to_its_right() {
        use std::f32::consts::{FRAC_PI_2, PI};
        check(10.0, 1.0, [20.0, -2.0, 0.0]);
        let quarter_s = 0.8 * FRAC_PI_2;
        check(10.0, 1.0 + quarter_s, [28.0, -10.0, -FRAC_PI_2]);
        check(10.0, 2.0 + quarter_s, [28.0, -20.0, -FRAC_PI_2]);
        // Against the axis, right is where left is positive.
        check(-10.0, 0.5, [25.0, -2.0, PI]);
        check(-10.0, 1.0 + quarter_s, [12.0, 6.0, FRAC_PI_2]);
    }
}
