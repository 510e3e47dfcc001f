//! The recording of a drive in real time: scans as they are taken, and what detectors know as late as they know it.

use std::path::Path;

use detector::OrientedBox;
use evaluation::streaming::stream_picture::{KnownAtMoment, PictureMoment, StreamPicture};
use nalgebra::Isometry3;
use re_sdk_types::archetypes::{Scalars, SeriesLines, Transform3D, ViewCoordinates};
use re_sdk_types::components::Radius;
use re_sdk_types::datatypes::Quaternion;
use reports::rows::match_outcome::MatchOutcome;
use rerun::RecordingStream;
use scans::annotation::LabeledScan;
use scans::conversion::results::detection_rows::oriented_box;

use super::blueprint::streams::send_stream_blueprint;
use super::drawn_points::{DrawnPoints, PointChoice};
use super::error::StreamError;
use super::layers::APPLICATION_ID;
use super::log_static::range_rings;
use super::palette::Rgb;
use super::single_file::SingleFile;
use super::{archetypes, entity_paths, legend, palette, recording};

/// The timeline: seconds since the first scan.
const TIMELINE: &str = "drive_time";

/// Names and colours of what a detector knows.
const KNOWN: [(&str, Rgb); 4] = [
    ("right", palette::MATCHED),
    ("late_or_false", palette::FALSE),
    ("missed", palette::MISSED),
    ("ignored", palette::IGNORED),
];

/// A recording of a drive in the making.
pub struct StreamRecording(SingleFile);

impl StreamRecording {
    /// Writes `picture`, called `name`, to the file at `path`; the points of its scans are still to come.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if the file cannot be written, or Rerun refuses.
    pub fn begin(path: &Path, name: &str, picture: &StreamPicture) -> Result<Self, StreamError> {
        let file = SingleFile::begin(path, name)?;
        let stream = &file.stream;
        let titles: Vec<(String, String)> = picture
            .detectors
            .iter()
            .map(|(name, latency_ms)| (name.clone(), format!("{name}: {latency_ms:.0} ms a scan")))
            .collect();
        send_stream_blueprint(stream, APPLICATION_ID, &titles, TIMELINE)?;
        log_lines(stream, picture)?;
        for moment in &picture.moments {
            set_time(stream, moment.time_us);
            log_moment(stream, picture, moment)?;
        }
        Ok(Self(file))
    }

    /// Adds the points of `scan`, which was taken then and there.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if Rerun refuses.
    pub fn add_scan(
        &self,
        (time_us, start_from_sensor): &(i64, Isometry3<f64>),
        scan: &LabeledScan,
    ) -> Result<(), StreamError> {
        let stream = &self.0.stream;
        set_time(stream, *time_us);
        let drawn = DrawnPoints::choose(&scan.cloud, PointChoice::for_scans(usize::MAX));
        let rounding = drawn.rounding();
        let positions_m = drawn.indices().map(|it| rounding.position_m(scan.cloud.position_m(it)));
        let points = archetypes::points(positions_m, Radius::new_ui_points(1.1), legend::rgba(palette::GREY));
        recording::log(stream, entity_paths::STREAM_SCAN, &points)?;
        recording::log(stream, entity_paths::STREAM_SCAN, &transform(start_from_sensor))
    }

    /// Completes the file.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if it cannot be written.
    pub fn finish(self) -> Result<(), StreamError> {
        self.0.finish()
    }
}

fn set_time(stream: &RecordingStream, time_us: i64) {
    stream.set_duration_secs(TIMELINE, time_us as f64 / 1e6);
}

fn transform(pose: &Isometry3<f64>) -> Transform3D {
    let position_m: [f32; 3] = pose.translation.vector.cast::<f32>().into();
    let turn: [f32; 4] = pose.rotation.coords.cast::<f32>().into();
    Transform3D::from_translation_rotation(position_m, Quaternion::from_xyzw(turn))
}

/// What does not change: axes, the car, names and colours of lines.
fn log_lines(stream: &RecordingStream, picture: &StreamPicture) -> Result<(), StreamError> {
    recording::log_static(stream, entity_paths::STREAM, &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    let car =
        OrientedBox { center_m: [-0.8, 0.0, -1.0], length_width_height_m: [4.2, 1.8, 1.4], yaw_rad: 0.0 };
    let car = archetypes::boxes([car]).with_colors([legend::rgba(palette::SKY_BLUE)]);
    recording::log_static(stream, entity_paths::STREAM_CAR, &car)?;
    recording::log_static(stream, entity_paths::STREAM_RINGS, &range_rings())?;
    for (detector_idx, (name, _)) in picture.detectors.iter().enumerate() {
        let line = SeriesLines::new()
            .with_names([name.as_str()])
            .with_colors([legend::rgba(palette::detector_color(detector_idx))])
            .with_widths([2.0]);
        for series in [entity_paths::STREAM_AGE, entity_paths::STREAM_FOUND] {
            recording::log_static(stream, entity_paths::stream_series(series, name), &line)?;
        }
    }
    Ok(())
}

fn log_moment(
    stream: &RecordingStream,
    picture: &StreamPicture,
    moment: &PictureMoment,
) -> Result<(), StreamError> {
    recording::log(stream, entity_paths::STREAM_SENSOR, &transform(&moment.start_from_sensor))?;
    for ((name, _), known) in picture.detectors.iter().zip(&moment.known) {
        let boxes = boxes_of(known);
        for ((part, color), boxes) in KNOWN.iter().zip(&boxes) {
            let drawn = archetypes::boxes(boxes.iter().copied()).with_colors([legend::rgba(*color)]);
            recording::log(stream, entity_paths::known(name).join(&(*part).into()), &drawn)?;
        }
        if let Some(age_ms) = known.age_ms {
            let path = entity_paths::stream_series(entity_paths::STREAM_AGE, name);
            recording::log(stream, path, &Scalars::single(age_ms))?;
        }
        let [n_right, n_missed] = [boxes[0].len(), boxes[2].len()].map(|it| it as f64);
        if n_right + n_missed > 0.0 {
            let path = entity_paths::stream_series(entity_paths::STREAM_FOUND, name);
            recording::log(stream, path, &Scalars::single(n_right / (n_right + n_missed)))?;
        }
    }
    Ok(())
}

/// The boxes of each of [`KNOWN`].
fn boxes_of(known: &KnownAtMoment) -> [Vec<OrientedBox>; 4] {
    let [mut right, mut wrong, mut missed, mut ignored] = [const { Vec::new() }; 4];
    for outcome in &known.outcomes {
        match outcome {
            MatchOutcome::Matched { detection, .. } => right.push(oriented_box(&detection.bounding_box)),
            MatchOutcome::False { detection, .. } => wrong.push(oriented_box(&detection.bounding_box)),
            MatchOutcome::Missed { annotation, .. } => {
                missed.extend(annotation.bounding_box.as_ref().map(oriented_box));
            }
            MatchOutcome::IgnoredDetection { detection, .. } | MatchOutcome::Unknowable { detection, .. } => {
                ignored.push(oriented_box(&detection.bounding_box));
            }
            MatchOutcome::Tall { found_by, .. } => {
                ignored.extend(found_by.iter().map(|it| oriented_box(&it.detection.bounding_box)));
            }
            MatchOutcome::IgnoredAnnotation { .. } => {}
        }
    }
    [right, wrong, missed, ignored]
}
