//! Tests of the whole: the structure of the code, and the program from outside.

// What the tests of the program share.
mod accepted;
mod drawn_dataset;
#[cfg(feature = "remote")]
mod file_server;
mod partial;
mod program;
mod shard_folders;

mod bad_input;
mod refusals;
mod command_line;
mod detect;
#[cfg(feature = "remote")]
mod data_get;
mod first_look;
mod label_look;
mod ablation;
mod experiments;
mod layers;
mod run_directory;
mod added;
#[cfg(target_os = "linux")]
mod served_page;
mod seeds;
#[cfg(target_os = "linux")]
mod signals;
#[cfg(target_os = "linux")]
mod odd_detector;
#[cfg(target_os = "linux")]
mod foreign_detectors;
mod results_of_others;
mod classes;
mod own_slices;
mod shards;
mod going_on;
mod start_up;
mod realism;
mod reproduce;
mod readers;
mod protocol_labels;
mod fit_density;
mod gate;
mod baseline;
mod history;
mod streaming;
#[cfg(target_os = "linux")]
mod full_disk;
mod blocks;
mod protocols;
mod init;
#[cfg(unix)]
mod submit;
mod sweep;
mod train;
mod boxes;
mod view;
#[cfg(unix)]
mod hostile_runs;
