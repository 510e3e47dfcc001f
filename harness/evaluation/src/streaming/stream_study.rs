//! The study `streaming`: a clock goes through every drive, and at each moment the newest answer of every detector is judged.

use std::collections::HashMap;
use std::ops::Range;

use rayon::prelude::*;
use reports::numbers::tally::Tally;
use reports::rows::counts::Counts;
use reports::rows::match_outcome::{BoxFacts, DetectionFacts, MotionFacts};
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
    /// Times of detection in milliseconds, by detector, drive and scan.
    pub latencies: &'a [Vec<Vec<f64>>],
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
    /// How many labels that count cannot be followed, of how many, over all tasks.
    pub n_unfollowed: [u64; 2],
}

/// The rows of a scan or a moment; of each annotation the slice of its speed.
type Rows = (ScanRow, Vec<(MatchRow, Option<Slice>)>);

/// So many moments have rows in memory at once, for each detector.
const MOMENTS_AT_ONCE: usize = 256;

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
        let mut result = StreamResult { per_scan, streamed, sums: StreamSums::new(), n_unfollowed: [0, 0] };
        let mut before = [0, 0];
        for drive_idx in 0..self.drives.len() {
            self.add_drive(drive_idx, before, &mut result);
            let times_us = self.drives[drive_idx].times_us();
            let n_moments = moments(&times_us, self.step_us).count();
            before = [before[0] + times_us.len() as u32, before[1] + n_moments as u32];
            progress()?;
        }
        Ok(result)
    }

    /// Adds a drive; `before` are the numbers of scans and moments of the drives before it.
    fn add_drive(&self, drive_idx: usize, before: [u32; 2], result: &mut StreamResult) {
        let drive = &self.drives[drive_idx];
        let times_us = drive.times_us();
        for (task, logged) in drive.tasks.iter().filter(|(task, _)| self.tasks.contains(task)) {
            let truth = TaskTruth::of(drive, &logged.labels);
            let moments = self.moments_of(&truth, &times_us);
            let scans: Vec<(TimeUs, TrueMoment)> =
                times_us.iter().enumerate().map(|(scan_idx, it)| (*it, truth.at_scan(scan_idx))).collect();
            let [n_unfollowed, n_labels] = truth.n_unfollowed();
            result.n_unfollowed = [result.n_unfollowed[0] + n_unfollowed, result.n_unfollowed[1] + n_labels];
            let asked: Vec<usize> = (0..self.detectors.len()).filter(|it| logged.is_asked[*it]).collect();
            let course = |detector_idx: usize| Course {
                study: self,
                drive,
                logged,
                detections: &logged.answers[detector_idx],
                moments: &moments,
                times_us: &times_us,
            };
            let of_detector = |it: &usize| {
                let course = course(*it);
                let answers = course.answers(&self.latencies[*it][drive_idx], MachineSpeed::THIS);
                let sums = course.sums(&answers, &self.latencies[*it][drive_idx]);
                (*it, answers, sums)
            };
            let parts: Vec<(usize, Vec<Answer>, DetectorSums)> =
                asked.into_par_iter().map(|it| of_detector(&it)).collect();
            for (detector_idx, answers, sums) in parts {
                let detector = self.detectors[detector_idx];
                let course = course(detector_idx);
                let subject = (*task, detector);
                add_rows(&mut result.per_scan, course.rows_of_scans(subject, before[0], &scans));
                for first in (0..moments.len()).step_by(MOMENTS_AT_ONCE) {
                    let range = first..moments.len().min(first + MOMENTS_AT_ONCE);
                    add_rows(
                        &mut result.streamed,
                        course.rows_of_moments(subject, before[1], &answers, range),
                    );
                }
                let key = (drive.dataset.clone(), *task, detector.to_owned());
                result.sums.entry(key).or_default().add(sums);
            }
        }
    }

    /// What is true at each moment of a drive with scans at these times.
    pub(super) fn moments_of(&self, truth: &TaskTruth<'_>, times_us: &[TimeUs]) -> Vec<(TimeUs, TrueMoment)> {
        let at = |it: TimeUs| (it, truth.at(it));
        moments(times_us, self.step_us).collect::<Vec<_>>().into_par_iter().map(at).collect()
    }
}

