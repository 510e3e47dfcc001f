//! On simulated streets the detector of the papers finds what the reference finds, to the bit, and objects are completed
//! alike.

use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

use crate::reference::twins::{CompletionTwins, Twins};

#[track_caller]
fn check(street: &str) {
    let catalogue = built_in_catalogue().expect("the embedded catalogue");
    let dataset = open_dataset(street, &OpenOptions::default(), &catalogue).expect("a street");
    let sensor_height_m = dataset.description().sensor_height_m;
    let mut of_papers = Twins::new(PaperParams::shipped(), sensor_height_m);
    let mut completion = CompletionTwins::new(HierarchicalParams::shipped(), sensor_height_m);
    let scan = dataset.read_scan(7).expect("a scan");
    let n_objects = of_papers.check(&scan.cloud, street);
    assert!(n_objects > 10, "{n_objects} objects in {street}");
    assert!(completion.check(&scan.cloud, street) > 0, "nothing to complete in {street}");
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
