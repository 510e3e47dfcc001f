//! The ground in the frame of a scan, and so how high and how tilted the sensor is.

use std::collections::BTreeMap;

use detector::PointCloud;
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::named::named;

/// Height is measured on squares nearer than this, in metres: roads are not quite plane.
const NEAR_M: f64 = 9.0;
/// The ground is looked for between these distances, in metres: the car is nearer, and slopes are farther away.
const RANGE_M: [f64; 2] = [2.0, 20.0];
/// More points of a scan are not needed.
const ENOUGH_POINTS: usize = 40_000;
/// The ground is looked for in squares of this side, in metres; a square counts if it has this many points.
const SQUARE_M: f64 = 1.5;
const MIN_SQUARE_POINTS: usize = 5;
/// The low points of squares that show the ground lie this close to one plane, in metres.
const ON_PLANE_M: f64 = 0.12;
/// Points this far below the plane count against it, in metres.
const BELOW_PLANE_M: f64 = 0.3;
/// Number of planes that are tried.
const N_TRIALS: usize = 400;
/// Steeper planes are no ground.
const MAX_TILT_DEG: f64 = 20.0;
/// Heights of origins above the ground, in metres: from on the ground, as in frames of cars, to above any sensor.
const HEIGHTS_M: [f64; 2] = [-0.5, 6.0];
/// Fewest squares on the ground, in all scans together.
const MIN_SQUARES: usize = 15;
/// If this share of the squares shows the ground with z up, no other axis is tried.
const CLEAR_SHARE: f64 = 0.5;
/// Another axis points up if its ground is this many times as large.
const CLEARLY_LARGER: f64 = 1.5;

/// The ground around a sensor as a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenGround {
    /// The direction of up, a unit vector in the frame of the scan.
    pub up: [f64; 3],
    /// How high the origin is above it, in metres.
    pub height_m: f64,
    /// Share of the squares around the sensor that lie on it, from 0 to 1.
    pub share: f64,
    n_squares: usize,
}

named! {
    /// The axis of a frame that points up.
    pub enum UpAxis {
        /// As it should be.
        Z = "z",
        /// Upside down.
        MinusZ = "-z",
        /// To the side or forward.
        X = "x",
        /// Its opposite.
        MinusX = "-x",
        /// To the side or forward.
        Y = "y",
        /// Its opposite: as in frames of cameras.
        MinusY = "-y",
    }
}

impl UpAxis {
    /// A turn that puts the axis up, in the form of a file of `--transform`: rows of rotation and shift. Where the frame of
    /// cameras or of computer graphics is likely, forward is theirs; otherwise the turn is as small as possible.
    pub fn sensor_from_file(self) -> &'static str {
        match self {
            Self::Z => "1 0 0 0  0 1 0 0  0 0 1 0",
            Self::MinusZ => "1 0 0 0  0 -1 0 0  0 0 -1 0",
            Self::X => "0 0 -1 0  0 1 0 0  1 0 0 0",
            Self::MinusX => "0 0 1 0  0 1 0 0  -1 0 0 0",
            Self::Y => "0 0 -1 0  -1 0 0 0  0 1 0 0",
            Self::MinusY => "0 0 1 0  -1 0 0 0  0 -1 0 0",
        }
    }

    fn direction(self) -> Vector3<f64> {
        match self {
            Self::Z => Vector3::z(),
            Self::MinusZ => -Vector3::z(),
            Self::X => Vector3::x(),
            Self::MinusX => -Vector3::x(),
            Self::Y => Vector3::y(),
            Self::MinusY => -Vector3::y(),
        }
    }
}

impl SeenGround {
    /// The ground below the sensor in `clouds`, all of one frame, if about `axis` points up; `None` if there is none.
    pub fn of<'a>(clouds: impl IntoIterator<Item = &'a PointCloud>, axis: UpAxis) -> Option<Self> {
        let to_upright = UnitQuaternion::rotation_between(&axis.direction(), &Vector3::z())
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        let lowest: Vec<Vector3<f64>> =
            clouds.into_iter().flat_map(|it| lowest_of_squares(it, &to_upright)).collect();
        let (normal, height_m, n_on) = best_plane(&lowest)?;
        let up = to_upright.inverse() * normal;
        let share = n_on as f64 / lowest.len() as f64;
        Some(Self { up: up.into(), height_m, share, n_squares: n_on })
    }

    /// The axis that points up in `clouds`, with its ground: z unless another one shows much more ground. `None` if no axis
    /// shows any.
    pub fn with_axis(clouds: &[&PointCloud]) -> Option<(UpAxis, Self)> {
        let seen = |axis| Some((axis, Self::of(clouds.iter().copied(), axis)?));
        let upright = seen(UpAxis::Z);
        if upright.is_some_and(|(_, it)| it.share >= CLEAR_SHARE) {
            return upright;
        }
        let worth = |it: &(UpAxis, Self)| it.1.share * it.1.n_squares as f64;
        let other =
            UpAxis::ALL[1..].iter().filter_map(|&it| seen(it)).max_by(|a, b| worth(a).total_cmp(&worth(b)));
        match (upright, other) {
            (Some(z), Some(other)) if worth(&other) > CLEARLY_LARGER * worth(&z) => Some(other),
            (None, other) => other,
            (z, _) => z,
        }
    }

    /// The angle between up and z, in degrees.
    pub fn tilt_deg(&self) -> f64 {
        self.up[2].clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// The smallest turn that levels the ground; it leaves the origin where it is.
    pub fn levelling(&self) -> Isometry3<f64> {
        let turn = UnitQuaternion::rotation_between(&Vector3::from(self.up), &Vector3::z())
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        Isometry3::from_parts(Translation3::identity(), turn)
    }
}

