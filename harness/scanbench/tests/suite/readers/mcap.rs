//! MCAP recordings as others write them: ROS 2 messages, JSON, several topics, frames, cuts and damage.

use mcap::WriteOptions;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::PointRegion;
use scans::dataset::DatasetError;
use scans::dataset::source::{DamagePolicy, TopicChoice};
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

use super::recordings::{
    CLOUD, Cdr, DETECTIONS, Logged, POSITIONS_M, SECOND, TRANSFORMS, category, cloud_at, detections,
    foxglove_messages, organised_cloud, transforms, write, write_drive, write_options,
};
use super::{check_damaged, open, try_open};
use crate::program::Workplace;

#[test]
fn a_cloud_of_ros_is_read_whatever_its_layout() {
    for (options, is_big_endian) in write_options().into_iter().zip([false, true, false, true, false]) {
        let workplace = Workplace::new();
        let messages = [1, 2, 3].map(|second| {
            let time_ns = second * SECOND;
            ("/top", CLOUD, "cdr", time_ns, organised_cloud(time_ns, "lidar", is_big_endian))
        });
        let dataset = open(&write(&workplace, options, &messages));
        assert_eq!(
            (dataset.scan_ids().len(), dataset.scan_ids()[2].to_string()),
            (3, "drive/000002".to_owned())
        );
        assert_eq!(dataset.scan_time_ns(1), Some(2 * SECOND));
        let scan = dataset.read_scan(1).unwrap();
        // The third point has no position.
        assert!(scan.cloud.positions_m().eq([0, 1, 3].map(|index| POSITIONS_M[index])), "{:?}", scan.cloud);
        assert_eq!((scan.cloud.intensity(), &scan.points_left_out[..]), (&[300.0; 3][..], &[2][..]));
        assert_eq!((scan.cloud.ring(), scan.cloud.time_offset_s()), (Some(&[0xbb; 3][..]), None));
        // Nobody labelled anything.
        assert_eq!((scan.annotations.len(), scan.point_regions), (0, vec![PointRegion::Outside; 3]));
        assert_eq!(dataset.world_from_sensor(1).unwrap(), None);
    }
}

#[test]
fn moments_of_points_and_the_stamp_are_distinguished_in_whatever_unit() {
    // The points of one row, of which each has its moment as `f64`.
    let cloud = |stamp_ns: u64, moments: [f64; 2]| {
        let data: Vec<u8> = moments
            .iter()
            .flat_map(|it| {
                let position = [5.0_f32, 1.0, -1.0].into_iter().flat_map(f32::to_le_bytes);
                position.chain(it.to_le_bytes()).collect::<Vec<u8>>()
            })
            .collect();
        let mut cdr = Cdr::new(false);
        cdr.header(stamp_ns, "lidar").u32(1).u32(2).u32(4);
        for (name, offset, number) in [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("timestamp", 12, 8)] {
            cdr.text(name).u32(offset).u8(number).u32(1);
        }
        cdr.u8(0).u32(20).u32(40).data(&data).u8(0);
        cdr.bytes
    };
    let stamp_s = 1_700_000_000.0;
    let check = |moments: [f64; 2], expected: Option<[f32; 2]>| {
        let workplace = Workplace::new();
        let stamp_ns = 1_700_000_000 * SECOND;
        let messages = [("/top", CLOUD, "cdr", stamp_ns, cloud(stamp_ns, moments))];
        let scan = open(&write(&workplace, WriteOptions::new(), &messages)).read_scan(0).unwrap();
        match (scan.cloud.time_offset_s(), expected) {
            (Some(found), Some(expected)) => {
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
            }
            (found, expected) => assert_eq!((found, expected), (None, None)),
        }
    };
    check([stamp_s - 0.05, stamp_s + 0.05], Some([-0.05, 0.05]));
    check([1e9 * (stamp_s - 0.05), 1e9 * (stamp_s + 0.05)], Some([-0.05, 0.05]));
    // Microseconds, since the sensor was switched on, and not at all.
    check([1e6 * stamp_s; 2], None);
    check([12.0, 12.1], None);
    check([stamp_s, f64::NAN], None);
}

#[test]
fn boxes_of_another_frame_are_carried_over() {
    let workplace = Workplace::new();
    let dataset = open(&write_drive(&workplace, WriteOptions::new()));
    let scan = dataset.read_scan(1).unwrap();
    let [annotation] = &scan.annotations[..] else { panic!("{:?}", scan.annotations) };
    assert_eq!((annotation.class, annotation.track), (AnnotationClass::Car, Some(17)));
    // Halfway between 20 and 30 m the sensor is at (25, 1) and looks along y: the box is 5 m ahead.
    let bounding_box = annotation.bounding_box.unwrap();
    for (found, expected) in bounding_box.center_m.into_iter().zip([5.0, 0.0, -0.7]) {
        assert!((found - expected).abs() < 1e-5, "{bounding_box:?}");
    }
    assert!(bounding_box.yaw_rad.abs() < 1e-6 && bounding_box.length_width_height_m == [4.0, 2.0, 1.5]);
    assert_eq!(annotation.point_indices, [0, 1]);
    assert_eq!(scan.point_regions, [PointRegion::Labeled; 3]);
    let at = dataset.world_from_sensor(1).unwrap().unwrap().translation.vector;
    assert!((at - nalgebra::Vector3::new(25.0, 1.0, 0.0)).norm() < 1e-9, "{at}");
}