fn add_rows(tally: &mut Tally, rows: Vec<Rows>) {
    for (scan, matches) in rows {
        tally.add_scan(&scan);
        for (row, speed) in &matches {
            tally.add_match_in(row, *speed);
        }
    }
}

/// A detector on a drive in one task.
#[derive(Clone, Copy)]
pub(super) struct Course<'a> {
    pub(super) study: &'a StreamStudy<'a>,
    pub(super) drive: &'a LoggedDrive,
    pub(super) logged: &'a LoggedTask,
    // Of each scan.
    pub(super) detections: &'a [Vec<LoggedDetection>],
    pub(super) moments: &'a [(TimeUs, TrueMoment)],
    pub(super) times_us: &'a [TimeUs],
}

impl Course<'_> {
    /// The answers on a machine of this speed.
    pub(super) fn answers(&self, latencies_ms: &[f64], speed: MachineSpeed) -> Vec<Answer> {
        answers(self.times_us, |it| (US_PER_MS * speed.time_ms(latencies_ms[it])).round() as TimeUs)
    }

    /// Sums over the moments; `answers` are those on the machine of the times.
    fn sums(&self, answers: &[Answer], latencies_ms: &[f64]) -> DetectorSums {
        let mut sums = DetectorSums {
            n_taken: answers.len() as u64,
            latencies_ms: latencies_ms.to_vec(),
            ..DetectorSums::default()
        };
        for (time_us, _) in self.moments {
            let known = newest(answers, *time_us).map(|it| self.times_us[answers[it].scan_idx]);
            sums.ages_ms.extend(known.map(|it| (time_us - it) as f64 / US_PER_MS));
        }
        if self.study.is_in_full {
            for forecast in [Forecast::Hold, Forecast::ConstantVelocity] {
                sums.forecasts.insert(forecast, self.counts(answers, forecast));
            }
            let truth: Vec<Vec<LoggedDetection>> =
                self.logged.labels.iter().map(|it| it.iter().filter_map(as_detected).collect()).collect();
            let late = Course { detections: &truth, ..*self };
            sums.late_truth = Some(late.counts(answers, Forecast::CarMotion));
            // What is judged for one speed is the same for another.
            let mut memory = HashMap::new();
            sums.by_machine = MachineSpeed::all()
                .map(|speed| (speed, self.remembered(&self.answers(latencies_ms, speed), &mut memory)))
                .collect();
        }
        sums
    }

    /// Rows of its scans, each answer judged by what is labelled in its own scan.
    fn rows_of_scans(
        &self,
        subject: (Task, &str),
        n_before: u32,
        scans: &[(TimeUs, TrueMoment)],
    ) -> Vec<Rows> {
        let of_scan = |(((time_us, moment), known), scan_idx): (
            (&(TimeUs, TrueMoment), &Vec<LoggedDetection>),
            u32,
        )| {
            let boxes = known.iter().map(|it| it.facts.bounding_box).collect();
            let judged = JudgedMoment::new(moment, known, boxes, self.study.criterion);
            self.rows(subject, n_before + scan_idx, *time_us, &judged)
        };
        scans.iter().zip(self.detections).zip(0..).map(of_scan).collect()
    }

    /// Rows of these of its moments, with the car's motion.
    fn rows_of_moments(
        &self,
        subject: (Task, &str),
        n_before: u32,
        answers: &[Answer],
        range: Range<usize>,
    ) -> Vec<Rows> {
        let of_moment = |moment_idx: usize| {
            let time_us = self.moments[moment_idx].0;
            let scan_idx = newest(answers, time_us).map(|it| answers[it].scan_idx);
            let judged = self.judge(moment_idx, scan_idx, Forecast::CarMotion, &[]);
            self.rows(subject, n_before + moment_idx as u32, time_us, &judged)
        };
        range.into_par_iter().map(of_moment).collect()
    }

    /// Judges the newest of `answers` at every moment; before the first, nothing is known.
    pub(super) fn go(
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
            motion: MotionFacts::default(),
        },
        unmatched: match ignored {
            None => Unmatched::False,
            Some(_) => Unmatched::Ignored(IgnoredDetection::OnIgnoredAnnotation),
        },
        found: Some(facts.track),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streaming::latencies::LatencySource;
    use crate::streaming::logged_drive::logged_drives;
    use proptest::prelude::*;
    use reports::rows::match_outcome::{AnnotationFacts, MatchOutcome};
    use reports::rows::pose_row::PoseRow;
    use reports::vocabulary::class::AnnotationClass;
    use reports::vocabulary::reason::FalseReason;

    /// A car that starts 5 m ahead, and a sensor that may drive, too; both straight on, in metres per second.
    #[derive(Debug, Clone, Copy)]
    struct Scene {
        car: f64,
        sensor: f64,
        length_m: f32,
    }

    const N_SCANS: u32 = 11;

    impl Scene {
        /// Rows of a detector that finds the car exactly in scans a tenth of a second apart.
        fn rows(self) -> (Vec<ScanRow>, Vec<MatchRow>, Vec<PoseRow>) {
            let [dataset, sequence, detector] = ["drawn", "0", "exact"].map(str::to_owned);
            let at_s = |scan: u32| f64::from(scan) / 10.0;
            let scan_row = |scan: u32| ScanRow {
                dataset: dataset.clone(),
                sequence: sequence.clone(),
                scan,
                time_s: Some(at_s(scan)),
                detector: detector.clone(),
                task: Task::Vehicles,
                outcome: ScanOutcome::Evaluated(ScanNumbers::of_counts(Counts::new(1, 1, Some(0)).unwrap())),
            };
            let match_row = |scan: u32| {
                let bounding_box = BoxFacts {
                    center_m: [(5.0 + (self.car - self.sensor) * at_s(scan)) as f32, 0.0, 0.0],
                    length_width_height_m: [self.length_m, 2.0, 1.5],
                    yaw_rad: 0.0,
                };
                let annotation = AnnotationFacts {
                    id: 0,
                    track: Some(7),
                    class: AnnotationClass::Car,
                    occlusion: None,
                    n_points: 100,
                    n_points_outside: 0,
                    bounding_box: Some(bounding_box),
                    centroid_m: None,
                };
                let (class, score) = (DetectionClass::Vehicle, Some(0.5));
                let motion = MotionFacts::default();
                let detection = DetectionFacts { id: 0, class, score, n_points: 100, bounding_box, motion };
                MatchRow {
                    dataset: dataset.clone(),
                    sequence: sequence.clone(),
                    scan,
                    detector: detector.clone(),
                    task: Task::Vehicles,
                    criterion: Criterion::POINTS.kind(),
                    outcome: MatchOutcome::Matched { annotation, detection, cost: 0.0 },
                }
            };
            let pose_row = |scan: u32| PoseRow {
                dataset: dataset.clone(),
                sequence: sequence.clone(),
                scan,
                x_m: 100.0 + self.sensor * at_s(scan),
                y_m: 0.0,
                z_m: 1.7,
                qx: 0.0,
                qy: 0.0,
                qz: 0.0,
                qw: 1.0,
            };
            let scans = || 0..N_SCANS;
            (
                scans().map(scan_row).collect(),
                scans().map(match_row).collect(),
                scans().map(pose_row).collect(),
            )
        }

        fn stream(self, latency_ms: f64, criterion: Criterion) -> StreamResult {
            let (scans, matches, poses) = self.rows();
            let (drives, left_out) =
                logged_drives(&["exact"], (&scans, &matches, &poses), |it| it.sequence.clone());
            assert_eq!((drives.len(), left_out.len()), (1, 0));
            let fixed_ms = [("exact".to_owned(), latency_ms)].into();
            let source = LatencySource { fixed_ms, elsewhere: None };
            let study = StreamStudy {
                drives: &drives,
                detectors: &["exact"],
                tasks: &[Task::Vehicles],
                latencies: &source.latencies(&drives, &["exact"]).unwrap().ms,
                criterion,
                step_us: 1000,
                is_in_full: true,
            };
            study.run(Tally::default, || Ok::<(), ()>(())).unwrap()
        }

        /// TP, MO and FO over the 1,001 moments of a second.
        fn counts(self, latency_ms: f64, criterion: Criterion) -> [u64; 3] {
            let counts = self.stream(latency_ms, criterion).streamed.counts("drawn", Task::Vehicles, "exact");
            triple(counts.unwrap())
        }
    }

    fn triple(counts: Counts) -> [u64; 3] {
        [counts.tp(), counts.mo(), counts.fo().unwrap()]
    }

    const PASSING: Scene = Scene { car: 10.0, sensor: 0.0, length_m: 4.4 };

    #[test]
    fn a_car_at_ten_metres_a_second_is_lost_when_the_answer_is_200_ms_old() {
        let counts = |latency_ms: f64| PASSING.counts(latency_ms, Criterion::CENTRE);
        assert_eq!(counts(0.0), [1001, 0, 0]);
        // Nothing is known for 50 ms; then the answer is 50 to 149 ms old, and off by 0.5 to 1.49 m.
        assert_eq!(counts(50.0), [951, 50, 0]);
        assert_eq!(counts(100.0), [901, 100, 0]);
        // Answers come at 101, 202, 303 … ms and are 101 to 201 ms old: off by 2 m and more in two moments of each, and in
        // one of the last, which ends at 1000 ms.
        let n_late = (1..=9).map(|it: i64| {
            let [from, to] = [101 * it, (101 * (it + 1)).min(1001)];
            let taken = if it == 1 { 0 } else { 100 * (101 * (it - 1) / 100) };
            (from..to).filter(|at| at - taken >= 200).count() as u64
        });
        let n_late: u64 = n_late.sum();
        assert!(n_late > 0);
        assert_eq!(counts(101.0), [1001 - 101 - n_late, 101 + n_late, n_late]);
        // Answers of scans 0, 1, 3, 4, 6, 7 from 150, 300, 450, 600, 750, 900 ms on: each second one is 150 to 199 ms old for
        // 50 ms, the others are older.
        assert_eq!(counts(150.0), [150, 1001 - 150, 851 - 150]);
        assert_eq!(counts(250.0), [0, 1001, 751]);
    }

    #[test]
    fn by_overlap_it_is_lost_at_a_third_of_its_length() {
        // 4.4 m / 3 is reached after 146.7 ms.
        let counts = |latency_ms: f64| PASSING.counts(latency_ms, Criterion::BEV_IOU);
        assert_eq!(counts(0.0), [1001, 0, 0]);
        assert_eq!(counts(47.0), [954, 47, 0]);
        // Of the ages 48 to 147 the last is too old, once between any two answers: nine times.
        assert_eq!(counts(48.0), [953 - 9, 48 + 9, 9]);
        // 50 to 149 ms: three of each hundred, nine times.
        assert_eq!(counts(50.0), [951 - 27, 50 + 27, 27]);
        assert_eq!(counts(150.0), [0, 1001, 851]);
    }

    #[test]
    fn what_rests_is_known_for_ever_if_the_cars_own_motion_is() {
        let parked = Scene { car: 0.0, sensor: 12.0, length_m: 4.4 };
        let result = parked.stream(250.0, Criterion::BEV_IOU);
        let sums = &result.sums[&("drawn".to_owned(), Task::Vehicles, "exact".to_owned())];
        let streamed = result.streamed.counts("drawn", Task::Vehicles, "exact").unwrap();
        assert_eq!(triple(streamed), [751, 250, 0]);
        assert_eq!(triple(sums.forecasts[&Forecast::Hold]), [0, 1001, 751]);
        assert_eq!(sums.late_truth, Some(streamed));
        // Scans 0, 2, 5 and 7 are taken, and 10, which is there when it is free at 1000 ms.
        assert_eq!((sums.n_taken, sums.ages_ms.len()), (5, 751));
        // A machine that is 16 times as fast takes 15.6 ms: the answer is known at the 16th.
        assert_eq!(triple(sums.by_machine[16].1), [985, 16, 0]);
        assert_eq!(sums.by_machine[8].1, streamed);
        let speeds = result.streamed.slices(Task::Vehicles, "exact");
        assert!(
            speeds.contains(&Slice::of_speed(0.0).unwrap())
                && !speeds.contains(&Slice::of_speed(12.0).unwrap())
        );
    }

    #[test]
    fn a_tracker_follows_what_moves_evenly() {
        let sums = |latency_ms: f64| {
            let result = PASSING.stream(latency_ms, Criterion::BEV_IOU);
            result.sums[&("drawn".to_owned(), Task::Vehicles, "exact".to_owned())].clone()
        };
        // The first answer gives no velocity: it is lost at 147 ms, and the second comes at 250.
        let [found, ..] = triple(sums(150.0).forecasts[&Forecast::ConstantVelocity]);
        assert!(found > 600, "{found}");
        assert!(
            PASSING
                .stream(0.0, Criterion::CENTRE)
                .streamed
                .slices(Task::Vehicles, "exact")
                .contains(&Slice::Speed(3))
        );
    }

    #[test]
    fn an_object_that_is_labelled_no_more_is_nobodys_mistake() {
        let (scans, mut matches, poses) = PASSING.rows();
        // From the sixth scan on the car is not labelled, and not found.
        matches.truncate(6);
        let (drives, _) = logged_drives(&["exact"], (&scans, &matches, &poses), |it| it.sequence.clone());
        let study = StreamStudy {
            drives: &drives,
            detectors: &["exact"],
            tasks: &[Task::Vehicles],
            latencies: &[vec![vec![100.0; 11]]],
            criterion: Criterion::CENTRE,
            step_us: 1000,
            is_in_full: false,
        };
        let result = study.run(Tally::default, || Ok::<(), ()>(())).unwrap();
        let counts = result.streamed.counts("drawn", Task::Vehicles, "exact").unwrap();
        // It counts until 500 ms. The answer of the scan at 500 ms is known from 600 to 700 ms, and ignored.
        assert_eq!(triple(counts), [401, 100, 0]);
        // A detection of nothing stays false as long as it is the newest answer: 300 to 400 ms.
        let (scans, mut matches, poses) = PASSING.rows();
        if let MatchOutcome::Matched { detection, .. } = matches[2].outcome.clone() {
            let reason = FalseReason::NothingThere;
            let facts = BoxFacts { center_m: [40.0, 9.0, 0.0], ..detection.bounding_box };
            let detection = DetectionFacts { id: 1, bounding_box: facts, ..detection };
            let outcome = MatchOutcome::False { detection, reason };
            matches.push(MatchRow { outcome, ..matches[2].clone() });
        }
        let (drives, _) = logged_drives(&["exact"], (&scans, &matches, &poses), |it| it.sequence.clone());
        let result =
            StreamStudy { drives: &drives, ..study }.run(Tally::default, || Ok::<(), ()>(())).unwrap();
        let counts = result.streamed.counts("drawn", Task::Vehicles, "exact").unwrap();
        assert_eq!(triple(counts), [901, 100, 100]);
    }

    proptest! {
        #[test]
        fn scans_are_judged_as_in_the_run_and_lateness_never_helps_on_an_even_course(
            car in -20.0..20.0_f64,
            sensor in -20.0..20.0_f64,
            latency_ms in 0.0..400.0_f64,
        ) {
            let scene = Scene { car, sensor, length_m: 4.4 };
            let result = scene.stream(latency_ms, Criterion::BEV_IOU);
            let per_scan = result.per_scan.counts("drawn", Task::Vehicles, "exact").unwrap();
            prop_assert_eq!(triple(per_scan), [u64::from(N_SCANS), 0, 0]);
            let [found, missed, _] = triple(result.streamed.counts("drawn", Task::Vehicles, "exact").unwrap());
            prop_assert_eq!(found + missed, 1001);
            let [prompt, ..] = scene.counts(0.0, Criterion::BEV_IOU);
            prop_assert!(found <= prompt);
        }
    }
}
