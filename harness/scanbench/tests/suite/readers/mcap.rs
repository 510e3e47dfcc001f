//! MCAP recordings as others write them: ROS 2 messages, JSON, several topics, frames, cuts and damage.

use mcap::WriteOptions;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::PointRegion;
use scans::dataset::DatasetError;
use scans::dataset::source::{DamagePolicy, TopicChoice};
use simulator::catalogue::built_in_catalogue;
use simulator::open::{OpenOptions, open_dataset};

use super::recordings::{
    CLOUD, Cdr, Logged, POSITIONS_M, SECOND, category, cloud_at, foxglove_messages, organised_cloud, write,
    write_drive, write_options,
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
