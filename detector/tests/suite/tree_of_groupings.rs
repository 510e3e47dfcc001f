//! What the best cut of a tree of groupings makes of a drawn street.

use std::collections::BTreeSet;

use detector::params::HierarchicalParams;
use detector::pipeline::frame::Groups;
use detector::pipeline::stage_list::Pipeline;
use detector::pipeline::tree_detector::{GroupModels, VehiclesBy, hierarchical};
use detector::road_user::RoadUser;
use detector::{DetectedClass, Detection, Detector, DetectorOutput, PointCloud, Rule};
use test_data::test_data;

use crate::drawn_street::{DrawnStreet, SENSOR_HEIGHT_M, main_road};
use crate::velodyne_scans::{read_velodyne_bin, velodyne_paths};

fn detector(change: impl Fn(&mut HierarchicalParams)) -> Pipeline<Groups> {
    let mut params = HierarchicalParams::shipped();
    change(&mut params);
    hierarchical(&params, GroupModels::shipped(VehiclesBy::Model), SENSOR_HEIGHT_M)
}

fn found(detector: &mut Pipeline<Groups>, cloud: &PointCloud) -> DetectorOutput {
    let mut output = DetectorOutput::default();
    detector.detect(cloud, &mut output);
    output
}

#[test]
fn no_point_belongs_to_two_objects_and_each_has_its_expected_iou() {
    let cloud = main_road();
    let output = found(&mut detector(|_| ()), &cloud);
    assert!(!output.detections.is_empty());
    let mut seen = BTreeSet::new();
    for detection in output.detections.iter() {
        assert!(detection.point_indices.is_sorted());
        assert!(detection.point_indices.iter().all(|&it| seen.insert(it)), "a point is in two");
        assert_eq!(detection.score.is_some_and(|it| it > 0.0), detection.class == DetectedClass::Vehicle);
    }
}

/// What may be a road user: its class, score and number of points.
type Ranked = (RoadUser, f32, usize);

fn ranked(detection: Detection<'_>) -> Ranked {
    let is_of = |it: &RoadUser| (it.class(), it.given()) == (detection.class, detection.given);
    let road_user = RoadUser::ALL.into_iter().find(is_of).expect("a class of road users");
    (road_user, detection.score.expect("a score"), detection.point_indices.len())
}

#[test]
fn what_may_be_a_road_user_is_ranked_below_all_of_its_class() {
    // More than one of the two objects that are nearly vehicles has.
    const LEAST_POINTS: usize = 2400;
    let cloud = main_road();
    let unlikely = |ranked_probability: f32| {
        let change = |it: &mut HierarchicalParams| {
            it.grouping.ranked_probability = ranked_probability;
            it.cluster.min_points = LEAST_POINTS;
        };
        let output = found(&mut detector(change), &cloud);
        (output.unlikely.iter().map(ranked).collect::<Vec<_>>(), output.detections)
    };
    let least_odds = HierarchicalParams::shipped().cluster.road_user_rule().least_odds;
    let (all, detections) = unlikely(0.001);
    assert!(all.iter().all(|(road_user, score, _)| *score <= least_odds.of(*road_user)));
    let classes: BTreeSet<RoadUser> = all.iter().map(|it| it.0).collect();
    assert_eq!(classes, BTreeSet::from(RoadUser::ALL));
    let vehicles = all.iter().filter(|it| it.0 == RoadUser::Vehicle);
    let are_small: BTreeSet<bool> = vehicles.map(|it| it.2 < LEAST_POINTS).collect();
    assert_eq!(are_small, BTreeSet::from([false, true]), "one is too small, another is an object");
    // Log odds of a twentieth.
    let (likely, same_detections) = unlikely(0.05);
    assert_eq!(likely, all.iter().copied().filter(|it| it.1 > (0.05_f32 / 0.95).ln()).collect::<Vec<_>>());
    assert_eq!(same_detections, detections);
    assert!(unlikely(0.5).0.is_empty());
}

#[test]
fn the_dearer_an_object_the_fewer_there_are() {
    let cloud = main_road();
    let number = |object_cost: f32| {
        found(&mut detector(|it| it.grouping.object_cost = object_cost), &cloud).detections.len()
    };
    let numbers = [0.0, 0.42, 0.8, 1.0].map(number);
    assert!(numbers.is_sorted_by(|a, b| a >= b), "{numbers:?}");
    assert!(numbers[0] > numbers[3], "{numbers:?}");
}

