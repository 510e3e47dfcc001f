//! Labelled vehicles with the points around them, which labels are compared with.

use std::collections::BTreeSet;

use detector::{OrientedBox, PointCloud};
use reports::vocabulary::class::AnnotationClass;

use crate::annotation::{Annotation, LabeledScan};

/// Vehicles farther away are not looked at, in metres.
const MAX_RANGE_M: f32 = 40.0;
/// Points are taken this far beyond half the diagonal of a box, in metres.
const AROUND_M: f32 = 2.0;
/// Vehicles with fewer points are passed over.
const MIN_POINTS: usize = 20;
/// More points of a vehicle are not needed.
const ENOUGH_POINTS: usize = 200;
/// Sides of vehicles lie between these heights above the ground, in metres.
const SIDES_M: [f32; 2] = [0.3, 2.2];
/// One point in this many may lie below the ground.
const BELOW_GROUND: usize = 20;

/// A labelled vehicle with the points around it, in the sensor frame.
#[derive(Debug, Clone, PartialEq)]
pub struct SeenVehicle {
    /// Its index among all near vehicles.
    pub near_idx: usize,
    /// Its class.
    pub class: AnnotationClass,
    /// Its labelled box.
    pub bounding_box: OrientedBox,
    /// Some of the points around it, in metres.
    pub around_m: Vec<[f32; 3]>,
    /// Some of the points around it at the height of sides of vehicles, seen from above, in metres.
    pub sides_m: Vec<[f32; 2]>,
    /// Height of the ground around it, in metres.
    pub ground_z_m: f32,
}

/// Labelled vehicles near the sensor.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeenVehicles {
    /// Name of the object of each near vehicle, with or without points around it; the same for one object in several scans.
    pub objects: Vec<String>,
    /// The near vehicles with enough points around them.
    pub seen: Vec<SeenVehicle>,
}

impl SeenVehicles {
    /// The vehicles of `scans`, with their boxes `moved`.
    pub fn of(scans: &[LabeledScan], moved: impl Fn(&OrientedBox) -> OrientedBox) -> Self {
        let mut vehicles = Self::default();
        for scan in scans {
            vehicles.add(scan, &moved);
        }
        vehicles
    }

    /// Adds the vehicles of `scan`. `moved` changes each box first, to try a correction.
    pub fn add(&mut self, scan: &LabeledScan, moved: impl Fn(&OrientedBox) -> OrientedBox) {
        // A cloud without points says nothing about labels.
        if scan.cloud.is_empty() {
            return;
        }
        for annotation in &scan.annotations {
            let Some(bounding_box) = near_vehicle(annotation, &moved) else { continue };
            let near_idx = self.objects.len();
            self.objects.push(match annotation.track {
                Some(track) => format!("{} {track}", scan.id.sequence),
                None => format!("{} {near_idx}", scan.id),
            });
            let seen = SeenVehicle::of(&scan.cloud, annotation.class, bounding_box);
            self.seen.extend(seen.map(|it| SeenVehicle { near_idx, ..it }));
        }
    }

    /// One of the seen vehicles for each object.
    pub fn one_of_each(&self) -> Vec<&SeenVehicle> {
        let mut known = BTreeSet::new();
        self.seen.iter().filter(|it| known.insert(self.object(it))).collect()
    }

    /// Name of the object of `vehicle`, one of the seen ones.
    pub fn object(&self, vehicle: &SeenVehicle) -> &str {
        &self.objects[vehicle.near_idx]
    }
}

/// The box of `annotation`, `moved`, if it is a vehicle near the sensor.
fn near_vehicle(annotation: &Annotation, moved: impl Fn(&OrientedBox) -> OrientedBox) -> Option<OrientedBox> {
    let bounding_box =
        annotation.bounding_box.as_ref().filter(|_| is_vehicle(annotation.class)).map(moved)?;
    (bounding_box.range_m() <= MAX_RANGE_M).then_some(bounding_box)
}

/// Whether labels of this class are compared with points.
pub(super) fn is_vehicle(class: AnnotationClass) -> bool {
    use AnnotationClass as Class;
    matches!(class, Class::Car | Class::Van | Class::Truck | Class::Bus)
}

impl SeenVehicle {
    /// The vehicle with its points; `None` if there are too few.
    fn of(cloud: &PointCloud, class: AnnotationClass, bounding_box: OrientedBox) -> Option<Self> {
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        let [center_x_m, center_y_m, _] = bounding_box.center_m;
        let reach_m = length_m.hypot(width_m) / 2.0 + AROUND_M;
        let positions = cloud.x_m().iter().zip(cloud.y_m()).zip(cloud.z_m());
        let is_near = |x_m: f32, y_m: f32| {
            let [dx, dy] = [x_m - center_x_m, y_m - center_y_m];
            dx.abs() < reach_m && dx * dx + dy * dy < reach_m * reach_m
        };
        let near: Vec<[f32; 3]> = positions
            .filter(|((x_m, y_m), _)| is_near(**x_m, **y_m))
            .map(|((x_m, y_m), z_m)| [*x_m, *y_m, *z_m])
            .collect();
        if near.len() < MIN_POINTS {
            return None;
        }
        let mut heights_m: Vec<f32> = near.iter().map(|it| it[2]).collect();
        heights_m.sort_unstable_by(f32::total_cmp);
        let ground_z_m = heights_m[heights_m.len() / BELOW_GROUND];
        let is_of_side = |it: &&[f32; 3]| (SIDES_M[0]..SIDES_M[1]).contains(&(it[2] - ground_z_m));
        let sides_m: Vec<[f32; 2]> = near.iter().filter(is_of_side).map(|it| [it[0], it[1]]).collect();
        (sides_m.len() >= MIN_POINTS).then(|| Self {
            near_idx: 0,
            class,
            bounding_box,
            around_m: thinned(near),
            sides_m: thinned(sides_m),
            ground_z_m,
        })
    }
}

/// [`ENOUGH_POINTS`] of the points at most, spread over all.
fn thinned<T: Copy>(points: Vec<T>) -> Vec<T> {
    if points.len() <= ENOUGH_POINTS {
        return points;
    }
    (0..ENOUGH_POINTS).map(|it| points[it * points.len() / ENOUGH_POINTS]).collect()
}
