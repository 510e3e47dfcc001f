//! What all baselines must do with whole scans.

use baselines::kd_tree_detector::kd_tree;
use baselines::kd_tree_groups::{component_groups, kd_tree_trained, kd_tree_tree};
use baselines::kd_tree_linkage::{KdTreeLinkage, NESTED_TOLERANCES_M};
use baselines::kd_tree_models::{TrainedComponents, shipped_tree};
use baselines::params::{BaselineParams, ForegroundChoice};
use baselines::pca_detector::pca;
use baselines::pca_vehicle_model::PcaVehicleModel;
use baselines::simple_grid_detector::simple_grid;
use detector::classify::vehicle_model::VehicleModel;
use detector::detector::{DetectorOutput, DropReason, DroppedCluster};
use detector::group::grouping_tree::Node;
use detector::params::HierarchicalParams;
use detector::params::paper::PaperParams;
use detector::pipeline::frame::{Blobs, Groups, PointClusters};
use detector::pipeline::object_stages::ObjectModels;
use detector::pipeline::paper_detector::paper;
use detector::pipeline::stage_list::Pipeline;
use detector::pipeline::tree_detector::{GroupModels, VehiclesBy};
use detector::stage_product::Shape;
use detector::{DetectedClass, Detector, OrientedBox, PointCloud};

const SENSOR_HEIGHT_M: f32 = 1.73;

fn kd_tree_over(foreground: ForegroundChoice, model: Option<VehicleModel>) -> Pipeline<PointClusters> {
    let mut params = BaselineParams::shipped().kd_tree;
    params.foreground = foreground;
    kd_tree(&params, &shared(), ObjectModels { vehicles: model, boxes: None }, SENSOR_HEIGHT_M)
}

/// Boxes are those of what is seen: drawn cars are hollow, and look like no car that whole boxes were learned from.
fn shared() -> HierarchicalParams {
    let mut shared = HierarchicalParams::shipped();
    shared.boxes.whole = false;
    shared
}

fn pca_by(model: Option<PcaVehicleModel>) -> Pipeline<PointClusters> {
    pca(&BaselineParams::shipped().pca, &shared(), model, SENSOR_HEIGHT_M)
}

fn simple_grid_by(model: Option<VehicleModel>) -> Pipeline<Blobs> {
    simple_grid(&shared(), ObjectModels { vehicles: model, boxes: None }, SENSOR_HEIGHT_M)
}

fn every_detector() -> [Box<dyn Detector>; 5] {
    [
        Box::new(kd_tree_over(ForegroundChoice::Short, None)),
        Box::new(kd_tree_over(ForegroundChoice::Standing, None)),
        Box::new(kd_tree_over(ForegroundChoice::All, None)),
        Box::new(pca_by(None)),
        Box::new(simple_grid_by(None)),
    ]
}

fn detected(detector: &mut dyn Detector, cloud: &PointCloud) -> DetectorOutput {
    let mut output = DetectorOutput::default();
    detector.detect(cloud, &mut output);
    output
}

/// `n` values from `from` to `to`, both included.
fn steps(from: f32, to: f32, n: u16) -> impl Iterator<Item = f32> + Clone {
    (0..n).map(move |step| from + f32::from(step) / f32::from(n - 1) * (to - from))
}

fn road() -> Vec<[f32; 3]> {
    let columns = steps(-20.0, 20.0, 200);
    columns.flat_map(|x_m| steps(-20.0, 20.0, 200).map(move |y_m| [x_m, y_m, -SENSOR_HEIGHT_M])).collect()
}

/// The four sides of a car, from 0.3 m above the road up.
fn car(center_m: [f32; 2], yaw_rad: f32) -> Vec<[f32; 3]> {
    sides(center_m, yaw_rad, [4.2, 1.8], [0.3, 1.4])
}

