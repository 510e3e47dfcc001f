//! The detectors of the papers: a hierarchical grid that finds objects in LiDAR scans, and the model that tells which
//! of them are vehicles.
//!
//! This crate knows no files, no annotations and no Rerun. Ground truth cannot be reached from here, so a detector
//! that peeks does not compile.
//!
//! Modules are declared in the order data reaches them; a module uses only what is declared above it.

// The contract.
pub mod point_cloud;
pub mod oriented_box;
pub mod detection;
pub mod surface_class;
pub mod stage_product;
pub mod rule;
pub mod detector;

pub use detection::{DetectedClass, Detection, Detections};
pub use detector::{Detector, DetectorOutput};
pub use oriented_box::OrientedBox;
pub use point_cloud::PointCloud;
pub use rule::Rule;
pub use stage_product::StageProduct;

// How fast they run, and nothing else.
mod vector_instructions;

// The stages, in order.
pub mod grid;
pub mod segment;
pub mod fit;
pub mod describe;
pub mod classify;
pub mod regroup;
pub mod complete;

// What they are called, and what they leave behind to be looked at; nothing is decided here.
pub mod stage;
pub mod drawn;

// Their parameters, and how they follow each other.
pub mod params;
pub mod pipeline;
