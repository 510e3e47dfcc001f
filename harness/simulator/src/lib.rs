//! A simulated street: a seeded drive of a car with a rotating LiDAR, with complete ground truth.
//!
//! A [`Street`] is drawn from a [`StreetKind`] and a seed; a [`sensor::SensorModel`] makes scans of it. The same kind,
//! seed, sensor and number give the same scan, byte for byte, in any order, with any number of threads and on any
//! x86-64 machine: every beam of every scan has a random stream of its own, and nothing calls the platform's
//! mathematics library ([`portable_math`]).
//!
//! Simulated is not real. The simulator leaves out snow, fog, spray behind wheels, second echoes, and the vibration of the
//! car. It is dry unless a street is put [in the rain](rain).

#![expect(clippy::missing_errors_doc, reason = "the types of errors say it once for all functions")]

pub use detector::portable_math;

pub mod sensor;
pub mod material;
pub mod solid;
pub mod facade;
pub mod object_shape;
pub mod scene;
pub mod road_axis;
pub mod ground;
mod vehicle_parts;
mod body_style;
mod car_shape;
pub mod vehicle_shape;
pub mod fleet;
pub mod person_shape;
pub mod cycle_shape;
pub mod furniture_shape;
pub mod vegetation_shape;
pub mod clutter_shape;
pub mod world;
pub mod roadside;
pub mod overhead;
pub mod rounded_bodies;
pub mod house_row;
pub mod street_conditions;
pub mod road_plan;
pub mod verge;
pub mod pavement_people;
pub mod parked_row;
pub mod pavement_furniture;
pub mod traffic;
pub mod gardens;
pub mod works;
pub mod crowd;
pub mod main_road;
pub mod narrow_street;
pub mod intersection;
pub mod rain;
pub mod pulse_path;
pub mod angular_window;
pub mod scan;
pub mod labeling;
pub mod street;
pub mod staged_scene;
pub mod object_pair;

// Streets as data sets, beside those on disk.
pub mod simulated_street;
pub mod catalogue;
pub mod open;
pub mod recognised_sensor;

// Single objects.
pub mod object_clouds;

pub use street::{EgoPose, SIMULATOR_VERSION, Street, StreetKind};
