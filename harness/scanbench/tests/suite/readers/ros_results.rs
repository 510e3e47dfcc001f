//! What other programs found, in messages of ROS 2.

use mcap::WriteOptions;
use reports::vocabulary::class::AnnotationClass;
use scans::foreign::detections::ForeignBox;
use scans::foreign::foreign_results::MissingResults;

use super::foreign_results::{check_refused, check_same_boxes, read_all, try_results};
use super::{open, recordings};
use crate::program::Workplace;

#[test]
fn detections_of_ros_are_carried_into_the_frame_of_the_cloud() {
    let workplace = Workplace::new();
    let path = recordings::write_drive(&workplace, WriteOptions::new());
    let dataset = open(&path);
    let found = read_all(&path, &*dataset).unwrap();
    for (scan_idx, found) in found.iter().enumerate() {
        let annotation = &dataset.read_scan(scan_idx).unwrap().annotations[0];
        let expected = ForeignBox {
            bounding_box: annotation.bounding_box.unwrap(),
            class: Some(AnnotationClass::Car.into()),
            score: Some(0.7),
            box_score: None,
            velocity_m_per_s: None,
            is_unlikely: false,
        };
        check_same_boxes(found, &[expected]);
    }
    let topic = workplace.path("drive.mcap:/labels");
    assert_eq!(read_all(&topic, &*dataset).unwrap(), found);
    let other = workplace.path("drive.mcap:/others");
    check_refused(&other, &*dataset, true, &["has no objects on the topic \"/others\"", "/labels ("]);
    // A recording of other moments.
    let elsewhere = Workplace::new();
    let late = [1, 2, 3].map(|it| recordings::found_at(it * recordings::SECOND, "lidar", [5.0, 0.0, 0.0]));
    let late = recordings::write(&elsewhere, WriteOptions::new(), &late);
    check_refused(
        &late,
        &*dataset,
        false,
        &["has no results for 3 of 3 scans", "it has others: 1000000000 ns"],
    );
}

#[test]
fn a_message_of_results_is_that_of_one_scan() {
    let millisecond = recordings::SECOND / 1000;
    let write = |found_ms: &[u64]| {
        let workplace = Workplace::new();
        let messages: Vec<recordings::Logged> = found_ms
            .iter()
            .map(|it| {
                recordings::found_at(recordings::SECOND + it * millisecond, "lidar", [*it as f64, 0.0, 0.0])
            })
            .collect();
        let path = recordings::write(&workplace, WriteOptions::new(), &messages);
        (workplace, path)
    };
    let clouds = Workplace::new();
    let at = [0, 40, 80].map(|it| recordings::cloud_at(recordings::SECOND + it * millisecond));
    let dataset = open(&recordings::write(&clouds, WriteOptions::new(), &at));
    let found_at = |found_ms: &[u64]| -> Vec<Option<f32>> {
        let (_workplace, path) = write(found_ms);
        let mut results = try_results(&path, &*dataset, MissingResults::AreEmpty).unwrap();
        let mut of_scan = |scan_idx| {
            let found = results.read(&dataset.read_scan(scan_idx).unwrap()).unwrap()?;
            Some(found.boxes[0].bounding_box.center_m[0])
        };
        (0..3).map(&mut of_scan).collect()
    };
    assert_eq!(found_at(&[2, 41, 85]), [Some(2.0), Some(41.0), Some(85.0)]);
    // One that is near all three serves the nearest, and one that is left is of no other scan.
    assert_eq!(found_at(&[38]), [None, Some(38.0), None]);
    assert_eq!(found_at(&[38, 45]), [None, Some(38.0), None]);
    // Halfway to the next it is of none.
    assert_eq!(found_at(&[19, 60]), [Some(19.0), None, None]);
    let (_workplace, path) = write(&[0, 40, 40, 80]);
    let parts = ["has two messages of results with the time stamp 1040000000 ns"];
    check_refused(&path, &*dataset, false, &parts);
}

#[test]
fn results_are_paired_by_stamps_and_without_any_by_log_times() {
    use recordings::{CLOUD, DETECTIONS, Logged, SECOND, detections, organised_cloud};
    let millisecond = SECOND / 1000;
    let stamp_ns = |number: u64| 100 * SECOND + 50 * number * millisecond;
    let clouds: Vec<Logged> = (0..8)
        .map(|it| {
            let cloud = organised_cloud(stamp_ns(it), "lidar", false);
            ("/top", CLOUD, "cdr", stamp_ns(it) + 100 * millisecond, cloud)
        })
        .collect();
    let found = |stamp_of: fn(u64) -> u64, delay_ms: fn(u64) -> u64| -> Vec<Logged> {
        let message = |it: u64| {
            let stamp_ns = 100 * SECOND + 50 * it * (SECOND / 1000);
            let boxes = detections(stamp_of(stamp_ns), "lidar", [it as f64, 0.0, 0.0], 0.0);
            ("/found", DETECTIONS, "cdr", stamp_ns + delay_ms(it) * (SECOND / 1000), boxes)
        };
        (0..8).map(message).collect()
    };
    let on_clouds = Workplace::new();
    let dataset = open(&recordings::write(&on_clouds, WriteOptions::new(), &clouds));
    let check = |messages: &[Logged], is_said: bool| {
        let workplace = Workplace::new();
        let path = recordings::write(&workplace, WriteOptions::new(), messages);
        let mut results = try_results(&path, &*dataset, MissingResults::Refuse).unwrap();
        for scan_idx in 0..8 {
            let found = results.read(&dataset.read_scan(scan_idx).unwrap()).unwrap().unwrap();
            assert_eq!(found.boxes[0].bounding_box.center_m[0], scan_idx as f32);
        }
        let warnings = results.warnings();
        let says = |it: &String| it.contains("results are paired with clouds by when they were logged");
        assert_eq!(warnings.iter().any(says), is_said, "{warnings:?}");
    };
    check(&found(|it| it, |_| 0), false);
    check(&found(|it| it, |_| 280), false);
    check(&found(|it| it, |it| 100 + it * 7919 % 300), false);
    check(&found(|_| 0, |_| 115), true);
}

#[test]
fn a_frame_that_nobody_knows_is_refused() {
    let workplace = Workplace::new();
    let messages = [
        recordings::cloud_at(recordings::SECOND),
        recordings::found_at(recordings::SECOND, "moon", [5.0, 0.0, 0.0]),
    ];
    let path = recordings::write(&workplace, WriteOptions::new(), &messages);
    let clouds = Workplace::new();
    let clouds = open(&recordings::write(&clouds, WriteOptions::new(), &messages[..1]));
    check_refused(
        &path,
        &*clouds,
        false,
        &["the frame \"moon\"", "no transform from it to that of the scans, \"lidar\""],
    );
}
