//! Once the first scan has sized the buffers, detecting allocates nothing.

use detector::classify::paper_model::PaperModel;
use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use detector::pipeline::frame::{Blobs, Groups};
use detector::pipeline::paper_detector::paper;
use detector::pipeline::stage_list::Pipeline;
use detector::pipeline::tree_detector::{GroupModels, VehiclesBy, hierarchical};
use detector::{Detector, DetectorOutput, PointCloud};
use test_data::test_data;

use crate::drawn_street::{SENSOR_HEIGHT_M, main_road};
use crate::velodyne_scans::{read_velodyne_bin, velodyne_paths};

fn tree_detector() -> Pipeline<Groups> {
    let models = GroupModels::shipped(VehiclesBy::Model);
    hierarchical(&HierarchicalParams::shipped(), models, SENSOR_HEIGHT_M)
}

fn paper_detector(model: Option<PaperModel>) -> Pipeline<Blobs> {
    paper(&PaperParams::shipped(), &HierarchicalParams::shipped(), model, SENSOR_HEIGHT_M)
}

/// Checks that detectors that have seen `first` allocate nothing on `second`.
#[track_caller]
fn check(first: &PointCloud, second: &PointCloud) {
    check_detector(tree_detector(), first, second);
    check_detector(paper_detector(None), first, second);
    check_detector(paper_detector(Some(PaperModel::shipped())), first, second);
}

#[track_caller]
fn check_detector(mut detector: impl Detector, first: &PointCloud, second: &PointCloud) {
    let mut output = DetectorOutput::default();
    let sizing = allocation_counter::measure(|| detector.detect(first, &mut output));
    assert!(sizing.count_total > 0, "the counter sees nothing");
    assert!(!output.detections.is_empty());
    let steady = allocation_counter::measure(|| detector.detect(second, &mut output));
    assert_eq!((steady.count_total, steady.bytes_total), (0, 0), "allocations and their bytes");
}

#[test]
fn the_same_scan_again_allocates_nothing() {
    check(&main_road(), &main_road());
}

#[test]
fn a_smaller_scan_allocates_nothing() {
    // What lies ahead, so that no object is larger than before.
    let ahead: PointCloud = main_road().positions_m().filter(|it| it[0] > 0.0).collect();
    assert!((1..main_road().len()).contains(&ahead.len()));
    check(&main_road(), &ahead);
    check(&main_road(), &PointCloud::default());
}

#[test]
#[ignore = "needs data/kitti_tracking/training/velodyne/0000 in SCANBENCH_TEST_DATA"]
fn a_drive_seen_before_allocates_nothing() {
    let paths = velodyne_paths(&test_data("data/kitti_tracking/training/velodyne/0000"));
    let scans: Vec<PointCloud> = paths.iter().step_by(5).map(|path| read_velodyne_bin(path)).collect();
    assert!(scans.len() > 1, "too few scans");
    check_drive(&mut tree_detector(), &scans);
    check_drive(&mut paper_detector(None), &scans);
}

fn check_drive(detector: &mut dyn Detector, scans: &[PointCloud]) {
    let mut output = DetectorOutput::default();
    for scan in scans {
        detector.detect(scan, &mut output);
    }
    for scan in scans.iter().rev() {
        let steady = allocation_counter::measure(|| detector.detect(scan, &mut output));
        assert_eq!(steady.count_total, 0, "allocations on a scan of {} points", scan.len());
    }
}