#[test]
fn foxglove_in_json_is_read() {
    let workplace = Workplace::new();
    let messages = foxglove_messages(SECOND, &category("REGULAR_VEHICLE"));
    let scan = open(&write(&workplace, WriteOptions::new(), &messages)).read_scan(0).unwrap();
    let [car] = &scan.annotations[..] else { panic!("{:?}", scan.annotations) };
    // The origin is the sensor's, which is at (1, 0, 2) in the frame.
    assert_eq!(car.bounding_box.unwrap().center_m, [5.0, 1.0, -1.0]);
    assert_eq!((car.class, &car.point_indices[..]), (AnnotationClass::Car, &[0][..]));
}

#[test]
fn of_several_topics_one_is_chosen() {
    let workplace = Workplace::new();
    let rear = ("/rear", CLOUD, "cdr", SECOND, organised_cloud(SECOND, "rear", false));
    let path = write(&workplace, WriteOptions::new(), &[cloud_at(SECOND), cloud_at(2 * SECOND), rear]);
    let error = try_open(&path).err().expect("several topics");
    assert!(error.is_usage_error());
    let message = error.to_string();
    for part in
        ["--topic", "/rear (sensor_msgs/msg/PointCloud2, 1 messages)", "/top (sensor_msgs/msg/PointCloud2, 2"]
    {
        assert!(message.contains(part), "{message}");
    }
    let topics = TopicChoice { cloud: Some("/rear".to_owned()), annotations: None };
    let options = OpenOptions { topics, ..OpenOptions::default() };
    let dataset = open_dataset(path.to_str().unwrap(), &options, &built_in_catalogue().unwrap()).unwrap();
    assert_eq!(dataset.scan_ids().len(), 1);
    // The option reaches the program.
    workplace.succeed("detect drive.mcap --scan 0 --topic /rear");
}

fn open_skipping(path: &std::path::Path) -> Result<Box<dyn scans::dataset::Dataset>, DatasetError> {
    let options = OpenOptions { damage: DamagePolicy::Skip, ..OpenOptions::default() };
    open_dataset(path.to_str().unwrap(), &options, &built_in_catalogue().unwrap())
}

#[test]
fn a_recording_that_was_cut_off_is_refused_or_read_to_the_cut() {
    let workplace = Workplace::new();
    let messages: Vec<Logged> = (1..20).map(|second| cloud_at(second * SECOND)).collect();
    let path = write(&workplace, WriteOptions::new().chunk_size(Some(100)).compression(None), &messages);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    check_damaged(&path, &["drive.mcap", "is cut off"]);
    let dataset = open_skipping(&path).unwrap();
    let n_scans = dataset.scan_ids().len();
    assert!((5..15).contains(&n_scans), "{n_scans}");
    (0..n_scans).for_each(|scan_idx| assert_eq!(dataset.read_scan(scan_idx).unwrap().cloud.len(), 3));
}

#[test]
fn damage_is_named() {
    let check = |cloud: Vec<u8>, parts: &[&str]| {
        let workplace = Workplace::new();
        let messages = [cloud_at(SECOND), ("/top", CLOUD, "cdr", 2 * SECOND, cloud)];
        let path = write(&workplace, WriteOptions::new(), &messages);
        check_damaged(&path, &[&["drive.mcap", "logged at 2000000000 ns"], parts].concat());
    };
    let sound = organised_cloud(SECOND, "lidar", false);
    check(sound[..40].to_vec(), &["CDR message that needs"]);
    let changed = |position: usize, value: u8| {
        let mut cloud = sound.clone();
        cloud[position] = value;
        cloud
    };
    check(changed(1, 9), &["unknown representation 0009"]);
    // Rows and columns follow stamp and frame: 4 + 8 + 4 + 6 + 2 bytes on.
    check(changed(27, 255), &["announces 4278190082 x 2 points"]);
    check(changed(31, 255), &["announces 2 x 4278190082 points"]);
    check_damaged(
        &{
            let workplace = Box::leak(Box::new(Workplace::new()));
            let path = write(workplace, WriteOptions::new(), &[cloud_at(SECOND)]);
            let mut bytes = std::fs::read(&path).unwrap();
            // Within the compressed records of the first chunk.
            bytes[120] ^= 0xff;
            std::fs::write(&path, bytes).unwrap();
            path
        },
        &["drive.mcap", "chunk"],
    );
}

