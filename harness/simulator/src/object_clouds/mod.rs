//! Clouds of single objects: scanned from all round, in a single scan, from the air, or by a tilted scanner on a vehicle
//! that approaches.
//!
//! An object is drawn from a seed, its class and its number, and nothing else: every way of looking at it shows the same
//! one. The same seed gives the same bytes, as everywhere in the simulator.

// The objects.
pub mod tree_kind;
pub mod pole_kind;
pub mod person_kind;
pub mod object_kind;
pub mod drawn_object;

// The ways of looking at them.
pub mod lone_object;
pub mod around;
pub mod single_scan;
pub mod from_the_air;
pub mod planar_scanner;
pub mod approach;

// Sets of objects by name.
pub mod simulated_objects;
pub mod open_objects;
