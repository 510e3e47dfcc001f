//! The mounting of a sensor, where the files do not state it or are wrong.

use std::path::Path;

use detector::OrientedBox;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use reports::files::regular_file::read_settings_text;

use super::earlier_scans::{Sweep, moved};
use super::foreign_frame::ForeignFrame;
use super::shown_name::shown;
use super::upright_box::{pose_of_box, upright_box};
use super::{Dataset, DatasetDescription, DatasetError, Listing};
use crate::annotation::{LabeledArea, LabeledScan};

/// Values that override those of files, catalogue and format.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mounting {
    /// The sensor, see [`DatasetDescription::sensor`](super::DatasetDescription::sensor).
    pub sensor: Option<String>,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: Option<f32>,
    /// From the frame of the files to that of the sensor, x forward, y left, z up. Points and boxes are moved by it.
    pub sensor_from_file: Option<Isometry3<f64>>,
}

impl Mounting {
    /// `dataset` with this mounting.
    pub fn of(self, dataset: Box<dyn Dataset>) -> Box<dyn Dataset> {
        if self == Self::default() {
            return dataset;
        }
        let mut listing = dataset.listing().clone();
        self.describe(&mut listing.description);
        Box::new(MountedDataset { dataset, listing, mounting: self })
    }

    /// Writes the mounting into `description`.
    pub fn describe(&self, description: &mut DatasetDescription) {
        if let Some(sensor) = &self.sensor {
            description.sensor.clone_from(sensor);
        }
        if let Some(sensor_height_m) = self.sensor_height_m {
            description.sensor_height_m = sensor_height_m;
        }
    }

    /// Moves points, boxes and the labelled area from the frame of the files to that of the sensor. Annotations keep their
    /// points.
    pub fn move_scan(&self, scan: &mut LabeledScan) {
        if let Some(sensor_from_file) = &self.sensor_from_file {
            move_scan(scan, sensor_from_file);
        }
    }
}

/// A data set with another description, all of whose scans are moved.
struct MountedDataset {
    dataset: Box<dyn Dataset>,
    listing: Listing,
    mounting: Mounting,
}

impl Dataset for MountedDataset {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn inner(&self) -> Option<&dyn Dataset> {
        Some(&*self.dataset)
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let mut scan = self.dataset.read_scan(scan_idx)?;
        self.mounting.move_scan(&mut scan);
        Ok(scan)
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        let world_from_file = self.dataset.world_from_sensor(scan_idx)?;
        Ok(world_from_file.map(|it| it * self.file_from_sensor()))
    }

    fn sweeps_before(&self, scan_idx: usize, n: usize) -> Result<Option<Vec<Sweep>>, DatasetError> {
        let file_from_sensor = self.file_from_sensor();
        let mounted = |it: Sweep| Sweep {
            world_from_sensor: it.world_from_sensor * file_from_sensor,
            cloud: moved(it.cloud, &file_from_sensor.inverse()),
            ..it
        };
        let sweeps = self.dataset.sweeps_before(scan_idx, n)?;
        Ok(sweeps.map(|it| it.into_iter().map(mounted).collect()))
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        let frame = self.dataset.foreign_frame(scan_idx)?;
        let file_from_sensor = self.file_from_sensor();
        let sensor_from_file = file_from_sensor.inverse();
        Ok(match frame {
            ForeignFrame::Sensor => ForeignFrame::Sensor,
            ForeignFrame::Camera { velodyne_from_camera, image_from_velodyne, image_size_px } => {
                ForeignFrame::Camera {
                    velodyne_from_camera: sensor_from_file.to_homogeneous() * velodyne_from_camera,
                    image_from_velodyne: image_from_velodyne * file_from_sensor.to_homogeneous(),
                    image_size_px,
                }
            }
            ForeignFrame::World { sample_token, world_from_sensor } => {
                ForeignFrame::World { sample_token, world_from_sensor: world_from_sensor * file_from_sensor }
            }
            ForeignFrame::Car { log_id, timestamp_ns, car_from_sensor } => ForeignFrame::Car {
                log_id,
                timestamp_ns,
                car_from_sensor: car_from_sensor * file_from_sensor,
            },
            ForeignFrame::Recording { moment, frame, sensor_from_frame } => {
                let sensor_from_frame = sensor_from_file * sensor_from_frame;
                ForeignFrame::Recording { moment, frame, sensor_from_frame }
            }
        })
    }
}

