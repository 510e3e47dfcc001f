//! How soon the program gets to work.

use std::time::{Duration, Instant};

use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;

/// The least time of a few runs of the program, whatever else the machine does.
fn least_time(workplace: &Workplace, arguments: &[&str], exit_code: i32) -> Duration {
    let times = (0..10).map(|_| {
        let started = Instant::now();
        let ended = workplace.run(arguments);
        assert_eq!(ended.exit_code, Some(exit_code), "{arguments:?}: {ended:#?}");
        started.elapsed()
    });
    times.min().unwrap_or(Duration::MAX)
}

#[test]
fn the_first_scan_is_done_at_once() {
    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), 1);
    for detector in ["hierarchical", "pca"] {
        let time = least_time(&workplace, &["detect", "street", "--scan", "0", "-d", detector], 0);
        assert!(time < Duration::from_millis(100), "{detector}: {time:?}");
    }
}

#[test]
fn a_trained_model_is_read_as_fast_as_the_shipped_one() {
    let workplace = Workplace::new();
    DrawnDataset::tracking(workplace.folder(), 1);
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../detector/src/params/vehicle_model");
    let directory = format!("vehicle_model.directory={shipped:?}");
    let time = least_time(&workplace, &["detect", "street", "--scan", "0", "-P", &directory], 0);
    assert!(time < Duration::from_millis(100), "{time:?}");
}

#[test]
fn errors_of_the_command_line_come_before_anything_is_loaded() {
    let workplace = Workplace::new();
    for (arguments, exit_code) in [
        (vec!["run", "street-narrow", "-d", "nonsense"], 2),
        (vec!["run", "street-narrow", "-P", "nonsense=1"], 2),
        (vec!["run", "nowhere"], 2),
        (vec!["detect", "nowhere.bin"], 3),
        (vec!["sweep", "street-narrow"], 2),
    ] {
        let time = least_time(&workplace, &arguments, exit_code);
        assert!(time < Duration::from_millis(100), "{arguments:?}: {time:?}");
    }
}
