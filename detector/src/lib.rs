//! A hierarchical grid that finds objects in LiDAR scans, and models that classify road users among them.
//!
//! There are two detectors, both lists of stages: [`hierarchical`](pipeline::tree_detector::hierarchical), and
//! [`paper`](pipeline::paper_detector::paper), the method exactly as published.
//!
//! This crate knows no files, no annotations and no Rerun. Ground truth cannot be reached from here, so a detector
//! that peeks does not compile.
//!
//! ```
//! use detector::params::HierarchicalParams;
//! use detector::pipeline::tree_detector::{GroupModels, VehiclesBy, hierarchical};
//! use detector::{DetectedClass, Detector, DetectorOutput, PointCloud};
//!
//! // A level road 1.73 m below the sensor, and on it the sides of a thing as long, wide and high as a car.
//! let sensor_height_m = 1.73;
//! let steps = |from_m: f32, to_m: f32| (0..=40).map(move |it| from_m + it as f32 / 40.0 * (to_m - from_m));
//! let road = steps(-10.0, 10.0).flat_map(|x| steps(-10.0, 10.0).map(move |y| [x, y, -1.73]));
//! let side = |y: f32| steps(4.0, 8.0).flat_map(move |x| steps(-1.5, -0.3).map(move |z| [x, y, z]));
//! let end = |x: f32| steps(2.0, 3.8).flat_map(move |y| steps(-1.5, -0.3).map(move |z| [x, y, z]));
//! let cloud: PointCloud = road.chain(side(2.0)).chain(side(3.8)).chain(end(4.0)).chain(end(8.0)).collect();
//!
//! // A detector and its output are used again for the next scan. This one classifies vehicles by their size; with `VehiclesBy::Model`
//! // its model does.
//! let (params, models) = (HierarchicalParams::shipped(), GroupModels::shipped(VehiclesBy::Size));
//! let mut detector = hierarchical(&params, models, sensor_height_m);
//! let mut output = DetectorOutput::default();
//! detector.detect(&cloud, &mut output);
//!
//! let found = output.detections.get(0);
//! assert_eq!((output.detections.len(), found.class), (1, DetectedClass::Vehicle));
//! assert!(found.bounding_box.contains([6.0, 3.0, -1.0]));
//! for it in &output.stage_times {
//!     println!("{:>15} {:?}", it.stage, it.duration);
//! }
//! ```
//!
//! Modules are declared in the order data reaches them; a module uses only modules that are declared above it.
#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests compare with the platform's library"))]

// Numbers that are the same on every machine.
pub mod portable_math;
pub mod seeded_draws;

// The contract.
pub mod point_cloud;
pub mod oriented_box;
pub mod detection;
pub mod road_user;
pub mod surface_class;
pub mod stage_product;
pub mod rule;
pub mod detector;

pub use detection::{BoxDetails, DetectedClass, Detection, Detections, GivenClass};
pub use detector::{Detector, DetectorOutput};
pub use oriented_box::OrientedBox;
pub use point_cloud::PointCloud;
pub use rule::Rule;
pub use stage_product::StageProduct;

// Their speed, and nothing else.
mod vector_instructions;

// The stages, in order.
pub mod grid;
pub mod segment;
pub mod fit;
pub mod describe;
pub mod group;
pub mod classify;
pub mod complete;
pub mod whole;

// Names of the stages, and drawings of their products; nothing is decided here.
pub mod stage;
pub mod drawn;

// Parameters, and the order of the stages.
pub mod params;
pub mod pipeline;

// Another method: classes of objects of which only a part has been seen.
pub mod partial;
