//! Everything that is in a street, standing or moving, and the drive through it.

use std::borrow::Cow;

use parry3d::math::{Pose, Rotation, Vector};

use super::ground::Ground;
use super::object_shape::ObjectShape;
use super::person_shape::{self, Build};
use super::portable_math;
use super::road_axis::RoadPosition;
use super::scene::Leaf;

/// A street with all that is in it.
#[derive(Debug, Clone)]
pub struct World {
    /// Roads and pavement.
    pub ground: Ground,
    /// What is no object: houses.
    pub walls: Vec<Leaf>,
    /// The free-standing objects; the index is the track.
    pub objects: Vec<StreetObject>,
    /// The drive of the car with the sensor.
    pub ego: Course,
    /// When the drive ends, in seconds from its start.
    pub drive_duration_s: f32,
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
    /// It stays at this place, world from object.
    Standing(Pose),
    /// It follows a road.
    Following(Course),
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
    /// Where on the road it appears and disappears, in metres along it.
    pub reach_m: [f32; 2],
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

/// A place on a road and the way something faces there.
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
    /// An empty street.
    pub fn new(ground: Ground, ego: Course, drive_duration_s: f32) -> Self {
        Self { ground, walls: Vec::new(), objects: Vec::new(), ego, drive_duration_s }
    }

    /// Puts a standing object into the street.
    pub fn stand(&mut self, shape: ObjectShape, placement: &Placement) {
        let pose = world_from_placement(&self.ground, placement);
        self.objects.push(StreetObject { body: Body::Rigid(shape), motion: Motion::Standing(pose) });
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

    /// Its place at `time_s`, world from object; `None` while it is not in the street.
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
    /// The place at `time_s` from the start of the drive; `None` beyond the reach.
    pub fn placement_at(&self, time_s: f32) -> Option<Placement> {
        let along_m = self.start.along_m + self.speed_m_per_s * time_s;
        let turned_rad = if self.speed_m_per_s < 0.0 { std::f32::consts::PI } else { 0.0 };
        (self.reach_m[0]..=self.reach_m[1]).contains(&along_m).then_some(Placement {
            road_idx: self.road_idx,
            position: RoadPosition { along_m, left_m: self.start.left_m },
            turned_rad,
            stance: self.stance,
        })
    }
}

/// The frame that stands at `placement`: x ahead, y to the left, z up, the origin on the ground.
pub fn world_from_placement(ground: &Ground, placement: &Placement) -> Pose {
    let (plan, [along_x, along_y]) = ground.roads[placement.road_idx].axis.world_plan(placement.position);
    let (sine, cosine) = portable_math::sin_cos(f64::from(placement.turned_rad));
    let (sine, cosine) = (sine as f32, cosine as f32);
    let ahead = Vector::new(cosine * along_x - sine * along_y, sine * along_x + cosine * along_y, 0.0);
    let up = match placement.stance {
        Stance::Upright => Vector::Z,
        Stance::OnSlope => ground.normal(plan),
    };
    let left = up.cross(ahead).normalize();
    let position = Vector::new(plan[0], plan[1], ground.height_m(plan));
    Pose::from_parts(position, rotation_from_axes(left.cross(up), left, up))
}

/// The rotation whose x, y and z axes are these unit vectors.
pub fn rotation_from_axes(x: Vector, y: Vector, z: Vector) -> Rotation {
    Rotation::from_mat3(&parry3d::math::Matrix::from_cols(x, y, z))
}
