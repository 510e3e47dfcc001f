//! Where the boxes of an answer are taken to be at a later moment.

use nalgebra::{Isometry3, Translation3};
use reports::rows::match_outcome::BoxFacts;
use reports::vocabulary::forecast::Forecast;
use scans::dataset::official::turned_velocity;

use super::logged_drive::{LoggedDetection, LoggedDrive};
use super::moving::{TimeUs, box_at, pose_of};
use super::schedule::Answer;
use super::tracker::{Seen, Tracker};

/// The velocities of all detections of each of `answers`, on the ground plan of the frame that rests, in metres per second;
/// `detections` are those of each scan of `drive`. All are zero unless the forecast needs them. A detection has the velocity
/// that its detector gives, or else the one by which the tracker has followed it.
pub fn velocities(
    forecast: Forecast,
    drive: &LoggedDrive,
    answers: &[Answer],
    detections: &[Vec<LoggedDetection>],
) -> Vec<Vec<[f64; 2]>> {
    let mut tracker = Tracker::default();
    let of_answer = |answer: &Answer| {
        let detections = &detections[answer.scan_idx];
        if forecast != Forecast::ConstantVelocity {
            return vec![[0.0; 2]; detections.len()];
        }
        let scan = &drive.scans[answer.scan_idx];
        let center_m = |it: &LoggedDetection| {
            let at_m = (scan.world_from_sensor * pose_of(&it.facts.bounding_box)).translation;
            [at_m.x, at_m.y]
        };
        let seen = detections.iter().map(|it| Seen { center_m: center_m(it), track: it.facts.motion.track });
        let tracked = tracker.step(scan.time_us, &seen.collect::<Vec<_>>());
        let given = |it: &LoggedDetection| {
            // It is over ground; without poses boxes are moved relative to the car.
            let velocity = it.facts.motion.velocity_m_per_s.filter(|_| drive.has_poses)?.map(f64::from);
            Some(turned_velocity(velocity, &scan.world_from_sensor.rotation))
        };
        detections.iter().zip(tracked).map(|(it, tracked)| given(it).unwrap_or(tracked)).collect()
    };
    answers.iter().map(of_answer).collect()
}

/// Where a box is taken to be `after_us` later; the poses are those of the sensor then and now.
pub fn forecast_box(
    forecast: Forecast,
    bounding_box: &BoxFacts,
    [then, now]: [&Isometry3<f64>; 2],
    [vx_m_per_s, vy_m_per_s]: [f64; 2],
    after_us: TimeUs,
) -> BoxFacts {
    if forecast == Forecast::Hold || after_us == 0 {
        return *bounding_box;
    }
    let after_s = after_us as f64 / 1e6;
    let way = Translation3::new(vx_m_per_s * after_s, vy_m_per_s * after_s, 0.0);
    box_at(&(now.inverse() * way * then * pose_of(bounding_box)), bounding_box.length_width_height_m)
}