impl MountedDataset {
    fn file_from_sensor(&self) -> Isometry3<f64> {
        self.mounting.sensor_from_file.map_or_else(Isometry3::identity, |it| it.inverse())
    }
}

fn move_scan(scan: &mut LabeledScan, sensor_from_file: &Isometry3<f64>) {
    scan.cloud = moved(std::mem::take(&mut scan.cloud), sensor_from_file);
    for bounding_box in scan.annotations.iter_mut().filter_map(|it| it.bounding_box.as_mut()) {
        *bounding_box = moved_box(bounding_box, sensor_from_file);
    }
    scan.labeled_area = match scan.labeled_area {
        LabeledArea::CameraImage { image_from_sensor, image_size_px } => LabeledArea::CameraImage {
            image_from_sensor: image_from_sensor * sensor_from_file.inverse().to_homogeneous(),
            image_size_px,
        },
        // The directions of the area have changed.
        LabeledArea::Ahead { .. } => LabeledArea::AsPoints,
        area @ (LabeledArea::Everywhere | LabeledArea::AsPoints) => area,
    };
}

fn moved_box(bounding_box: &OrientedBox, sensor_from_file: &Isometry3<f64>) -> OrientedBox {
    let size_m = bounding_box.length_width_height_m;
    let moved = upright_box(&(sensor_from_file * pose_of_box(bounding_box)), size_m.map(f64::from));
    OrientedBox { length_width_height_m: size_m, ..moved }
}

/// Rotations may deviate from one by this much: matrices are written with few digits.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// Reads a rigid transform from a text file: a matrix of 4 × 4 or 3 × 4 numbers row by row; or x y z and a quaternion x y z
/// w; or x y z and roll, pitch and yaw in radians about fixed axes, as ROS has them. Metres; commas, brackets and text
/// behind `#` are ignored.
pub fn read_transform(path: &Path) -> Result<Isometry3<f64>, DatasetError> {
    let text = read_settings_text(path).map_err(DatasetError::io(path))?;
    numbers_of(&text).and_then(|numbers| transform_of(&numbers)).map_err(|problem| refused(path, &problem))
}

fn refused(path: &Path, problem: &str) -> DatasetError {
    DatasetError::Usage(format!("{path:?} {}", shown(problem)))
}

fn numbers_of(text: &str) -> Result<Vec<f64>, String> {
    let mut numbers = Vec::new();
    for (line, line_number) in text.lines().zip(1..) {
        let said = line.split('#').next().unwrap_or_default();
        let is_between = |it: char| it.is_whitespace() || ",;[]()".contains(it);
        for word in said.split(is_between).filter(|it| !it.is_empty()) {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                _ => return Err(format!("has {word:?} in line {line_number}, which is no number")),
            }
        }
    }
    Ok(numbers)
}