#[test]
#[ignore = "needs data/kitti_tracking/training/velodyne/0000 in SCANBENCH_TEST_DATA"]
fn what_has_too_low_an_expected_iou_for_an_object_is_taken_as_a_road_user_only() {
    let paths = velodyne_paths(&test_data("data/kitti_tracking/training/velodyne/0000"));
    let cloud = read_velodyne_bin(&paths[0]);
    // How many objects that are no road users are found, and how many that are.
    let counts = |object_cost: f32, vehicle_cost: f32| {
        let change = |it: &mut HierarchicalParams| {
            it.grouping.object_cost = object_cost;
            it.grouping.vehicle_cost = vehicle_cost;
        };
        let output = found(&mut detector(change), &cloud);
        let is_road_user = |it: &Detection| it.class == DetectedClass::Vehicle || it.given.is_some();
        [false, true].map(|wanted| output.detections.iter().filter(|it| is_road_user(it) == wanted).count())
    };
    let [n_others, n_road_users] = counts(0.9, 0.9);
    let [n_others_besides, n_road_users_besides] = counts(0.9, 0.25);
    assert_eq!(n_others_besides, n_others);
    assert!(n_road_users_besides > n_road_users, "{n_road_users} road users, then {n_road_users_besides}");
    let [n_others_of_less, _] = counts(0.42, 0.25);
    assert!(n_others_of_less > n_others, "{n_others} others, then {n_others_of_less}");
}

#[test]
fn the_same_scan_gives_the_same_whatever_came_before() {
    let (road, other) = (main_road(), DrawnStreet::road().block([4.1, 8.3], [2.1, 3.9], 1.5).cloud());
    let mut used = detector(|_| ());
    found(&mut used, &other);
    found(&mut used, &PointCloud::default());
    assert_eq!(found(&mut used, &road).detections, found(&mut detector(|_| ()), &road).detections);
}

#[test]
fn what_is_no_number_and_what_is_no_scan_is_no_object() {
    let mut detector = detector(|_| ());
    let mut cloud = PointCloud::default();
    for position_m in [[f32::NAN; 3], [f32::INFINITY, 1.0, 0.0], [1e30, 0.0, 0.0], [3.0, 2.0, f32::NAN]] {
        cloud.push(position_m, 0.0);
    }
    assert!(found(&mut detector, &cloud).detections.is_empty());
    let pile: PointCloud = (0..10_000).map(|_| [5.0, 5.0, -1.0]).collect();
    found(&mut detector, &pile);
    assert!(found(&mut detector, &PointCloud::default()).detections.is_empty());
}

#[test]
fn it_says_what_it_does_beside_grouping() {
    let rules = |change: fn(&mut HierarchicalParams)| detector(change).rules();
    let all = [
        Rule::TrainedGroups,
        Rule::BestCut,
        Rule::SmallVehicles { min_points: 10 },
        Rule::SizeBounds,
        Rule::Completion,
        Rule::WholeBoxes,
    ];
    assert_eq!(rules(|_| ()), all);
    assert_eq!(rules(|it| it.boxes.whole = false), all[..5]);
    assert_eq!(rules(|it| (it.completion.enabled, it.boxes.whole) = (false, false)), all[..4]);
    let without = |it: &Rule| *it != Rule::SizeBounds;
    let others: Vec<Rule> = all.into_iter().filter(without).collect();
    assert_eq!(rules(|it| it.vehicle_bounds.enabled = false), others);
}

#[test]
#[ignore = "needs data/kitti_tracking/training/velodyne/0000 in SCANBENCH_TEST_DATA"]
fn on_a_real_drive_no_point_belongs_to_two_objects() {
    let mut detector = detector(|_| ());
    for path in velodyne_paths(&test_data("data/kitti_tracking/training/velodyne/0000")).iter().step_by(5) {
        let cloud = read_velodyne_bin(path);
        let output = found(&mut detector, &cloud);
        let mut is_taken = vec![false; cloud.len()];
        for detection in output.detections.iter() {
            for &it in detection.point_indices {
                assert!(!std::mem::replace(&mut is_taken[it as usize], true), "a point is in two");
            }
        }
        assert!(is_taken.iter().any(|it| *it));
    }
}