#[test]
fn a_file_that_is_no_recording_is_refused() {
    let workplace = Workplace::new();
    workplace.write("drive.mcap", "no recording");
    let error = try_open(&workplace.path("drive.mcap")).err().expect("no recording");
    assert!(error.to_string().contains("has no data set in a known format"), "{error}");
}

const MS: u64 = SECOND / 1000;

/// A delay of each message of a stream, by its number.
type Delay = fn(u64) -> u64;

/// Clouds and labels that are taken together, `period_ms` apart; the box of each label says in metres which it is.
fn labelled_clouds(period_ms: u64, [of_clouds, of_labels]: [Delay; 2], is_json: bool) -> Vec<Logged> {
    let messages = |number: u64| {
        let stamp_ns = 100 * SECOND + number * period_ms * MS;
        let [cloud_ns, labels_ns] = [of_clouds, of_labels].map(|delay_ms| stamp_ns + delay_ms(number) * MS);
        if is_json {
            let [cloud, scene] = foxglove_messages(stamp_ns, &category("car"));
            let scene =
                String::from_utf8(scene.4).unwrap().replace("\"x\":6.0", &format!("\"x\":{number}.0"));
            return [
                (cloud.0, cloud.1, cloud.2, cloud_ns, cloud.4),
                ("/scene", "foxglove.SceneUpdate", "json", labels_ns, scene.into_bytes()),
            ];
        }
        let labels = detections(stamp_ns, "lidar", [number as f64, 0.0, 0.0], 0.0);
        [
            ("/top", CLOUD, "cdr", cloud_ns, organised_cloud(stamp_ns, "lidar", false)),
            ("/labels", DETECTIONS, "cdr", labels_ns, labels),
        ]
    };
    (0..12).flat_map(messages).collect()
}

#[test]
fn labels_belong_to_the_cloud_of_their_stamp_whenever_both_were_logged() {
    let none: Delay = |_| 0;
    let sweep: Delay = |_| 100;
    let jitter: Delay = |number| 90 + number * 7919 % 37;
    let swapped: Delay = |number| if number % 2 == 0 { 260 } else { 20 };
    let late: Delay = |_| 5_000;
    for period_ms in [50, 100] {
        for delays in [
            [none, none],
            [sweep, none],
            [sweep, sweep],
            [sweep, late],
            [jitter, none],
            [none, jitter],
            [jitter, swapped],
            [swapped, late],
        ] {
            for is_json in [false, true] {
                let workplace = Workplace::new();
                let mut messages = labelled_clouds(period_ms, delays, is_json);
                // In another order than they were logged in.
                messages.rotate_left(7);
                let dataset = open(&write(&workplace, WriteOptions::new(), &messages));
                let mut numbers = std::collections::BTreeSet::new();
                for scan_idx in 0..12 {
                    let time_ns = dataset.scan_time_ns(scan_idx).unwrap();
                    let number = (time_ns - 100 * SECOND) / (period_ms * MS);
                    let scan = dataset.read_scan(scan_idx).unwrap();
                    let [label] = &scan.annotations[..] else {
                        panic!("scan {scan_idx}, {period_ms} ms: {scan:?}")
                    };
                    let x_m = label.bounding_box.unwrap().center_m[0] + if is_json { 1.0 } else { 0.0 };
                    assert_eq!(x_m.round() as u64, number, "scan {scan_idx}, {period_ms} ms");
                    numbers.insert(number);
                }
                assert_eq!((numbers.len(), dataset.oddities().unwrap()), (12, Vec::new()));
            }
        }
    }
}

#[test]
fn without_stamps_labels_go_by_log_times_and_verbs_say_so() {
    let workplace = Workplace::new();
    let messages: Vec<Logged> = (0..6)
        .flat_map(|number| {
            let time_ns = 100 * SECOND + number * 100 * MS;
            let labels = detections(0, "lidar", [number as f64, 0.0, 0.0], 0.0);
            [
                ("/top", CLOUD, "cdr", time_ns + 100 * MS, organised_cloud(time_ns, "lidar", false)),
                ("/labels", DETECTIONS, "cdr", time_ns + 110 * MS, labels),
            ]
        })
        .collect();
    let dataset = open(&write(&workplace, WriteOptions::new(), &messages));
    for scan_idx in 0..6 {
        let labels = dataset.read_scan(scan_idx).unwrap().annotations;
        assert_eq!(labels[0].bounding_box.unwrap().center_m[0], scan_idx as f32);
    }
    let said = "labels are paired with clouds by when they were logged, since labels have no time stamps";
    workplace.succeed("data check drive.mcap").check_stdout(&[said]);
    workplace
        .run("run drive.mcap -d pca --no-rrd -o run")
        .check_stderr(&[&format!("warning: labels of \"drive\": {said}")]);
}