fn sides(
    [x_m, y_m]: [f32; 2],
    yaw_rad: f32,
    [length_m, width_m]: [f32; 2],
    [bottom_m, top_m]: [f32; 2],
) -> Vec<[f32; 3]> {
    let footprint =
        OrientedBox { center_m: [x_m, y_m, 0.0], length_width_height_m: [length_m, width_m, 0.0], yaw_rad };
    let corners_m = footprint.footprint_m();
    let heights_m = steps(bottom_m - SENSOR_HEIGHT_M, top_m - SENSOR_HEIGHT_M, 10);
    let edges = (0..4).map(|corner| (corners_m[corner], corners_m[(corner + 1) % 4]));
    let outline_m = edges.flat_map(|(from_m, to_m)| {
        let n = (10.0 * (from_m[0] - to_m[0]).hypot(from_m[1] - to_m[1])) as u16 + 2;
        steps(0.0, 1.0, n)
            .map(move |share| [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis])))
    });
    outline_m.flat_map(|[x_m, y_m]| heights_m.clone().map(move |z_m| [x_m, y_m, z_m])).collect()
}

#[track_caller]
fn check_found(found: &DetectorOutput, expected: &[([f32; 2], f32)]) {
    let boxes: Vec<OrientedBox> = found.detections.iter().map(|detection| detection.bounding_box).collect();
    assert_eq!(boxes.len(), expected.len(), "{boxes:?}");
    for &([x_m, y_m], yaw_rad) in expected {
        let fits = |it: &OrientedBox| {
            (it.center_m[0] - x_m).hypot(it.center_m[1] - y_m) < 0.2
                && (it.yaw_rad - yaw_rad).sin().abs() < 0.05
        };
        let found_as = found.detections.iter().find(|detection| fits(&detection.bounding_box));
        let class = found_as.map(|detection| detection.class);
        assert_eq!(class, Some(DetectedClass::Vehicle), "{x_m}, {y_m}: {boxes:?}");
    }
}

