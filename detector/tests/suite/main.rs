//! Tests of the hierarchical detector as a whole: on a drawn street, and against a reference.
#![allow(clippy::disallowed_methods, reason = "drawn scenes and references may use the platform's library")]

mod cell_fitness;
mod drawn_street;
mod velodyne_scans;
mod nu_svc;
mod trained_on_drawings;
mod vehicle_model;
mod stage_products;
mod steady_state;
mod tree_of_groupings;
mod reference;
mod partial_reference;
mod drawn_objects;
mod partial_objects;
mod same_as_reference;
mod same_as_reference_at_random;