#[test]
fn poses_are_those_of_the_stamp_of_the_cloud() {
    let workplace = Workplace::new();
    let mut messages: Vec<Logged> = Vec::new();
    // The car drives 10 m a second. Clouds come five seconds late, transforms at once.
    for number in 0..1200 {
        let stamp_ns = 100 * SECOND + number * 10 * MS;
        let pose = transforms(stamp_ns, "map", "lidar", 0.1 * number as f64, 0.0);
        messages.push(("/tf", TRANSFORMS, "cdr", stamp_ns + MS, pose));
        if number % 100 == 0 {
            let labels = detections(stamp_ns, "map", [0.1 * number as f64 + 5.0, 0.0, 0.0], 0.0);
            messages.push(("/labels", DETECTIONS, "cdr", stamp_ns + 9 * SECOND, labels));
            let cloud = organised_cloud(stamp_ns, "lidar", false);
            messages.push(("/top", CLOUD, "cdr", stamp_ns + 5 * SECOND, cloud));
        }
    }
    messages.sort_by_key(|it| it.3);
    let dataset = open(&write(&workplace, WriteOptions::new(), &messages));
    for scan_idx in 0..12 {
        let at = dataset.world_from_sensor(scan_idx).unwrap().unwrap().translation.x;
        assert!((at - 10.0 * scan_idx as f64).abs() < 1e-6, "scan {scan_idx}: {at}");
        let labels = dataset.read_scan(scan_idx).unwrap().annotations;
        let x_m = labels[0].bounding_box.unwrap().center_m[0];
        assert!((x_m - 5.0).abs() < 1e-4, "scan {scan_idx}: {x_m}");
    }
}

/// A cloud of ROS with a width of 0 and without fields, as nodes send where nothing was measured.
fn placeholder(stamp_ns: u64) -> Vec<u8> {
    let mut cdr = Cdr::new(false);
    cdr.header(stamp_ns, "lidar").u32(1).u32(0).u32(0).u8(0).u32(0).u32(0).data(&[]).u8(1);
    cdr.bytes
}

#[test]
fn a_placeholder_is_an_empty_scan_and_its_labels_are_not_suspect() {
    let workplace = Workplace::new();
    let mut messages = labelled_clouds(100, [|_| 0, |_| 0], false);
    for message in messages.iter_mut().filter(|it| it.0 == "/top").take(9) {
        message.4 = placeholder(message.3);
    }
    // Around the points of the others.
    for message in messages.iter_mut().filter(|it| it.0 == "/labels") {
        message.4 = detections(message.3, "lidar", [5.0, 1.0, -0.75], 0.0);
    }
    let dataset = open(&write(&workplace, WriteOptions::new(), &messages));
    let n_points: Vec<usize> = (0..12).map(|it| dataset.read_scan(it).unwrap().cloud.len()).collect();
    assert_eq!(n_points, [[0; 9].as_slice(), &[3; 3]].concat());
    assert_eq!(dataset.read_scan(0).unwrap().annotations.len(), 1);
    let checked = workplace.succeed("data check drive.mcap");
    checked.check_stdout(&["9 of 12 scans without a point that has a position, first drive/000000"]);
    let run = workplace.run("run drive.mcap -d hierarchical,pca,kd-tree --no-rrd -o run");
    run.check_stderr(&["warning: 9 scans of \"drive\" have no points, first drive/000000"]);
    for said in [&checked.stdout, &run.stderr] {
        assert!(!said.contains("contain no point") && !said.contains("hold no point"), "{said}");
    }
    workplace.succeed("detect drive.mcap --scan 0");
    // They go on as they are, but not to files that cannot say it.
    workplace.succeed("data convert drive.mcap -o again.mcap");
    let again = open(&workplace.path("again.mcap"));
    assert_eq!((again.read_scan(0).unwrap().cloud.len(), again.read_scan(11).unwrap().cloud.len()), (0, 3));
    let refused = "scan drive/000000 cannot be written as .bin: it has no points";
    workplace.refuse("data convert drive.mcap --to kitti-tracking -o again", 2, &[refused]);
    // Foxglove's, without fields and bytes of a point.
    let empty = r#"{"timestamp": {"sec": 1, "nsec": 0}, "frame_id": "base", "point_stride": 0, "fields": [], "data": ""}"#;
    let message = ("/points", "foxglove.PointCloud", "json", SECOND, empty.as_bytes().to_vec());
    let dataset = open(&write(&workplace, WriteOptions::new(), &[message]));
    assert_eq!(dataset.read_scan(0).unwrap().cloud.len(), 0);
}