#[test]
fn nothing_is_found_where_there_is_nothing() {
    let not_finite = [[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [1.0, 2.0, f32::NEG_INFINITY]];
    for mut detector in every_detector() {
        for positions_m in [&[][..], &[[5.0, 1.0, -1.0]], &not_finite] {
            let cloud = positions_m.iter().copied().collect();
            let found = detected(detector.as_mut(), &cloud);
            assert!(found.detections.is_empty(), "{}", detector.name());
            for product in detector.stage_products(&cloud) {
                if let Shape::Clusters(cluster_of_point) = product.shape {
                    assert_eq!(cluster_of_point.len(), positions_m.len(), "{}", detector.name());
                }
            }
        }
    }
}

#[test]
fn a_lone_point_is_reported_as_too_small_a_cluster() {
    let cloud = [[f32::NAN; 3], [5.0, 1.0, -1.0]].into_iter().collect();
    let found = detected(&mut kd_tree_over(ForegroundChoice::All, None), &cloud);
    let expected = DroppedCluster { n_points: 1, reason: DropReason::TooFewPoints };
    assert_eq!(found.dropped_clusters, [expected]);
}

#[test]
fn two_cars_on_a_road_are_two_vehicles() {
    let cars = [([8.0, 3.0], 0.3), ([-9.0, -4.0], -1.2)];
    let points = [road(), car(cars[0].0, cars[0].1), car(cars[1].0, cars[1].1)].concat();
    let cloud = points.into_iter().collect();
    check_found(&detected(&mut kd_tree_over(ForegroundChoice::Short, None), &cloud), &cars);
    check_found(&detected(&mut pca_by(None), &cloud), &cars);
    check_found(&detected(&mut simple_grid_by(None), &cloud), &cars);
}

/// Two cars side by side whose nearest sides are 40 cm apart, less than a coarse cell and two dense ones.
fn two_close_cars() -> PointCloud {
    [road(), car([8.0, 2.05], 0.0), car([8.0, 4.25], 0.0)].concat().into_iter().collect()
}

#[test]
fn what_the_dense_level_separates_the_simple_grid_joins() {
    let cloud = two_close_cars();
    // The detector of the papers with the foreground of the others.
    let mut shared = HierarchicalParams::shipped();
    shared.completion.enabled = false;
    let mut params = PaperParams::shipped();
    params.ground = shared.ground.clone();
    params.walls.as_printed = false;
    params.walls.min_support = shared.walls.min_support;
    params.foreground.clearance_m = shared.foreground.clearance_m;
    let mut of_papers = paper(&params, &shared, None, SENSOR_HEIGHT_M);
    check_found(&detected(&mut of_papers, &cloud), &[([8.0, 2.05], 0.0), ([8.0, 4.25], 0.0)]);
    let joined = detected(&mut simple_grid(&shared, ObjectModels::default(), SENSOR_HEIGHT_M), &cloud);
    let n_points: usize = joined.detections.iter().map(|it| it.point_indices.len()).sum();
    assert_eq!(joined.detections.len(), 1);
    let separate: usize =
        detected(&mut of_papers, &cloud).detections.iter().map(|it| it.point_indices.len()).sum();
    assert_eq!(n_points, separate, "the foreground is the same");
}

#[test]
fn the_simple_grid_has_one_level_whatever_the_parameters_say() {
    let detections_with = |xi| {
        let mut params = HierarchicalParams::shipped();
        params.grid.xi = xi;
        detected(&mut simple_grid(&params, ObjectModels::default(), SENSOR_HEIGHT_M), &two_close_cars())
            .detections
    };
    assert_eq!(detections_with(1), detections_with(5));
}

#[track_caller]
fn check_allocates_nothing(mut detector: impl Detector) {
    let cloud = two_close_cars();
    let mut output = DetectorOutput::default();
    let sizing = allocation_counter::measure(|| detector.detect(&cloud, &mut output));
    assert!(sizing.count_total > 0, "the counter sees nothing");
    for scan in [&cloud, &PointCloud::default(), &cloud] {
        let steady = allocation_counter::measure(|| detector.detect(scan, &mut output));
        assert_eq!(steady.count_total, 0, "allocations on a scan of {} points", scan.len());
    }
}

#[test]
fn grids_allocate_nothing_once_their_buffers_are_sized() {
    check_allocates_nothing(simple_grid_by(None));
    check_allocates_nothing(pca_by(None));
    check_allocates_nothing(pca_by(Some(PcaVehicleModel::shipped())));
}

#[test]
fn by_its_model_pca_says_how_sure_it_is() {
    let cloud = [road(), car([8.0, 3.0], 0.3)].concat().into_iter().collect();
    let by_size = detected(&mut pca_by(None), &cloud);
    let by_model = detected(&mut pca_by(Some(PcaVehicleModel::shipped())), &cloud);
    assert_eq!(by_size.detections.len(), 1);
    assert_eq!(
        (by_size.detections.get(0).score, by_size.detections.get(0).class),
        (None, DetectedClass::Vehicle)
    );
    let it = by_model.detections.get(0);
    let score = it.score.expect("the model decides");
    assert_eq!(score > 0.0, it.class == DetectedClass::Vehicle);
    assert_eq!(it.bounding_box, by_size.detections.get(0).bounding_box);
}

#[test]
fn the_whole_scan_with_a_road_is_one_cluster_that_is_too_large() {
    let points = [road(), car([8.0, 3.0], 0.3)].concat();
    let n_points = points.len();
    let mut detector = kd_tree_over(ForegroundChoice::All, None);
    let cloud = points.into_iter().collect();
    let found = detected(&mut detector, &cloud);
    assert!(found.detections.is_empty());
    assert_eq!(found.dropped_clusters, [DroppedCluster { n_points, reason: DropReason::TooManyPoints }]);
    let products = detector.stage_products(&cloud);
    let dropped = products.iter().find(|product| product.name == "dropped_clusters").unwrap();
    assert_eq!(dropped.shape, Shape::Clusters(vec![Some(0); n_points]));
}

#[test]
fn a_facade_is_too_large_for_the_occupancy_grid_and_the_car_before_it_is_found() {
    let facade = sides([0.0, 10.0], 0.0, [30.0, 0.1], [0.0, 6.0]);
    let points = [road(), car([8.0, 3.0], 0.3), facade].concat();
    let found = detected(&mut pca_by(None), &points.into_iter().collect());
    check_found(&found, &[([8.0, 3.0], 0.3)]);
    let reasons: Vec<DropReason> = found.dropped_clusters.iter().map(|dropped| dropped.reason).collect();
    assert_eq!(reasons, [DropReason::TooLarge]);
}

#[test]
fn over_all_that_stands_a_car_is_no_cluster_of_its_own_beside_a_facade() {
    let facade = sides([8.0, 5.3], 0.0, [30.0, 0.1], [0.0, 6.0]);
    let cloud: PointCloud = [road(), car([8.0, 4.0], 0.0), facade].concat().into_iter().collect();
    check_found(&detected(&mut kd_tree_over(ForegroundChoice::Short, None), &cloud), &[([8.0, 4.0], 0.0)]);
    let standing = detected(&mut kd_tree_over(ForegroundChoice::Standing, None), &cloud);
    let lengths_m: Vec<f32> =
        standing.detections.iter().map(|it| it.bounding_box.length_width_height_m[0]).collect();
    // The facade is drawn as rows of points, farther from each other than the tolerance.
    assert!(!lengths_m.is_empty());
    assert!(lengths_m.iter().all(|it| (29.0..31.0).contains(it)), "{lengths_m:?}");
}

#[test]
fn every_point_of_a_detection_is_its_own_and_drawn_with_its_cluster() {
    let points = [road(), car([8.0, 3.0], 0.3), car([-9.0, -4.0], -1.2)].concat();
    let cloud: PointCloud = points.into_iter().collect();
    for mut detector in every_detector() {
        let found = detected(detector.as_mut(), &cloud);
        let products = detector.stage_products(&cloud);
        let clusters = products.iter().find(|product| product.name == "clusters").unwrap();
        let mut expected = vec![None; cloud.len()];
        for (number, detection) in (0..).zip(found.detections.iter()) {
            assert!(detection.point_indices.is_sorted_by(|a, b| a < b), "{}", detector.name());
            for &point_idx in detection.point_indices {
                assert_eq!(expected[point_idx as usize].replace(number), None, "{}", detector.name());
            }
        }
        assert_eq!(clusters.shape, Shape::Clusters(expected), "{}", detector.name());
    }
}

#[test]
fn products_have_names_of_their_own_and_stages_that_were_timed() {
    let cloud: PointCloud = [road(), car([8.0, 3.0], 0.3)].concat().into_iter().collect();
    let with_models: [Box<dyn Detector>; 3] = [
        Box::new(kd_tree_over(ForegroundChoice::Short, Some(VehicleModel::shipped()))),
        Box::new(pca_by(Some(PcaVehicleModel::shipped()))),
        Box::new(simple_grid_by(Some(VehicleModel::shipped()))),
    ];
    for mut detector in every_detector().into_iter().chain(with_models) {
        let found = detected(detector.as_mut(), &cloud);
        let products = detector.stage_products(&cloud);
        let mut names: Vec<&str> = products.iter().map(|product| product.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), products.len(), "{}", detector.name());
        for product in &products {
            let was_timed = found.stage_times.iter().any(|it| it.stage == product.stage);
            assert!(was_timed, "{} of {}", product.stage, detector.name());
        }
    }
}

