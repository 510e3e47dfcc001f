//! What the objects are.

pub mod size_gate;
