//! An object alone on a level road, and what a sensor sees of it.

use std::f64::consts::TAU;

use detector::PointCloud;
use parry3d::bounding_volume::Aabb;
use parry3d::math::{Pose, Vector};
use parry3d::query::Ray;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::drawn_object::DrawnObject;
use crate::angular_window::AngularWindow;
use crate::ground::Ground;
use crate::material::Passage;
use crate::portable_math;
use crate::pulse_path::Surroundings;
use crate::scan::{BeamError, part_of_turn};
use crate::scene::{Hit, Leaf, LeafForm, Pulse, Scene};
use crate::sensor::SensorModel;
use crate::staged_scene::{level_road, on_the_road};
use crate::world::{rotation_from_axes, sine_and_cosine};

/// An object on a level road. The world's origin lies on the road below the middle of the object.
#[derive(Debug, Clone)]
pub struct LoneObject {
    ground: Ground,
    standing: Scene,
    moving: Scene,
    // Around its parts.
    boxes: Vec<Aabb>,
    /// Its length, width and height in metres.
    pub extents_m: [f32; 3],
}

/// A sensor and the pose from which it looks at an object.
#[derive(Debug, Clone, Copy)]
pub struct Look<'a> {
    /// The sensor.
    pub sensor: &'a SensorModel,
    /// The errors of its beams.
    pub errors: &'a [BeamError],
    /// Its pose.
    pub world_from_sensor: Pose,
    /// Its reported pose, by which the points are placed.
    pub registered: Pose,
}

impl<'a> Look<'a> {
    /// A look from a pose that is known without error.
    pub fn from(world_from_sensor: Pose, sensor: &'a SensorModel, errors: &'a [BeamError]) -> Self {
        Self { sensor, errors, world_from_sensor, registered: world_from_sensor }
    }
}

impl LoneObject {
    /// Puts `object` on the road.
    pub fn new(object: &DrawnObject) -> Self {
        let world_from_object = on_the_road([0.0; 2], sine_and_cosine(object.yaw_rad.into()).into());
        let (mut boxes, mut leaves) = (Vec::new(), Vec::new());
        for part in &object.shape.parts {
            let solid = part.solid.placed(&world_from_object);
            boxes.push(solid.bounds());
            leaves.push(Leaf { form: LeafForm::Solid(solid), material: part.material, object_idx: Some(0) });
        }
        Self {
            ground: level_road(),
            boxes,
            standing: Scene::new(leaves),
            moving: Scene::new(Vec::new()),
            extents_m: object.shape.bounds().extents().into(),
        }
    }

    /// The longest way from its middle to its outline, on the ground plan, in metres.
    pub fn reach_m(&self) -> f32 {
        let reaches_m = self.corners().map(|it| (it.x * it.x + it.y * it.y).sqrt());
        reaches_m.fold(0.0, f32::max)
    }

    /// How far its parts below `height_m` reach from its middle toward −x, in metres.
    pub fn reach_backward_m(&self, height_m: f32) -> f32 {
        let low = self.boxes.iter().filter(|it| it.mins.z < height_m);
        low.map(|it| -it.mins.x).fold(0.0, f32::max)
    }

    /// Height of its top above the road, in metres.
    pub fn top_m(&self) -> f32 {
        self.boxes.iter().map(|it| it.maxs.z).fold(0.0, f32::max)
    }

    /// Corners of the boxes around its parts.
    fn corners(&self) -> impl Iterator<Item = Vector> + Clone {
        self.boxes.iter().flat_map(Aabb::vertices)
    }

    /// Where `pulse`, coming from above the road, meets it.
    pub fn met_by(&self, pulse: &Pulse) -> Option<Hit> {
        self.standing.cast(pulse, f32::INFINITY)
    }

    /// Whether `ray` begins among its leaves, or behind pales or mesh.
    pub fn is_among_leaves(&self, ray: &Ray) -> bool {
        self.standing.leaves().iter().any(|leaf| {
            let LeafForm::Solid(solid) = &leaf.form else { return false };
            let is_open = matches!(leaf.material.passage, Passage::FreePath(_));
            is_open && solid.crossing(ray).is_some_and(|it| it.enter < 0.0)
        })
    }

    /// Appends to `cloud` the points of the object in one turn of the sensor, which sends only the firings that `is_sent`
    /// accepts. Left out are points of the road, and those in the air between an edge and the surface behind it. `pulses`
    /// gives the random stream of each beam.
    pub fn append_points(
        &self,
        look: &Look<'_>,
        is_sent: impl Fn(usize) -> bool,
        pulses: impl Fn(u32) -> ChaCha8Rng,
        cloud: &mut PointCloud,
    ) {
        let sensor_from_world = look.world_from_sensor.inverse();
        let window = AngularWindow::around(self.corners().map(|it| sensor_from_world * it));
        let n_firings = look.sensor.n_firings_per_turn as usize;
        let firings = |rise| {
            let n_met = if window.may_meet(rise) { n_firings } else { 0 };
            window.firings(n_firings).take(n_met).filter(|firing| is_sent(*firing))
        };
        let surroundings = Surroundings {
            ground: &self.ground,
            standing: &self.standing,
            moving: &self.moving,
            world_from_sensor: look.world_from_sensor,
            rain: None,
        };
        let turn = part_of_turn(look.sensor, look.errors, &[surroundings], firings, pulses);
        let points = turn.cloud.positions_m().zip(turn.cloud.intensity()).zip(&turn.objects);
        for ((position_m, intensity), _) in points.filter(|(_, object)| object.is_some()) {
            cloud.push((look.registered * Vector::from(position_m)).into(), *intensity);
        }
    }
}

/// The pose of a level `sensor` at `distance_m` in the direction `bearing_rad`. It does not look straight at the object,
/// since a thin trunk would stand between the same two pulses from everywhere.
pub fn level_pose(bearing_rad: f64, distance_m: f32, sensor: &SensorModel, rng: &mut ChaCha8Rng) -> Pose {
    let heading_rad = bearing_rad + rng.random_range(0.0..TAU);
    let (sine, cosine) = sine_and_cosine(bearing_rad);
    let plan_m = [cosine * distance_m, sine * distance_m];
    sensor_pose(plan_m, sensor.height_above_road_m, heading_rad, 0.0)
}

/// The pose of a sensor `height_m` above the road at `plan_m`, which looks along `heading_rad`, counter-clockwise from x,
/// and is turned up by `tilt_rad`.
pub fn sensor_pose(plan_m: [f32; 2], height_m: f32, heading_rad: f64, tilt_rad: f64) -> Pose {
    let (sine, cosine) = portable_math::sin_cos(heading_rad);
    let (rise, level) = portable_math::sin_cos(tilt_rad);
    let axis = |x: f64, y: f64, z: f64| Vector::from([x, y, z].map(|it| it as f32));
    let ahead = axis(level * cosine, level * sine, rise);
    let left = axis(-sine, cosine, 0.0);
    let up = axis(-rise * cosine, -rise * sine, level);
    let rotation = rotation_from_axes(ahead, left, up);
    Pose::from_parts(Vector::new(plan_m[0], plan_m[1], height_m), rotation)
}