#[test]
fn a_scan_gives_the_same_whatever_came_before() {
    let scans = [
        [road(), car([8.0, 3.0], 0.3)].concat(),
        Vec::new(),
        [road(), car([-9.0, -4.0], -1.2), car([5.0, 0.0], 1.0)].concat(),
    ];
    let fresh = every_detector();
    for (index, mut detector) in fresh.into_iter().enumerate() {
        for scan in &scans {
            let cloud = scan.iter().copied().collect();
            let mut again = detected(detector.as_mut(), &cloud);
            let mut first = detected(every_detector()[index].as_mut(), &cloud);
            (again.stage_times, first.stage_times) = (Vec::new(), Vec::new());
            assert_eq!(again, first, "{}", detector.name());
        }
    }
}

/// The points of each of these groups of the latest scan, all in order.
fn points_of_groups(grouping: &Pipeline<Groups>, is_asked: impl Fn(&Node) -> bool) -> Vec<Vec<u32>> {
    let Groups { tree, dense, candidates, .. } = &grouping.frame.clustering;
    let points_of = |node: &Node| -> Vec<u32> {
        let cells = tree.cells(node);
        let points = candidates.point_indices().iter().zip(dense.dense_of_point());
        points.filter(|(_, dense_idx)| cells.contains(dense_idx)).map(|(&it, _)| it).collect()
    };
    let mut groups: Vec<Vec<u32>> = tree.nodes().iter().filter(|it| is_asked(it)).map(points_of).collect();
    groups.sort();
    groups
}