fn transform_of(numbers: &[f64]) -> Result<Isometry3<f64>, String> {
    let moved = |x_m, y_m, z_m, turn| Isometry3::from_parts(Translation3::new(x_m, y_m, z_m), turn);
    match *numbers {
        [x_m, y_m, z_m, roll_rad, pitch_rad, yaw_rad] => {
            Ok(moved(x_m, y_m, z_m, UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, yaw_rad)))
        }
        [x_m, y_m, z_m, i, j, k, w] => {
            let quaternion = nalgebra::Quaternion::new(w, i, j, k);
            let norm = quaternion.norm();
            if (norm - 1.0).abs() > ROTATION_TOLERANCE {
                return Err(format!(
                    "has a quaternion of length {norm:.4}, not 1; it is x y z w, after the translation"
                ));
            }
            Ok(moved(x_m, y_m, z_m, UnitQuaternion::from_quaternion(quaternion)))
        }
        _ if numbers.len() == 12 || numbers.len() == 16 => {
            if numbers.len() == 16 && numbers[12..] != [0.0, 0.0, 0.0, 1.0] {
                return Err(format!("has {:?} for a last row, not 0 0 0 1", &numbers[12..]));
            }
            let at = |row: usize, column: usize| numbers[4 * row + column];
            let matrix = Matrix3::from_fn(at);
            let off = (matrix * matrix.transpose() - Matrix3::identity()).abs().max();
            if off > ROTATION_TOLERANCE || matrix.determinant() < 0.0 {
                return Err(format!("has no rotation in its first three columns: they are off by {off:.4}"));
            }
            let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&matrix));
            let at_m = Vector3::from_fn(|row, _| at(row, 3));
            Ok(Isometry3::from_parts(at_m.into(), turn))
        }
        _ => Err(format!(
            "has {} numbers, not 16 or 12 (a matrix), 7 (x y z and a quaternion) or 6 (x y z roll pitch yaw)",
            numbers.len()
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    /// Checks where (1, 2, 3) moves to.
    #[track_caller]
    fn check(text: &str, expected_m: [f64; 3]) {
        let transform = numbers_of(text).and_then(|it| transform_of(&it)).unwrap();
        let found_m = transform * Point3::new(1.0, 2.0, 3.0);
        let off_m = (found_m - Point3::from(expected_m)).norm();
        assert!(off_m < 1e-6, "{text}: {found_m}");
    }

    #[test]
    fn a_quarter_turn_to_the_left_and_a_step_up_is_written_in_four_ways() {
        let expected_m = [-2.0, 1.0, 4.5];
        check("0 -1 0 0\n1 0 0 0\n0 0 1 1.5\n0 0 0 1\n", expected_m);
        check("[[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 1.5]]", expected_m);
        check("0 0 1.5  0 0 0.7071067811865476 0.7071067811865476 # x y z, then x y z w", expected_m);
        check("0, 0, 1.5, 0, 0, 1.5707963267948966", expected_m);
    }

    #[test]
    fn roll_pitch_and_yaw_are_about_fixed_axes() {
        // First about x, then about y: (1, 2, 3) → (1, -3, 2) → (2, -3, -1).
        let quarter = std::f64::consts::FRAC_PI_2;
        check(&format!("0 0 0 {quarter} {quarter} 0"), [2.0, -3.0, -1.0]);
    }

    #[track_caller]
    fn check_refused(text: &str, expected: &str) {
        let problem = numbers_of(text).and_then(|it| transform_of(&it)).unwrap_err();
        assert!(problem.contains(expected), "{problem}");
    }

    #[test]
    fn what_is_no_rigid_transform_is_refused() {
        check_refused("1 2 3\n4 five 6\n", "\"five\" in line 2");
        check_refused("1 2 3", "has 3 numbers, not 16");
        check_refused("0 0 0 1 1 0 0", "a quaternion of length 1.4142");
        check_refused("2 0 0 0 0 1 0 0 0 0 1 0", "no rotation");
        check_refused("1 0 0 0 0 1 0 0 0 0 -1 0", "no rotation");
        check_refused("1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "for a last row");
        check_refused("0 0 nan 0 0 0", "\"nan\" in line 1");
    }

    #[test]
    fn a_box_is_moved_with_its_points() {
        let quarter = UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        let sensor_from_file = Isometry3::from_parts(Translation3::new(0.0, 0.0, 1.5), quarter);
        let car = OrientedBox {
            center_m: [10.0, 0.0, -1.0],
            length_width_height_m: [4.0, 2.0, 1.5],
            yaw_rad: 0.25,
        };
        let moved = moved_box(&car, &sensor_from_file);
        assert_eq!(moved.length_width_height_m, car.length_width_height_m);
        let off_m =
            moved.center_m.iter().zip([0.0, 10.0, 0.5]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off_m < 1e-5, "{moved:?}");
        assert!((moved.yaw_rad - 0.25 - std::f32::consts::FRAC_PI_2).abs() < 1e-5, "{moved:?}");
    }
}
