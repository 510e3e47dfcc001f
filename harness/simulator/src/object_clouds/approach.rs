//! Objects that a vehicle with a tilted 2-D scanner drives toward.
//!
//! The scanner looks ahead, and its plane is turned up or down about the axis to its left. A plane that rises by the angle t
//! meets a wall at the distance d at the height h + d·tan t. Turned down, it uncovers an object from below, and no part that
//! is higher than the scanner; turned up, from above, and no part that is lower. Each scan is placed by the poses, which
//! drift, and the scanner stands still while it turns.

use detector::PointCloud;
use parry3d::math::Pose;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use scans::object_cloud::growing_cloud::Moment;

use super::drawn_object::{ObjectNumber, StreamUse};
use super::lone_object::{LoneObject, Look, sensor_pose};
use super::planar_scanner::PlanarScanner;
use crate::portable_math;
use crate::scan::{beam_errors, gaussian};

/// How vehicles drive toward objects. `approach.toml` has the values and says what they mean.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ApproachParams {
    /// Least and greatest tilt, up or down, in degrees.
    pub tilt_deg: [f32; 2],
    /// Least and greatest height of the scanner, in metres.
    pub height_m: [f32; 2],
    /// Least and greatest speed, in metres a second.
    pub speed_m_per_s: [f32; 2],
    /// How far to the left the middle of the object is passed, in metres.
    pub aside_m: [f32; 2],
    /// Height of the vehicle, in metres.
    pub vehicle_height_m: f32,
    /// Distance from the obstacle in its way at which it stops, in metres.
    pub stop_m: [f32; 2],
    /// How long before the first strip the drive begins, in metres.
    pub lead_m: f32,
    /// The least share of the height of an object that a drive uncovers, if it can be.
    pub least_uncovered_share: f32,
    /// Error of a pose after a metre, in metres.
    pub position_drift_m: f32,
    /// Error of the heading after a metre, in degrees.
    pub heading_drift_deg: f32,
    /// Way between two moments, in metres.
    pub moment_step_m: f32,
}

/// One drive toward an object, along x; the middle of the object is at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// By how much the plane of the scanner is turned up, in degrees; negative if down.
    pub tilt_deg: f32,
    /// Height of the scanner, in metres.
    pub height_m: f32,
    /// Speed in metres a second.
    pub speed_m_per_s: f32,
    /// Where the course runs, to the left of the object's middle, in metres.
    pub aside_m: f32,
    /// Distance along the course to the middle of the object where the drive begins, in metres.
    pub from_m: f32,
    /// Distance along the course to the middle of the object where the drive ends, in metres.
    pub to_m: f32,
}

impl ApproachParams {
    /// The parameters that come with the program.
    pub fn shipped() -> Self {
        toml::from_str(include_str!("approach.toml")).expect("a test reads the values")
    }

    /// Draws a drive toward `object`.
    pub fn drive(&self, object: &LoneObject, scanner: &PlanarScanner, rng: &mut ChaCha8Rng) -> Drive {
        let mut drive = self.any_drive(object, scanner, rng);
        for _ in 1..MOST_DRAWS {
            if drive.uncovered_share(object, self) >= self.least_uncovered_share {
                break;
            }
            drive = self.any_drive(object, scanner, rng);
        }
        drive
    }

    fn any_drive(&self, object: &LoneObject, scanner: &PlanarScanner, rng: &mut ChaCha8Rng) -> Drive {
        let mut draw = |[least, greatest]: [f32; 2]| rng.random_range(least..greatest);
        let [tilt_deg, height_m, speed_m_per_s, aside_m, stop_m] =
            [self.tilt_deg, self.height_m, self.speed_m_per_s, self.aside_m, self.stop_m].map(&mut draw);
        let tilt_deg = if rng.random_bool(0.5) { tilt_deg } else { -tilt_deg };
        let slope = slope(tilt_deg);
        let first_strip_m = if slope > 0.0 {
            object.reach_backward_m(f32::INFINITY) + ((object.top_m() - height_m) / slope).max(0.0)
        } else {
            object.reach_backward_m(self.vehicle_height_m) + height_m / -slope
        };
        let to_m = object.reach_backward_m(self.vehicle_height_m) + stop_m;
        let from_m = (first_strip_m + self.lead_m).min(scanner.turning.max_range_m).max(to_m);
        Drive { tilt_deg, height_m, speed_m_per_s, aside_m, from_m, to_m }
    }
}

/// Number of drives that are drawn at most to find one that uncovers enough; if none does, the last one is taken.
const MOST_DRAWS: u32 = 200;

/// By how much a plane that is turned up by `tilt_deg` rises on a metre.
fn slope(tilt_deg: f32) -> f32 {
    let (sine, cosine) = portable_math::sin_cos(f64::from(tilt_deg).to_radians());
    (sine / cosine) as f32
}

