//! `scanbench detect`: the clusters of a scan as other programs get them.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use test_data::test_data;

use crate::program::Workplace;

const SCAN: &str = "street/training/velodyne/0000/000001.bin";

/// The numbers of a file of little-endian u32.
fn read_u32(path: &Path) -> Vec<u32> {
    let bytes = std::fs::read(path).unwrap();
    let (numbers, rest) = bytes.as_chunks::<4>();
    assert!(rest.is_empty(), "{}: {} bytes", path.display(), bytes.len());
    numbers.iter().map(|it| u32::from_le_bytes(*it)).collect()
}

/// The second column of `point,cluster`, whose first one counts the rows; `None` for 0.
fn read_clusters(csv: &str) -> Vec<Option<u32>> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("point,cluster"));
    let cluster = |(point_idx, line): (usize, &str)| {
        let (point, cluster) = line.split_once(',').unwrap();
        assert_eq!(point.parse(), Ok(point_idx));
        Some(cluster.parse().unwrap()).filter(|it| *it != 0)
    };
    lines.enumerate().map(cluster).collect()
}

fn drive() -> Workplace {
    Workplace::with_drive(3)
}

#[test]
fn a_spent_budget_of_groups_is_said() {
    let workplace = drive();
    let spent = ["-P", "grouping.cuts.max_groups=0"];
    let detect = ["detect", SCAN, "--sensor", "hdl-64e-s2"];
    let warning =
        "warning: hierarchical had more groups to cut than its budget, grouping.cuts.max_groups, in ";
    workplace.succeed(&(&detect, &spent)).check_stderr(&[warning]);
    assert_eq!(workplace.succeed(&detect).stderr, "");
    let run = ["run", "street", "-d", "hierarchical,kd-tree", "--no-rrd", "-o", "out", "--overwrite"];
    let ended = workplace.succeed(&(&run, &spent));
    assert_eq!(ended.stderr.matches(warning).count(), 1, "{ended:#?}");
    assert!(!workplace.succeed(&run).stderr.contains("budget"));
}

#[test]
fn both_forms_of_the_clusters_say_the_same_and_the_boxes_count_them() {
    let workplace = drive();
    // By size, because the drawn cars are blocks, which the trained model takes for none.
    let by_size = ["-P", "vehicle_model.enabled=false", "--sensor", "hdl-64e-s2"];
    let written = ["detect", SCAN, "-o", "clusters.csv", "--boxes", "boxes.csv"];
    let csv = workplace.succeed(&(&written, &by_size));
    let binary = workplace.succeed(&["detect", SCAN, "-o", "clusters.u32", "--sensor", "hdl-64e-s2"]);
    let clusters = read_clusters(&workplace.read("clusters.csv"));
    let in_binary = read_u32(&workplace.path("clusters.u32"));
    assert!(clusters.iter().map(|it| it.unwrap_or(0)).eq(in_binary));
    assert_eq!(clusters.len() * 16, std::fs::read(workplace.path(SCAN)).unwrap().len());

    let mut n_points: BTreeMap<u32, usize> = BTreeMap::new();
    for cluster in clusters.iter().flatten() {
        *n_points.entry(*cluster).or_default() += 1;
    }
    let boxes = workplace.read("boxes.csv");
    let mut lines = boxes.lines();
    let head = "id,class,score,center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad,n_points,\
                box_score,seen_sides,front_sure,unlikely";
    assert_eq!(lines.next(), Some(head));
    let counted = lines.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells[1], "vehicle", "{line}");
        (cells[0].parse().unwrap(), cells[10].parse().unwrap())
    });
    assert_eq!(counted.collect::<BTreeMap<u32, usize>>(), n_points);
    assert_eq!(n_points.keys().collect::<Vec<_>>(), [&1, &2], "two cars are drawn");

    csv.check_stdout(&["hierarchical: 2 clusters of ", "\nwhole "]);
    assert_eq!((csv.stderr, binary.stderr), (String::new(), String::new()));
    assert_eq!(workplace.top_names(), ["boxes.csv", "clusters.csv", "clusters.u32", "street"]);
}

#[test]
fn a_whole_box_says_which_of_its_sides_are_seen_and_one_of_what_is_seen_does_not() {
    let workplace = drive();
    let by_size =
        ["detect", SCAN, "--boxes", "-", "-P", "vehicle_model.enabled=false", "--sensor", "hdl-64e-s2"];
    let last_cells = |options: &[&str]| -> Vec<Vec<String>> {
        let boxes = workplace.succeed(&(&by_size, options)).stdout;
        boxes.lines().skip(1).map(|it| it.split(',').skip(11).take(3).map(str::to_owned).collect()).collect()
    };
    let whole = last_cells(&[]);
    assert_eq!(whole.len(), 2);
    for cells in &whole {
        assert!(cells[0].parse::<f32>().is_ok(), "{whole:?}");
        assert!(["rear", "front", "left", "right"].iter().any(|it| cells[1].contains(it)), "{whole:?}");
        assert!(["true", "false"].contains(&cells[2].as_str()), "{whole:?}");
    }
    assert_eq!(last_cells(&["-P", "boxes.whole=false"]), [["", "", ""], ["", "", ""]]);
}

#[test]
fn what_goes_to_stdout_is_alone_there() {
    let workplace = drive();
    let ended = workplace.succeed(&["detect", SCAN, "-o", "-", "--boxes", "boxes.csv"]);
    assert_eq!(read_clusters(&ended.stdout).iter().flatten().collect::<BTreeSet<_>>().len(), 2);
    assert!(ended.stderr.starts_with(SCAN), "{ended:#?}");
    let boxes = workplace.succeed(&["detect", SCAN, "--boxes", "-"]);
    assert_eq!(boxes.stdout, workplace.read("boxes.csv"));
}

