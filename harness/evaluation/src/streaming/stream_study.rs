//! The study `streaming`: a clock goes through every drive, and at each moment the newest answer of every detector is judged.

use std::collections::HashMap;

use rayon::prelude::*;
use reports::numbers::tally::Tally;
use reports::rows::counts::Counts;
use reports::rows::match_outcome::{BoxFacts, DetectionFacts};
use reports::rows::match_row::MatchRow;
use reports::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
use reports::streaming::machine_speed::MachineSpeed;
use reports::streaming::stream_sums::{DetectorSums, StreamSums, none_of};
use reports::vocabulary::class::DetectionClass;
use reports::vocabulary::forecast::Forecast;
use reports::vocabulary::reason::IgnoredDetection;
use reports::vocabulary::slice::Slice;
use reports::vocabulary::task::Task;

use super::forecast::{forecast_box, velocities};
use super::judgement::JudgedMoment;
use super::latencies::Latencies;
use super::logged_drive::{Label, LoggedDetection, LoggedDrive, LoggedTask, Unmatched};
use super::moving::{TimeUs, US_PER_MS};
use super::schedule::{Answer, answers, moments, newest};
use super::truth::{TaskTruth, TrueMoment};
use crate::matching::criterion::Criterion;

/// What is judged, and how.
pub struct StreamStudy<'a> {
    /// The drives.
    pub drives: &'a [LoggedDrive],
    /// Names of the detectors of the run.
    pub detectors: &'a [&'a str],
    /// The tasks.
    pub tasks: &'a [Task],
    /// How long each takes for each scan.
    pub latencies: &'a Latencies,
    /// When a box is good enough; never by points.
    pub criterion: Criterion,
    /// Time from one moment to the next.
    pub step_us: TimeUs,
    /// Whether machines of other speeds, other forecasts and a late truth are judged, too.
    pub is_in_full: bool,
}

/// Sums of a study.
pub struct StreamResult {
    /// Of scans, each answer judged at the time of its own scan.
    pub per_scan: Tally,
    /// Of moments.
    pub streamed: Tally,
    /// All else.
    pub sums: StreamSums,
}

/// One detector in one task on one drive.
struct Part {
    task: Task,
    detector: String,
    sums: DetectorSums,
    per_scan: Vec<Rows>,
    streamed: Vec<Rows>,
}

/// The rows of a scan or a moment; of each annotation the slice of its speed.
type Rows = (ScanRow, Vec<(MatchRow, Option<Slice>)>);

impl StreamStudy<'_> {
    /// Goes through all drives; `empty` is a tally without rows for the same data sets. After each drive `progress` is called,
    /// which ends the study if it returns an error.
    ///
    /// # Errors
    ///
    /// That of `progress`.
    pub fn run<E>(
        &self,
        empty: impl Fn() -> Tally,
        mut progress: impl FnMut() -> Result<(), E>,
    ) -> Result<StreamResult, E> {
        let names = || self.detectors.iter().map(|it| (*it).to_owned()).collect();
        let (per_scan, streamed) = (empty().with_detectors(names()), empty().with_detectors(names()));
        let mut result = StreamResult { per_scan, streamed, sums: StreamSums::new() };
        let mut n_moments_before = 0;
        for (drive_idx, drive) in self.drives.iter().enumerate() {
            for part in self.of_drive(drive_idx, n_moments_before) {
                let key = (drive.dataset.clone(), part.task, part.detector);
                result.sums.entry(key).or_default().add(part.sums);
                for (tally, rows) in
                    [(&mut result.per_scan, part.per_scan), (&mut result.streamed, part.streamed)]
                {
                    for (scan, matches) in rows {
                        tally.add_scan(&scan);
                        matches.iter().for_each(|(row, speed)| tally.add_match_in(row, *speed));
                    }
                }
            }
            n_moments_before += self.n_moments(drive);
            progress()?;
        }
        Ok(result)
    }

    fn n_moments(&self, drive: &LoggedDrive) -> u32 {
        moments(&drive.times_us(), self.step_us).count() as u32
    }

    fn of_drive(&self, drive_idx: usize, n_moments_before: u32) -> Vec<Part> {
        let drive = &self.drives[drive_idx];
        let times_us = drive.times_us();
        let mut parts = Vec::new();
        for (task, logged) in drive.tasks.iter().filter(|(task, _)| self.tasks.contains(task)) {
            let truth = TaskTruth::of(drive, &logged.labels);
            let at = |it: TimeUs| (it, truth.at(it));
            let moments: Vec<(TimeUs, TrueMoment)> =
                moments(&times_us, self.step_us).collect::<Vec<_>>().into_par_iter().map(at).collect();
            let of_scans: Vec<(TimeUs, TrueMoment)> = times_us.iter().map(|it| at(*it)).collect();
            let of_detector = |detector_idx: usize| {
                let course = Course {
                    study: self,
                    drive,
                    logged,
                    detections: &logged.answers[detector_idx],
                    moments: &moments,
                    times_us: &times_us,
                };
                let names = (*task, self.detectors[detector_idx], n_moments_before);
                course.part(&of_scans, &self.latencies[detector_idx][drive_idx], names)
            };
            parts.extend((0..self.detectors.len()).into_par_iter().map(of_detector).collect::<Vec<_>>());
        }
        parts
    }
}

