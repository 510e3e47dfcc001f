//! The detectors find what the reference finds, to the bit.

use detector::PointCloud;
use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use test_data::test_data;

use crate::drawn_street::{DrawnStreet, SENSOR_HEIGHT_M, main_road};
use crate::reference::twins::{CompletionTwins, Twins};
use crate::velodyne_scans::{read_velodyne_bin, velodyne_paths};

/// The detector of the papers with all that is in no paper switched on.
pub fn beyond_papers() -> PaperParams {
    let HierarchicalParams { ground, walls, foreground, cluster, .. } = HierarchicalParams::shipped();
    let mut params = PaperParams::shipped();
    params.ground = ground;
    params.walls.as_printed = walls.as_printed;
    params.walls.min_support = walls.min_support;
    params.walls.hough = walls.hough;
    params.merge.max_height_difference_m = 1.0;
    params.separation.single_gap_points = 1.0;
    params.foreground.clearance_m = foreground.clearance_m;
    params.separation.low_density_share = 0.3;
    params.separation.object_density_ratio = 5.0;
    params.cluster.min_points = cluster.min_points;
    params
}

#[test]
fn on_drawn_streets() {
    let mut twins = Twins::new(beyond_papers(), SENSOR_HEIGHT_M);
    assert_eq!(twins.check(&main_road(), "the main road"), 3);
    let one_car = DrawnStreet::road().block([4.1, 8.3], [2.1, 3.9], 1.5).cloud();
    assert_eq!(twins.check(&one_car, "one car"), 1);
    assert_eq!(twins.check(&DrawnStreet::road().cloud(), "an empty road"), 0);
    assert_eq!(twins.check(&PointCloud::default(), "nothing"), 0);
    assert_eq!(twins.check(&main_road(), "the main road after nothing"), 3);
}

#[test]
fn the_detector_of_the_papers_on_drawn_streets() {
    let mut twins = Twins::new(PaperParams::shipped(), SENSOR_HEIGHT_M);
    // With the road around their feet, what stands near each other is one.
    assert!(twins.check(&main_road(), "the main road") > 0);
    let one_car = DrawnStreet::road().block([4.1, 8.3], [2.1, 3.9], 1.5).cloud();
    assert_eq!(twins.check(&one_car, "one car"), 1);
    assert_eq!(twins.check(&PointCloud::default(), "nothing"), 0);
}

#[test]
fn completed_objects_on_drawn_streets() {
    let mut twins = CompletionTwins::new(HierarchicalParams::shipped(), SENSOR_HEIGHT_M);
    twins.check(&main_road(), "the main road");
    assert_eq!(twins.check(&PointCloud::default(), "nothing"), 0);
}

#[test]
#[ignore = "needs data/kitti_tracking, data/kitti_object and data/semantic_kitti in SCANBENCH_TEST_DATA"]
fn on_real_scans() {
    let drives = [
        test_data("data/kitti_tracking/training/velodyne/0000"),
        test_data("data/kitti_object/training/velodyne"),
        test_data("data/semantic_kitti/sequences/00/velodyne"),
    ];
    let mut beyond = Twins::new(beyond_papers(), SENSOR_HEIGHT_M);
    let mut of_papers = Twins::new(PaperParams::shipped(), SENSOR_HEIGHT_M);
    let mut completion = CompletionTwins::new(HierarchicalParams::shipped(), SENSOR_HEIGHT_M);
    for drive in drives {
        // The scans of the object drive are those of the tracking drive, written once more.
        let paths = velodyne_paths(&drive);
        for path in paths.iter().step_by(if paths.len() > 8 { 5 } else { 2 }) {
            let (cloud, name) = (read_velodyne_bin(path), path.display().to_string());
            for twins in [&mut beyond, &mut of_papers] {
                let n_objects = twins.check(&cloud, &name);
                assert!(n_objects > 30, "{n_objects} objects in {name}");
            }
            assert!(completion.check(&cloud, &name) > 0, "nothing to complete in {name}");
        }
    }
}
