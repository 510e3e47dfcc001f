//! Sound results of other programs, changed at random: readers give detections that can be, or an error, soon and with
//! little memory.

use std::path::Path;

use scans::conversion::results::result_folder::ResultOutput;

use super::foreign_results::{read_all, write_echo};
use super::mutations::{check_with, within};
use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;

/// Changes the files of sound results at `path`, of the scans of the data set at `dataset`.
#[track_caller]
fn check_results(reader: &str, dataset: &Path, path: &Path, seed: u64) {
    check_with(reader, path, seed, |_, limits, name| {
        let (dataset, path) = (dataset.to_owned(), path.to_owned());
        within(limits, name, move || {
            let dataset = super::open(&dataset);
            let found = read_all(&path, &*dataset);
            let found = found.map_err(|error| error.to_string())?;
            for (scan_idx, found) in found.iter().enumerate() {
                found.check(dataset.read_scan(scan_idx).unwrap().cloud.len()).unwrap();
            }
            Ok(())
        })
    });
}

/// What other programs found: files of text, numbers, JSON and columns.
#[test]
fn results_of_others() {
    let workplace = Workplace::new();
    super::made::nuscenes(&workplace.path("nuscenes"), &*super::made::street(2));
    DrawnDataset::tracking(workplace.folder(), 2);
    for (seed, name, output) in [
        (60, "nuscenes", ResultOutput::NuScenes),
        (61, "street", ResultOutput::Kitti),
        (62, "street", ResultOutput::Csv),
    ] {
        let (dataset, results) = (workplace.path(name), workplace.path(&format!("results{seed}")));
        write_echo(&*super::open(&dataset), output, &results);
        check_results(&format!("results, {output:?}"), &dataset, &results.join("echo"), seed);
    }
    let (dataset, results) = (super::argoverse2::drawn(), workplace.path("tables"));
    write_echo(&*super::open(&dataset), ResultOutput::Argoverse2, &results);
    check_results("results, Argoverse2", &dataset, &results.join("echo"), 63);
    let drive = super::recordings::write_drive(&workplace, mcap::WriteOptions::new());
    let results = workplace.path("recorded");
    std::fs::create_dir(&results).unwrap();
    std::fs::copy(&drive, results.join("a.mcap")).unwrap();
    check_results("results, MCAP", &drive, &results, 64);
}