#[test]
fn components_within_components_are_those_of_each_tolerance() {
    // Posts in pairs that are ever farther apart, a crown over a car, and two cars.
    let post = |[x_m, y_m]: [f32; 2]| steps(-1.4, -0.2, 12).map(move |z_m| [x_m, y_m, z_m]);
    let pairs = (0..8_u8).flat_map(|it| {
        let (x_m, apart_m) = (-12.0 + 3.0 * f32::from(it), 0.25 + 0.13 * f32::from(it));
        post([x_m, -6.0]).chain(post([x_m + apart_m, -6.0]))
    });
    let crown = steps(7.0, 9.0, 20).flat_map(|x_m| steps(1.0, 3.0, 20).map(move |y_m| [x_m, y_m, 0.9]));
    let cloud: PointCloud =
        [road(), pairs.collect(), crown.collect(), car([8.0, 2.05], 0.0), car([8.0, 4.25], 0.0)]
            .concat()
            .into_iter()
            .collect();
    let shared = HierarchicalParams::shipped();
    let grouped = |linkage: KdTreeLinkage| {
        let mut grouping = component_groups(linkage, &shared, SENSOR_HEIGHT_M);
        detected(&mut grouping, &cloud);
        grouping
    };
    let nested = grouped(KdTreeLinkage::nested());
    let mut n_groups = Vec::new();
    for (level, &tolerance_m) in NESTED_TOLERANCES_M.iter().enumerate() {
        let flat = grouped(KdTreeLinkage::at(tolerance_m));
        let at_level = |it: &Node| usize::from(it.level) <= level && usize::from(it.joined_at) > level;
        let components = points_of_groups(&flat, |_| true);
        assert_eq!(points_of_groups(&nested, at_level), components, "at {tolerance_m} m");
        n_groups.push(components.len());
    }
    assert!(n_groups.is_sorted_by(|a, b| a >= b) && n_groups[0] > n_groups[9] + 5, "{n_groups:?}");
}

#[test]
fn rivals_with_training_find_cars_and_say_how_sure_they_are() {
    let cars = [([8.0, 3.0], 0.3), ([-9.0, -4.0], -1.2)];
    let cloud = [road(), car(cars[0].0, cars[0].1), car(cars[1].0, cars[1].1)].concat().into_iter().collect();
    let shared = HierarchicalParams::shipped();
    let components = TrainedComponents::shipped();
    let models = |groups| GroupModels { groups, vehicles: VehiclesBy::Model, boxes: None };
    let tolerance_m = components.tolerance_m(None);
    let trained = kd_tree_trained(&shared, tolerance_m, models(components.judge), SENSOR_HEIGHT_M);
    let tree = kd_tree_tree(&shared, models(shipped_tree()), SENSOR_HEIGHT_M);
    for mut detector in [trained, tree] {
        let found = detected(&mut detector, &cloud);
        assert_eq!(found.detections.len(), 2, "{}", detector.name());
        assert!(found.detections.iter().all(|it| it.score.is_some()), "{}", detector.name());
        let nothing = detected(&mut detector, &road().into_iter().collect());
        assert!(nothing.detections.is_empty(), "{}", detector.name());
    }
}
