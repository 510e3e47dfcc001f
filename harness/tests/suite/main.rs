//! Tests of the whole: the structure of the code, and the program from outside.

// What the tests of the program share.
mod drawn_dataset;
mod program;
// The detector's own tests hold it against this too, but know no simulator.
#[path = "../../../detector/tests/suite/reference/mod.rs"]
mod reference;

mod bad_input;
mod command_line;
mod damaged_datasets;
mod detect;
mod ablation;
mod experiments;
mod kitti_real_scans;
mod layers;
mod run_directory;
#[cfg(target_os = "linux")]
mod signals;
mod start_up;
mod realism;
mod readers;
mod simulated_reference;
mod fit_density;
mod gate;
mod sweep;
mod train;
mod boxes;
mod view;
