//! The lasers of the sensors, as their manuals list them.

use std::f32::consts::PI;

/// A model of Velodyne's sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VelodyneModel {
    /// 16 lasers.
    Vlp16,
    /// 32 lasers.
    Hdl32e,
    /// 64 lasers in two banks; each sensor has a calibration of its own.
    Hdl64e,
}

impl VelodyneModel {
    /// The id of the sensor.
    pub fn sensor(self) -> &'static str {
        match self {
            Self::Vlp16 => "vlp-16",
            Self::Hdl32e => "hdl-32e",
            Self::Hdl64e => "hdl-64e-s2",
        }
    }
}

/// Direction of a laser, and corrections of its measurements.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Laser {
    /// Elevation in radians.
    pub vertical_rad: f32,
    /// Turn against the head in radians, clockwise like the azimuth.
    pub rotation_rad: f32,
    /// Height above the origin in metres.
    pub vertical_offset_m: f32,
    /// Distance beside the axis in metres.
    pub horizontal_offset_m: f32,
    /// Correction that is added to a distance, in metres.
    pub distance_m: f32,
    /// Corrections nearby, across and along, in metres; `None` if they are the same as far away.
    pub distance_nearby_m: Option<[f32; 2]>,
}

/// The lasers of a sensor as its manual lists them; none for a model that is calibrated one by one.
pub fn lasers_of(model: VelodyneModel) -> Vec<Laser> {
    match model {
        VelodyneModel::Vlp16 => {
            VLP_16.iter().map(|&[degrees, millimetres]| laser(degrees, millimetres)).collect()
        }
        VelodyneModel::Hdl32e => HDL_32E.iter().map(|&degrees| laser(degrees, 0.0)).collect(),
        VelodyneModel::Hdl64e => Vec::new(),
    }
}

fn laser(degrees: f32, millimetres: f32) -> Laser {
    Laser { vertical_rad: degrees * PI / 180.0, vertical_offset_m: millimetres / 1000.0, ..Laser::default() }
}

/// Elevation in degrees and height of the laser in millimetres, in the order of firing.
const VLP_16: [[f32; 2]; 16] = [
    [-15.0, 11.2],
    [1.0, -0.7],
    [-13.0, 9.7],
    [3.0, -2.2],
    [-11.0, 8.1],
    [5.0, -3.7],
    [-9.0, 6.6],
    [7.0, -5.1],
    [-7.0, 5.1],
    [9.0, -6.6],
    [-5.0, 3.7],
    [11.0, -8.1],
    [-3.0, 2.2],
    [13.0, -9.7],
    [-1.0, 0.7],
    [15.0, -11.2],
];

/// Elevation in degrees, in the order of firing.
const HDL_32E: [f32; 32] = [
    -30.67, -9.33, -29.33, -8.0, -28.0, -6.67, -26.67, -5.33, -25.33, -4.0, -24.0, -2.67, -22.67, -1.33,
    -21.33, 0.0, -20.0, 1.33, -18.67, 2.67, -17.33, 4.0, -16.0, 5.33, -14.67, 6.67, -13.33, 8.0, -12.0, 9.33,
    -10.67, 10.67,
];