/// The points of `object`, number `number`, as `drive` gathers them, in the order of its scans; a moment for each step of
/// the way on which it has been seen.
pub fn approached(
    object: &LoneObject,
    number: ObjectNumber,
    scanner: &PlanarScanner,
    drive: &Drive,
    params: &ApproachParams,
) -> (PointCloud, Vec<Moment>) {
    let errors = beam_errors(&scanner.turning, &mut number.random_stream(StreamUse::Beams));
    let mut drift = Drift::new(params, drive.step_m(scanner), number.random_stream(StreamUse::Drift));
    let (mut cloud, mut moments) = (PointCloud::default(), Vec::new());
    let mut judged_at_m = f32::INFINITY;
    for scan in 0..drive.n_scans(scanner) {
        let before_m = drive.from_m - scan as f32 * drive.step_m(scanner);
        let truly = Look::from(drive.pose(before_m, &PoseError::default()), &scanner.turning, &errors);
        let look = Look { registered: drive.pose(before_m, drift.next()), ..truly };
        let pulses = |beam| number.random_stream(StreamUse::Pulses { scan, beam });
        object.append_points(&look, |firing| scanner.sees(firing), pulses, &mut cloud);
        let is_last = scan + 1 == drive.n_scans(scanner);
        if !cloud.is_empty() && (is_last || judged_at_m - before_m >= params.moment_step_m) {
            judged_at_m = before_m;
            let time_s = f64::from(scan) / f64::from(scanner.turning.turns_per_second);
            let distance_m = (before_m * before_m + drive.aside_m * drive.aside_m).sqrt();
            moments.push(Moment { n_points: cloud.len(), time_s, distance_m: Some(distance_m) });
        }
    }
    (cloud, moments)
}

impl Drive {
    /// Way from scan to scan, in metres.
    fn step_m(&self, scanner: &PlanarScanner) -> f32 {
        self.speed_m_per_s / scanner.turning.turns_per_second
    }

    /// The share of the height of `object` that the plane passes on the way, where the object is in the way of the vehicle.
    fn uncovered_share(&self, object: &LoneObject, params: &ApproachParams) -> f32 {
        let near_m = object.reach_backward_m(params.vehicle_height_m);
        let passed_m = [self.from_m, self.to_m].map(|before_m| {
            let height_m = self.height_m + slope(self.tilt_deg) * (before_m - near_m);
            height_m.clamp(0.0, object.top_m())
        });
        (passed_m[0] - passed_m[1]).abs() / object.top_m().max(0.01)
    }

    /// How often `scanner` turns on the way.
    pub fn n_scans(&self, scanner: &PlanarScanner) -> u32 {
        ((self.from_m - self.to_m) / self.step_m(scanner)) as u32 + 1
    }

    /// Pose of the scanner `before_m` before the middle of the object, or with `error` the pose that is reported.
    fn pose(&self, before_m: f32, error: &PoseError) -> Pose {
        let plan_m = [error.along_m - before_m, self.aside_m + error.aside_m];
        let tilt_rad = f64::from(self.tilt_deg).to_radians();
        sensor_pose(plan_m, self.height_m, f64::from(error.heading_deg).to_radians(), tilt_rad)
    }
}

/// Error of a pose.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct PoseError {
    along_m: f32,
    aside_m: f32,
    heading_deg: f32,
}

/// The errors of one pose after another: a random walk that begins without error.
struct Drift {
    error: PoseError,
    position_sigma_m: f32,
    heading_sigma_deg: f32,
    rng: ChaCha8Rng,
}

impl Drift {
    fn new(params: &ApproachParams, step_m: f32, rng: ChaCha8Rng) -> Self {
        let root = step_m.sqrt();
        Self {
            error: PoseError::default(),
            position_sigma_m: params.position_drift_m * root,
            heading_sigma_deg: params.heading_drift_deg * root,
            rng,
        }
    }