#[test]
fn a_scan_of_a_data_set_is_that_of_its_file() {
    let workplace = drive();
    let boxes = |input: &[&str]| {
        let arguments: Vec<&str> = ["detect", "--boxes", "-"].iter().chain(input).copied().collect();
        workplace.succeed(&arguments).stdout
    };
    let of_file = boxes(&[SCAN]);
    for id in ["1", "0000/1", "0000/000001"] {
        assert_eq!(boxes(&["street", "--scan", id]), of_file, "{id}");
    }
    assert_ne!(boxes(&["street", "--scan", "0"]), of_file);
}

#[test]
fn an_earlier_file_is_replaced_whole() {
    let workplace = drive();
    workplace.write("clusters.u32", "an earlier one");
    workplace.succeed(&["detect", SCAN, "-o", "clusters.u32"]);
    assert!(read_u32(&workplace.path("clusters.u32")).len() > 1000);
}

#[test]
fn parameters_and_sensor_height_change_what_is_found() {
    let workplace = drive();
    let n_found = |arguments: &[&str]| {
        let all: Vec<&str> = ["detect", SCAN, "--boxes", "-"].iter().chain(arguments).copied().collect();
        workplace.succeed(&all).stdout.lines().count() - 1
    };
    assert_eq!(n_found(&[]), 2);
    assert_eq!(n_found(&["-P", "cluster.min_points=100000", "-P", "cluster.min_vehicle_points=100000"]), 0);
    workplace
        .write("mine.toml", "hierarchical.cluster = { min_points = 100000, min_vehicle_points = 100000 }");
    assert_eq!(n_found(&["-c", "mine.toml"]), 0);
    // An object that the model classifies as a vehicle counts from fewer points on than another object.
    let of_street = |min_vehicle_points: &str| {
        let points = format!("cluster.min_vehicle_points={min_vehicle_points}");
        let street = "street-narrow --scan narrow-803595/000000 --boxes - -c mine.toml -P";
        workplace.succeed(&("detect", street, &points)).stdout.lines().count() - 1
    };
    assert!(of_street("10") > 0 && of_street("100000") == 0);
    let few = ["-P", "cluster.min_points=10", "-P", "cluster.min_vehicle_points=10"];
    assert_eq!(n_found(&[&["-c", "mine.toml"], &few[..]].concat()), 2);
    // Everything is one component of the kd-tree: the cars stand on the road.
    assert_eq!(n_found(&["-d", "kd-tree", "-P", "foreground=all"]), 1);
    // What it knows is a road at another height, above which it sees no cars.
    let boxes =
        |height: &str| workplace.succeed(&["detect", SCAN, "--boxes", "-", "--sensor-height", height]).stdout;
    assert_ne!(boxes("6"), boxes("1.73"));
}

#[test]
fn several_detections_have_a_least_and_a_median_time() {
    let workplace = drive();
    let ended = workplace.succeed(&["detect", SCAN, "--repeat", "5"]);
    let times = ended.stdout.lines().find(|line| line.starts_with("whole ")).unwrap();
    let times: Vec<f64> = times.split_whitespace().skip(1).map(|it| it.parse().unwrap()).collect();
    assert!(times.len() == 2 && times[0] > 0.0 && times[0] <= times[1], "{ended:#?}");
}

#[test]
fn a_simulated_scan_is_called_so() {
    let workplace = Workplace::new();
    let arguments =
        ["detect", "street-narrow", "--scan", "narrow-7/200", "--seed", "7", "--sensor", "vlp-16"];
    let ended = workplace.succeed(&arguments);
    let head = "street-narrow (simulated), scan narrow-7/000200: ";
    assert!(ended.stdout.starts_with(head) && ended.stdout.contains(" clusters of "), "{ended:#?}");
}

/// What PCL 1.13 makes of the foreground of a real scan: for every point the smallest point of its component.
#[test]
#[ignore = "needs oracle/obj_000001_fg.bin and oracle/sk00_000000_fg.bin in SCANBENCH_TEST_DATA"]
fn the_kd_tree_gives_the_components_of_pcl() {
    let folder = test_data("oracle");
    for scan in ["obj_000001", "sk00_000000"] {
        for tolerance in ["0.3", "0.5", "0.7"] {
            let workplace = Workplace::new();
            let points = folder.join(format!("{scan}_fg.bin"));
            let tolerance_m = format!("tolerance_m={tolerance}");
            let mut arguments =
                vec!["detect", points.to_str().unwrap(), "-d", "kd-tree", "-o", "clusters.u32"];
            for parameter in ["foreground=all", &tolerance_m, "min_points=1", "max_points=1000000"] {
                arguments.extend(["-P", parameter]);
            }
            workplace.succeed(&arguments);
            let ours = read_u32(&workplace.path("clusters.u32"));
            let theirs = read_u32(&folder.join(format!("{scan}_labels_tol{tolerance}.u32")));
            let mut first_point: BTreeMap<u32, u32> = BTreeMap::new();
            for (cluster, point_idx) in ours.iter().zip(0..) {
                first_point.entry(*cluster).or_insert(point_idx);
            }
            let relabelled: Vec<u32> = ours.iter().map(|cluster| first_point[cluster]).collect();
            assert!(!ours.contains(&0) && relabelled == theirs, "{scan} at {tolerance} m differs from PCL");
        }
    }
}
