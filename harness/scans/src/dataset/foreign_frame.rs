//! What results of other programs need to know about a scan: how the makers of its format name it, and in which frame they
//! give boxes.

use nalgebra::{Isometry3, Matrix3x4, Matrix4};

use super::time_pairs::Moment;

/// How a scan is named in results made elsewhere beside its id, and how the frame of their boxes lies to the sensor's.
/// Metres.
#[derive(Debug, Clone, PartialEq)]
pub enum ForeignFrame {
    /// Nothing more than its id is known, and boxes are in the frame of the sensor.
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
    /// nuScenes: boxes are in a frame that rests.
    World {
        /// The token of the sample.
        sample_token: String,
        /// Where the sensor was.
        world_from_sensor: Isometry3<f64>,
    },
    /// Argoverse 2: boxes are in the frame of the car.
    Car {
        /// The name of the log.
        log_id: String,
        /// The time of the sweep in nanoseconds.
        timestamp_ns: i64,
        /// Where the sensor is.
        car_from_sensor: Isometry3<f64>,
    },
    /// A recording: boxes name their frame.
    Recording {
        /// When the cloud was taken, as far as it says, and when it was logged.
        moment: Moment,
        /// The frame of the cloud.
        frame: String,
        /// From coordinates of that frame to those of the sensor.
        sensor_from_frame: Isometry3<f64>,
    },
}