/// A detector on a drive in one task.
#[derive(Clone, Copy)]
struct Course<'a> {
    study: &'a StreamStudy<'a>,
    drive: &'a LoggedDrive,
    logged: &'a LoggedTask,
    // Of each scan.
    detections: &'a [Vec<LoggedDetection>],
    moments: &'a [(TimeUs, TrueMoment)],
    times_us: &'a [TimeUs],
}

impl Course<'_> {
    fn part(
        &self,
        of_scans: &[(TimeUs, TrueMoment)],
        latencies_ms: &[f64],
        (task, detector, n_moments_before): (Task, &str, u32),
    ) -> Part {
        let row = |number: u32, time_us: TimeUs, judged: &JudgedMoment<'_>| {
            self.rows((task, detector), number, time_us, judged)
        };
        let per_scan =
            of_scans.iter().zip(self.detections).zip(0..).map(|(((time_us, moment), known), scan_idx)| {
                let boxes = known.iter().map(|it| it.facts.bounding_box).collect();
                let judged = JudgedMoment::new(moment, known, boxes, self.study.criterion);
                row(n_moments_before + scan_idx, *time_us, &judged)
            });
        let per_scan = per_scan.collect();
        let answers = |speed: MachineSpeed| {
            answers(self.times_us, |it| (US_PER_MS * speed.time_ms(latencies_ms[it])).round() as TimeUs)
        };
        let on_this = answers(MachineSpeed::THIS);
        let mut sums = DetectorSums {
            n_moments: self.moments.len() as u64,
            n_taken: on_this.len() as u64,
            latencies_ms: latencies_ms.to_vec(),
            ..DetectorSums::default()
        };
        let mut streamed = Vec::with_capacity(self.moments.len());
        let mut memory: HashMap<(Option<usize>, usize), Counts> = HashMap::new();
        self.go(&on_this, Forecast::CarMotion, |moment_idx, scan_idx, judged| {
            let time_us = self.moments[moment_idx].0;
            let age = scan_idx.map(|it| (time_us - self.times_us[it]) as f64 / US_PER_MS);
            sums.ages_ms.extend(age);
            memory.insert((scan_idx, moment_idx), judged.counts(self.logged.are_false_known));
            streamed.push(row(n_moments_before + moment_idx as u32, time_us, judged));
        });
        if self.study.is_in_full {
            for forecast in [Forecast::Hold, Forecast::ConstantVelocity] {
                sums.forecasts.insert(forecast, self.counts(&on_this, forecast));
            }
            let truth: Vec<Vec<LoggedDetection>> =
                self.logged.labels.iter().map(|it| it.iter().filter_map(as_detected).collect()).collect();
            let late = Course { detections: &truth, ..*self };
            sums.late_truth = Some(late.counts(&on_this, Forecast::CarMotion));
            sums.by_machine = MachineSpeed::all()
                .map(|speed| (speed, self.remembered(&answers(speed), &mut memory)))
                .collect();
        }
        Part { task, detector: detector.to_owned(), sums, per_scan, streamed }
    }

    /// Judges the newest of `answers` at every moment; before the first, nothing is known.
    fn go(
        &self,
        answers: &[Answer],
        forecast: Forecast,
        mut each: impl FnMut(usize, Option<usize>, &JudgedMoment<'_>),
    ) {
        let velocities = velocities(forecast, self.drive, answers, self.detections);
        for moment_idx in 0..self.moments.len() {
            let newest = newest(answers, self.moments[moment_idx].0);
            let scan_idx = newest.map(|it| answers[it].scan_idx);
            let velocities = newest.map_or(&[][..], |it| &velocities[it]);
            each(moment_idx, scan_idx, &self.judge(moment_idx, scan_idx, forecast, velocities));
        }
    }

    fn judge(
        &self,
        moment_idx: usize,
        scan_idx: Option<usize>,
        forecast: Forecast,
        velocities: &[[f64; 2]],
    ) -> JudgedMoment<'_> {
        let (time_us, moment) = &self.moments[moment_idx];
        let known = scan_idx.map_or(&[][..], |it| &self.detections[it]);
        let now = |(idx, it): (usize, &LoggedDetection)| {
            let Some(scan_idx) = scan_idx else { return it.facts.bounding_box };
            let then = &self.drive.scans[scan_idx].world_from_sensor;
            let velocity = velocities.get(idx).copied().unwrap_or_default();
            let after_us = time_us - self.times_us[scan_idx];
            forecast_box(
                forecast,
                &it.facts.bounding_box,
                [then, &moment.world_from_sensor],
                velocity,
                after_us,
            )
        };
        let boxes: Vec<BoxFacts> = known.iter().enumerate().map(now).collect();
        JudgedMoment::new(moment, known, boxes, self.study.criterion)
    }

    fn counts(&self, answers: &[Answer], forecast: Forecast) -> Counts {
        let mut sum = none_of();
        self.go(answers, forecast, |_, _, judged| sum += judged.counts(self.logged.are_false_known));
        sum
    }

    /// The counts with the car's motion; what has been judged before is in `memory`.
    fn remembered(&self, answers: &[Answer], memory: &mut HashMap<(Option<usize>, usize), Counts>) -> Counts {
        let mut sum = none_of();
        for moment_idx in 0..self.moments.len() {
            let newest = newest(answers, self.moments[moment_idx].0);
            let scan_idx = newest.map(|it| answers[it].scan_idx);
            sum += *memory.entry((scan_idx, moment_idx)).or_insert_with(|| {
                self.judge(moment_idx, scan_idx, Forecast::CarMotion, &[]).counts(self.logged.are_false_known)
            });
        }
        sum
    }

    fn rows(
        &self,
        (task, detector): (Task, &str),
        number: u32,
        time_us: TimeUs,
        judged: &JudgedMoment<'_>,
    ) -> Rows {
        let [dataset, sequence, detector] =
            [&self.drive.dataset, &self.drive.name, detector].map(str::to_owned);
        let counts = judged.counts(self.logged.are_false_known);
        let row = |outcome| MatchRow {
            dataset: dataset.clone(),
            sequence: sequence.clone(),
            scan: number,
            detector: detector.clone(),
            task,
            criterion: self.study.criterion.kind(),
            outcome,
        };
        let outcomes = judged.outcomes().into_iter();
        let matches =
            outcomes.map(|(outcome, speed)| (row(outcome), speed.and_then(Slice::of_speed))).collect();
        let scan = ScanRow {
            dataset: dataset.clone(),
            sequence: sequence.clone(),
            scan: number,
            time_s: Some((time_us as f64 / 1e3).round() / 1e3),
            detector: detector.clone(),
            task,
            outcome: ScanOutcome::Evaluated(ScanNumbers::of_counts(counts)),
        };
        (scan, matches)
    }
}

/// A label as a detection that is exactly right; `None` without a box.
fn as_detected(label: &Label) -> Option<LoggedDetection> {
    let Label { facts, ignored } = label;
    Some(LoggedDetection {
        facts: DetectionFacts {
            id: facts.id,
            class: DetectionClass::Object,
            score: None,
            n_points: facts.n_points,
            bounding_box: facts.bounding_box?,
        },
        unmatched: match ignored {
            None => Unmatched::False,
            Some(_) => Unmatched::Ignored(IgnoredDetection::OnIgnoredAnnotation),
        },
        found: Some(facts.track),
    })
}
