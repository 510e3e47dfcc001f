//! What detectors know of a drive, moment by moment, to be drawn.

use nalgebra::Isometry3;
use reports::rows::match_outcome::MatchOutcome;
use reports::streaming::machine_speed::MachineSpeed;
use reports::streaming::stream_sums::lower_median;
use reports::vocabulary::forecast::Forecast;
use reports::vocabulary::task::Task;

use super::moving::{TimeUs, US_PER_MS};
use super::stream_study::{Course, StreamStudy};
use super::truth::TaskTruth;

/// A drive as detectors know it.
#[derive(Debug, Clone)]
pub struct StreamPicture {
    /// Names of the detectors, each with its median time of detection in milliseconds.
    pub detectors: Vec<(String, f64)>,
    /// Its scans: when each was taken, and the pose of the sensor relative to the first.
    pub scans: Vec<(TimeUs, Isometry3<f64>)>,
    /// Its moments, by time.
    pub moments: Vec<PictureMoment>,
}

/// A moment of a drive.
#[derive(Debug, Clone)]
pub struct PictureMoment {
    /// When it is.
    pub time_us: TimeUs,
    /// Pose of the sensor relative to the first scan.
    pub start_from_sensor: Isometry3<f64>,
    /// What each detector knows.
    pub known: Vec<KnownAtMoment>,
}

/// What a detector knows at a moment, in the frame of the sensor.
#[derive(Debug, Clone)]
pub struct KnownAtMoment {
    /// How old its answer is; `None` before the first.
    pub age_ms: Option<f64>,
    /// The outcome of everything.
    pub outcomes: Vec<MatchOutcome>,
}

impl StreamStudy<'_> {
    /// The picture of the drive with this index in `task`; `None` if the task has no rows there.
    pub fn picture(&self, drive_idx: usize, task: Task) -> Option<StreamPicture> {
        let drive = &self.drives[drive_idx];
        let logged = drive.tasks.get(&task)?;
        let times_us = drive.times_us();
        let truth = TaskTruth::of(drive, &logged.labels);
        let moments = self.moments_of(&truth, &times_us);
        let start = drive.scans.first()?.world_from_sensor.inverse();
        let mut picture = StreamPicture {
            detectors: Vec::new(),
            scans: drive.scans.iter().map(|it| (it.time_us, start * it.world_from_sensor)).collect(),
            moments: moments
                .iter()
                .map(|(time_us, it)| PictureMoment {
                    time_us: *time_us,
                    start_from_sensor: start * it.world_from_sensor,
                    known: Vec::new(),
                })
                .collect(),
        };
        let asked = self.detectors.iter().enumerate().filter(|(idx, _)| logged.is_asked[*idx]);
        for (detector_idx, name) in asked {
            let latencies_ms = &self.latencies[detector_idx][drive_idx];
            let median_ms = lower_median(latencies_ms).unwrap_or_default();
            picture.detectors.push(((*name).to_owned(), median_ms));
            let detections = &logged.answers[detector_idx];
            let course =
                Course { study: self, drive, logged, detections, moments: &moments, times_us: &times_us };
            let answers = course.answers(latencies_ms, MachineSpeed::THIS);
            course.go(&answers, Forecast::CarMotion, |moment_idx, scan_idx, judged| {
                let moment = &mut picture.moments[moment_idx];
                let age_ms = scan_idx.map(|it| (moment.time_us - times_us[it]) as f64 / US_PER_MS);
                let outcomes = judged.outcomes().into_iter().map(|it| it.0).collect();
                moment.known.push(KnownAtMoment { age_ms, outcomes });
            });
        }
        Some(picture)
    }
}
