//! On simulated streets the hierarchical detector, and that of the papers, find what the reference finds, to the bit.

use detector::params::HierarchicalParams;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

use crate::reference::twins::Twins;

#[track_caller]
fn check(street: &str) {
    let catalogue = built_in_catalogue().expect("the embedded catalogue");
    let dataset = open_dataset(street, &OpenOptions::default(), &catalogue).expect("a street");
    let sensor_height_m = dataset.description().sensor_height_m;
    let ours = Twins::new(HierarchicalParams::shipped(), sensor_height_m);
    for mut twins in [ours, Twins::of_papers(sensor_height_m)] {
        for position in [0, 7] {
            let scan = dataset.read_scan(position).expect("a scan");
            let n_objects = twins.check(&scan.cloud, &format!("scan {position} of {street}"));
            assert!(n_objects > 10, "{n_objects} objects in scan {position} of {street}");
        }
    }
}

#[test]
fn on_a_main_road() {
    check("street-main-road");
}

#[test]
fn on_a_narrow_street() {
    check("street-narrow");
}

#[test]
fn on_an_intersection() {
    check("street-intersection");
}