/// A low point of every square around the origin, in a frame whose z points up: a twentieth of its points are lower.
fn lowest_of_squares(cloud: &PointCloud, to_upright: &UnitQuaternion<f64>) -> Vec<Vector3<f64>> {
    let mut by_square: BTreeMap<[i32; 2], Vec<Vector3<f64>>> = BTreeMap::new();
    let step = cloud.len().div_ceil(ENOUGH_POINTS).max(1);
    for position_m in cloud.positions_m().step_by(step) {
        let at_m = to_upright * Vector3::from(position_m.map(f64::from));
        if (RANGE_M[0]..RANGE_M[1]).contains(&at_m.x.hypot(at_m.y)) {
            let square = [at_m.x, at_m.y].map(|it| (it / SQUARE_M).floor() as i32);
            by_square.entry(square).or_default().push(at_m);
        }
    }
    let squares = by_square.into_values().filter(|it| it.len() >= MIN_SQUARE_POINTS);
    let lowest = |mut points_m: Vec<Vector3<f64>>| {
        points_m.sort_unstable_by(|a, b| a.z.total_cmp(&b.z));
        points_m[points_m.len() / 20]
    };
    squares.map(lowest).collect()
}

/// The plane with most of `points_m` on it and few below: normal, height of the origin, number of points on it.
fn best_plane(points_m: &[Vector3<f64>]) -> Option<(Vector3<f64>, f64, usize)> {
    if points_m.len() < MIN_SQUARES {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut best: Option<(i64, UnitVector3<f64>, f64)> = None;
    for _ in 0..N_TRIALS {
        let [a, b, c] = std::array::from_fn(|_| points_m[rng.random_range(0..points_m.len())]);
        let Some(plane) = plane_of(a, (b - a).cross(&(c - a))) else { continue };
        let worth = worth(points_m, plane);
        if best.is_none_or(|it| worth > it.0) {
            best = Some((worth, plane.0, plane.1));
        }
    }
    let (_, mut normal, mut height_m) = best?;
    for _ in 0..3 {
        (normal, height_m) = refined(points_m, normal, height_m)?;
    }
    let n_on = points_m.iter().filter(|it| (normal.dot(it) + height_m).abs() <= ON_PLANE_M).count();
    let height_m = near_height_m(points_m, &normal, height_m);
    (n_on >= MIN_SQUARES).then_some((normal.into_inner(), height_m, n_on))
}

/// The median height over the near ones of `points_m` close to the plane; the height over the plane if there are too few.
fn near_height_m(points_m: &[Vector3<f64>], normal: &UnitVector3<f64>, height_m: f64) -> f64 {
    let near = points_m.iter().filter(|it| it.x.hypot(it.y) < NEAR_M).map(|it| -normal.dot(it));
    let mut heights_m: Vec<f64> = near.filter(|it| (it - height_m).abs() <= BELOW_PLANE_M).collect();
    heights_m.sort_unstable_by(f64::total_cmp);
    let is_enough = heights_m.len() >= MIN_SQUARE_POINTS;
    if is_enough { heights_m[heights_m.len() / 2] } else { height_m }
}

/// The plane through a point with this normal, if it may be the ground.
fn plane_of(at_m: Vector3<f64>, normal: Vector3<f64>) -> Option<(UnitVector3<f64>, f64)> {
    let normal = UnitVector3::try_new(if normal.z < 0.0 { -normal } else { normal }, 1e-6)?;
    let height_m = -normal.dot(&at_m);
    let may_be =
        normal.z >= MAX_TILT_DEG.to_radians().cos() && (HEIGHTS_M[0]..HEIGHTS_M[1]).contains(&height_m);
    may_be.then_some((normal, height_m))
}

fn worth(points_m: &[Vector3<f64>], (normal, height_m): (UnitVector3<f64>, f64)) -> i64 {
    points_m
        .iter()
        .map(|it| match normal.dot(it) + height_m {
            above_m if above_m.abs() <= ON_PLANE_M => 1,
            above_m if above_m < -BELOW_PLANE_M => -2,
            _ => 0,
        })
        .sum()
}

/// The plane of least squares through the points that lie on the given one.
fn refined(
    points_m: &[Vector3<f64>],
    normal: UnitVector3<f64>,
    height_m: f64,
) -> Option<(UnitVector3<f64>, f64)> {
    let on: Vec<&Vector3<f64>> =
        points_m.iter().filter(|it| (normal.dot(it) + height_m).abs() <= ON_PLANE_M).collect();
    if on.len() < 3 {
        return None;
    }
    let middle_m = on.iter().copied().sum::<Vector3<f64>>() / on.len() as f64;
    let spread =
        on.iter().fold(Matrix3::zeros(), |sum, it| sum + (*it - middle_m) * (*it - middle_m).transpose());
    let eigen = spread.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    plane_of(middle_m, eigen.eigenvectors.column(least).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::mounting::read_transform;
    use nalgebra::Rotation3;

    /// A turn about x and then about y that tilts a frame, in degrees.
    fn tilt(about_x_deg: f64, about_y_deg: f64) -> Rotation3<f64> {
        Rotation3::from_euler_angles(about_x_deg.to_radians(), about_y_deg.to_radians(), 0.0)
    }

    /// A road with cars and a house, seen from `height_m` above it and turned.
    fn street(height_m: f64, turn: &Rotation3<f64>) -> PointCloud {
        let mut cloud = PointCloud::default();
        for step in 0..160 * 160 {
            let (x_m, y_m) = (0.25 * f64::from(step % 160) - 20.0, 0.25 * f64::from(step / 160) - 20.0);
            let is_car = (5.0..9.0).contains(&x_m) && (2.0..4.0).contains(&y_m.abs());
            let top_m = if y_m > 12.0 {
                6.0
            } else if is_car {
                1.5
            } else {
                0.0
            };
            for level in 0..=(top_m / 0.5) as i32 {
                let z_m = 0.5 * f64::from(level) - height_m;
                // Below a roof that is seen there is no road.
                if top_m == 0.0 || z_m > 0.3 - height_m {
                    let at_m = turn * Vector3::new(x_m, y_m, z_m);
                    cloud.push([at_m.x, at_m.y, at_m.z].map(|it| it as f32), 0.0);
                }
            }
        }
        cloud
    }

    #[track_caller]
    fn check(height_m: f64, about_x_deg: f64, about_y_deg: f64) {
        let turn = tilt(about_x_deg, about_y_deg);
        let cloud = street(height_m, &turn);
        let (axis, seen) = SeenGround::with_axis(&[&cloud]).expect("there is a road");
        assert_eq!(axis, UpAxis::Z);
        assert!((seen.height_m - height_m).abs() < 0.03, "{seen:?}");
        let expected_deg = (turn * Vector3::z()).z.acos().to_degrees();
        assert!((seen.tilt_deg() - expected_deg).abs() < 0.3, "{seen:?}, not {expected_deg}");
        let levelled = seen.levelling() * (turn * Vector3::z());
        assert!(levelled.z > 0.9999, "{levelled}");
    }

    #[test]
    fn each_axis_is_turned_up() {
        for axis in UpAxis::ALL {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("mounting.txt");
            std::fs::write(&path, axis.sensor_from_file()).unwrap();
            let up = read_transform(&path).unwrap() * axis.direction();
            assert!((up - Vector3::z()).norm() < 1e-6, "{axis:?}: {up}");
        }
    }

    #[test]
    fn height_and_tilt_are_those_of_the_road() {
        for height_m in [0.5, 1.73, 3.0] {
            for (about_x_deg, about_y_deg) in [(0.0, 0.0), (10.0, 0.0), (-3.0, 5.0), (0.0, -10.0)] {
                check(height_m, about_x_deg, about_y_deg);
            }
        }
    }

    #[test]
    fn the_axis_that_points_up_is_found() {
        for (about_x_deg, about_y_deg, expected) in [
            (180.0, 0.0, UpAxis::MinusZ),
            (90.0, 0.0, UpAxis::MinusY),
            (-90.0, 0.0, UpAxis::Y),
            (0.0, 90.0, UpAxis::X),
        ] {
            let cloud = street(1.73, &tilt(about_x_deg, about_y_deg));
            let (axis, seen) = SeenGround::with_axis(&[&cloud]).expect("there is a road");
            assert_eq!(axis, expected);
            assert!((seen.height_m - 1.73).abs() < 0.03, "{seen:?}");
        }
    }

    #[test]
    fn without_a_road_there_is_none() {
        assert_eq!(SeenGround::with_axis(&[&PointCloud::default()]), None);
    }
}
