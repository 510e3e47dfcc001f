//! What others make of simulated streets.

// The detector's own tests hold it against this too, but know no simulator.
#[path = "../../../../detector/tests/suite/reference/mod.rs"]
mod reference;

mod simulated_reference;