    fn next(&mut self) -> &PoseError {
        self.error.along_m += gaussian(&mut self.rng) * self.position_sigma_m;
        self.error.aside_m += gaussian(&mut self.rng) * self.position_sigma_m;
        self.error.heading_deg += gaussian(&mut self.rng) * self.heading_sigma_deg;
        &self.error
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use crate::object_clouds::drawn_object::DrawnObject;
    use crate::object_shape::ObjectShape;
    use crate::solid::Solid;
    use reports::vocabulary::class::AnnotationClass;
    use reports::vocabulary::partial_class::PartialClass;

    const WALL: ObjectNumber = ObjectNumber { seed: 1, class: PartialClass::Other, number: 0 };

    /// A wall across the course, 4 m high and thick as a sheet; its near face is at x = 0.
    fn wall() -> LoneObject {
        let solid = Solid::cuboid([0.0, -3.0, 0.0], [0.01, 3.0, 4.0]);
        let shape = ObjectShape::new(AnnotationClass::Misc, [(solid, Material::MASONRY)]);
        LoneObject::new(&DrawnObject { shape, yaw_rad: 0.0 })
    }

    fn exact() -> (PlanarScanner, ApproachParams) {
        let mut scanner = PlanarScanner::embedded();
        scanner.turning.range_noise_sigma_m = 0.0;
        scanner.turning.beam_range_error_sigma_m = 0.0;
        let params =
            ApproachParams { position_drift_m: 0.0, heading_drift_deg: 0.0, ..ApproachParams::shipped() };
        (scanner, params)
    }

    fn drive(tilt_deg: f32, height_m: f32) -> Drive {
        Drive { tilt_deg, height_m, speed_m_per_s: 2.0, aside_m: 0.0, from_m: 9.0, to_m: 2.0 }
    }

    /// A wall at the distance d is hit at h + d·tan t, from scan to scan nearer.
    #[track_caller]
    fn check_wall(tilt_deg: f32, height_m: f32, expected_least_and_greatest_m: [f32; 2]) {
        let (scanner, params) = exact();
        let drive = drive(tilt_deg, height_m);
        let (cloud, moments) = approached(&wall(), WALL, &scanner, &drive, &params);
        let slope = tilt_deg.to_radians().tan();
        let step_m = 2.0 / 25.0;
        for [x_m, y_m, z_m] in cloud.positions_m() {
            assert!(x_m.abs() < 0.002 && y_m.abs() < 3.001, "{x_m} {y_m}");
            let distance_m = (z_m - height_m) / slope;
            let scan = (9.0 - distance_m) / step_m;
            assert!((scan - scan.round()).abs() < 0.05, "seen {distance_m} m away");
        }
        let least_m = cloud.z_m().iter().copied().fold(f32::INFINITY, f32::min);
        let greatest_m = cloud.z_m().iter().copied().fold(0.0, f32::max);
        let [expected_least_m, expected_greatest_m] = expected_least_and_greatest_m;
        assert!((least_m - expected_least_m).abs() < 0.05, "{least_m}");
        assert!((greatest_m - expected_greatest_m).abs() < 0.05, "{greatest_m}");
        assert_eq!(moments.last().map(|it| it.n_points), Some(cloud.len()));
        assert!(moments.is_sorted_by(|a, b| a.n_points < b.n_points && a.time_s < b.time_s));
        let distances_m: Vec<f32> = moments.iter().filter_map(|it| it.distance_m).collect();
        assert!(distances_m.is_sorted_by(|a, b| a > b), "{distances_m:?}");
    }

    #[test]
    fn a_plane_turned_up_uncovers_a_wall_from_above() {
        // tan 20° is 0.364: from 9 m on it is 0.5 + 3.28 m high, at 2 m still 0.5 + 0.73 m.
        check_wall(20.0, 0.5, [1.23, 3.78]);
    }

    #[test]
    fn a_plane_turned_down_uncovers_a_wall_from_below() {
        // tan 10° is 0.176: it meets the road before the wall until 8.5 m, and at 2 m is 1.5 − 0.35 m high.
        check_wall(-10.0, 1.5, [0.0, 1.15]);
    }

    #[test]
    fn poses_that_drift_smear_a_wall_more_and_more() {
        let (scanner, params) = exact();
        let params = ApproachParams { position_drift_m: 0.05, ..params };
        let mut spreads_m = [0.0_f64; 2];
        let n_drives: u32 = 40;
        for number in 0..n_drives {
            let object = ObjectNumber { number, ..WALL };
            let (cloud, moments) = approached(&wall(), object, &scanner, &drive(20.0, 0.5), &params);
            for (spread_m, n) in spreads_m.iter_mut().zip([moments[4].n_points, cloud.len()]) {
                let x_m = f64::from(cloud.x_m()[n - 1]);
                *spread_m += x_m * x_m / f64::from(n_drives);
            }
        }
        // After the way d the error has the variance d·σ²: 1 m, then 7 m.
        let [early_m, late_m] = spreads_m.map(f64::sqrt);
        assert!((late_m / (0.05 * 7.0_f64.sqrt()) - 1.0).abs() < 0.35, "{late_m}");
        assert!((early_m / 0.05 - 1.0).abs() < 0.5, "{early_m}");
    }

    #[test]
    fn drives_are_as_the_parameters_say() {
        let (scanner, params) = (PlanarScanner::embedded(), ApproachParams::shipped());
        let (mut n_up, mut n_tall, mut n_half) = (0, 0, 0);
        for number in 0..200 {
            let object = ObjectNumber { seed: 5, class: PartialClass::Tree, number };
            let lone = LoneObject::new(&object.draw());
            let drive = params.drive(&lone, &scanner, &mut object.random_stream(StreamUse::Viewpoint));
            assert!((5.0..40.0).contains(&drive.tilt_deg.abs()) && (0.2..2.0).contains(&drive.height_m));
            assert!((0.5..3.0).contains(&drive.speed_m_per_s) && drive.aside_m.abs() < 0.8);
            assert!(drive.from_m >= drive.to_m && drive.to_m >= lone.reach_backward_m(2.0) + 0.99);
            assert!(drive.from_m <= scanner.turning.max_range_m.max(drive.to_m));
            // A scanner that looks down does not uncover half of a tall tree.
            n_tall += u32::from(lone.top_m() > 4.0);
            n_up += u32::from(drive.tilt_deg > 0.0);
            n_half += u32::from(drive.uncovered_share(&lone, &params) >= 0.5);
        }
        assert!(
            n_half > 195 && n_tall <= n_up,
            "{n_half} of 200 uncover half; {n_tall} are tall, {n_up} look up"
        );
    }
}
