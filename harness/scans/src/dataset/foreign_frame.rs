//! Facts about a scan for results of other programs: its name in its format, and the frame in which they give boxes.

use nalgebra::{Isometry3, Matrix3x4, Matrix4};

use super::time_pairs::Moment;

/// The name of a scan in results made elsewhere, beside its id, and the pose of the frame of their boxes relative to the
/// sensor. Metres.
#[derive(Debug, Clone, PartialEq)]
pub enum ForeignFrame {
    /// Only the id is known, and boxes are in the frame of the sensor.
    Sensor,
    /// KITTI: boxes are in the rectified frame of the camera, x right, y down, z forward.
    Camera {
        /// From homogeneous coordinates of that frame to those of the sensor.
        velodyne_from_camera: Matrix4<f64>,
        /// From homogeneous sensor coordinates to homogeneous pixels.
        image_from_velodyne: Matrix3x4<f64>,
        /// Width and height of the image in pixels.
        image_size_px: [u32; 2],
    },
    /// nuScenes: boxes are in the frame of the world, which rests.
    World {
        /// The token of the sample.
        sample_token: String,
        /// The pose of the sensor.
        world_from_sensor: Isometry3<f64>,
    },
    /// Argoverse 2: boxes are in the frame of the car.
    Car {
        /// The name of the log.
        log_id: String,
        /// The time of the sweep in nanoseconds.
        timestamp_ns: i64,
        /// The pose of the sensor in the frame of the car.
        car_from_sensor: Isometry3<f64>,
    },
    /// A recording: boxes name their frame.
    Recording {
        /// The time stamp of the cloud, if it has one, and when it was logged.
        moment: Moment,
        /// The frame of the cloud.
        frame: String,
        /// From coordinates of that frame to those of the sensor.
        sensor_from_frame: Isometry3<f64>,
    },
}
