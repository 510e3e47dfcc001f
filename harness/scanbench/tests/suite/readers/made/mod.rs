//! Data sets in the layouts of others, made of simulated scans and of drawn packets.

use std::path::Path;
use std::sync::OnceLock;

use scans::annotation::LabeledScan;
use scans::conversion::convert::sheet_of;
use scans::dataset::{Dataset, DatasetError, Listing};
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

mod kitti_raw;
mod las;
mod nuscenes;
mod packets;

pub use kitti_raw::{DRIVE, kitti_raw};
pub use las::las_file;
pub use nuscenes::nuscenes;
pub use packets::{Captured, Head, calibration_of_64, packets, pcap, pcap_at, pcapng, steps_of};

/// A simulated street, seen by few beams, whose scans are kept: most tests of readers read them several times.
struct KeptStreet {
    street: Box<dyn Dataset>,
    scans: &'static [LabeledScan],
}

impl Dataset for KeptStreet {
    fn listing(&self) -> &Listing {
        self.street.listing()
    }

    fn inner(&self) -> Option<&dyn Dataset> {
        Some(&*self.street)
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        Ok(self.scans[scan_idx].clone())
    }
}

/// One to three scans of a simulated street, with few beams.
pub fn street(n_scans: u32) -> Box<dyn Dataset> {
    static SCANS: [OnceLock<Vec<LabeledScan>>; 4] = [const { OnceLock::new() }; 4];
    let options = OpenOptions {
        n_simulated_scans: Some(n_scans),
        sensor: Some("vlp-16".to_owned()),
        ..OpenOptions::default()
    };
    let street = open_dataset("street-intersection", &options, &built_in_catalogue().unwrap()).unwrap();
    let scans = SCANS[n_scans as usize].get_or_init(|| scans(&*street));
    Box::new(KeptStreet { street, scans })
}

pub fn scans(dataset: &dyn Dataset) -> Vec<LabeledScan> {
    (0..dataset.scan_ids().len()).map(|scan_idx| dataset.read_scan(scan_idx).unwrap()).collect()
}

pub fn write(path: &Path, content: impl AsRef<[u8]>) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, content).unwrap();
}

/// Only objects that have a box, with the points in it.
pub fn boxed(scan: &LabeledScan) -> LabeledScan {
    let mut scan = scan.clone();
    scan.annotations.retain(|it| it.bounding_box.is_some());
    scan
}

/// Lets the labels of a data set in one of KITTI's layouts hold all round.
pub fn write_sheet(folder: &Path, dataset: &dyn Dataset) {
    write(&folder.join("scanbench.json"), sheet_of(dataset.description()).to_json());
}
