//! Runs as streams: their drives, and their moments for rules of a gate.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use evaluation::matching::criterion::Criterion;
use evaluation::streaming::latencies::{LatencySource, NoLatency};
use evaluation::streaming::logged_drive::{LoggedDrive, logged_drives};
use evaluation::streaming::stream_study::StreamStudy;
use reports::files::csv_rows::read_rows;
use reports::numbers::tally::Tally;
use reports::run_folder::run_archive::RunArchive;
use reports::run_folder::run_directory::POSES_CSV;
use reports::streaming::closeness::NoStream;
use reports::verdicts::comparability::check_comparable;
use reports::verdicts::gated_streams::StreamPair;
use reports::verdicts::tolerances::{Lateness, StreamRule, Tolerances};
use reports::vocabulary::criterion::CriterionKind;
use reports::vocabulary::task::Task;

use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};

/// Time from one moment to the next for a gate, in microseconds.
const GATED_STEP_US: i64 = 10_000;

/// A run with its drives.
pub struct Stream<'a> {
    pub run: &'a RunArchive,
    pub detectors: Vec<&'a str>,
    pub drives: Vec<LoggedDrive>,
    /// What has to be said of them, a sentence each.
    pub notes: Vec<String>,
}

impl<'a> Stream<'a> {
    /// The drives of `run`, which lies in `directory`, with these of its detectors.
    pub fn of(run: &'a RunArchive, directory: &Path, detectors: Vec<&'a str>) -> Result<Self, Failure> {
        let poses_csv = directory.join(POSES_CSV);
        let poses = if poses_csv.is_file() { read_rows(&poses_csv) } else { Ok(Vec::new()) };
        let poses = poses.map_err(|error| Failure::damaged_run(directory, error))?;
        let rows = (&run.scans[..], &run.matches[..], &poses[..]);
        let (drives, left_out) = logged_drives(&detectors, rows, run.manifest.drive_of());
        let words = |NoStream { dataset, reason }: &NoStream| format!("{dataset} {reason}");
        let mut notes: Vec<String> = left_out.iter().map(|it| format!("Left out: {}.", words(it))).collect();
        if drives.is_empty() {
            let reasons: Vec<String> = left_out.iter().map(words).collect();
            let hint = if run.manifest.datasets.iter().any(|it| it.simulated) {
                ". Simulated streets that are a stream: streaming-streets"
            } else {
                ""
            };
            return Err(NothingEvaluated { reason: format!("{}{hint}", reasons.join("; ")) }.into());
        }
        let without: BTreeSet<&str> =
            drives.iter().filter(|it| !it.has_poses).map(|it| it.dataset.as_str()).collect();
        notes.extend(without.iter().map(|dataset| {
            format!(
                "The car's motion is unknown on {dataset}: boxes are moved relative to the car there, and there are no speeds."
            )
        }));
        Ok(Self { run, detectors, drives, notes })
    }

    /// Its moments as `rule` asks for them; measured times are taken `slower` times as long.
    fn moments(&self, rule: &StreamRule, slower: f64) -> Result<Tally, Failure> {
        let fixed_ms = match rule.lateness {
            Lateness::Fixed(ms) => self.detectors.iter().map(|it| ((*it).to_owned(), ms)).collect(),
            Lateness::Measured => BTreeMap::new(),
        };
        let source = LatencySource { fixed_ms, elsewhere: None };
        let latencies = source.latencies(&self.drives, &self.detectors);
        let mut latencies = latencies.map_err(|NoLatency { detector }| {
            Usage(format!(
                "[[streaming]]: no time of detection of {detector} is known: give the rule latency_ms, or other detectors"
            ))
        })?;
        if rule.lateness == Lateness::Measured {
            latencies.ms.iter_mut().flatten().flatten().for_each(|it| *it *= slower);
        }
        let known = self.run.tally();
        let tasks: Vec<Task> =
            known.tasks().iter().copied().filter(|it| rule.rule.is_within(it.name())).collect();
        let study = StreamStudy {
            drives: &self.drives,
            detectors: &self.detectors,
            tasks: &tasks,
            latencies: &latencies.ms,
            criterion: by_boxes(rule.criterion),
            step_us: GATED_STEP_US,
            is_in_full: false,
        };
        Ok(study.run(|| self.run.manifest.tally_of_moments(), || Ok::<(), Failure>(()))?.streamed)
    }

    fn n_drives_with_poses(&self) -> usize {
        self.drives.iter().filter(|it| it.has_poses).count()
    }

    /// The geometric mean of the times of the reference, in milliseconds.
    fn reference_ms(&self) -> Option<f64> {
        let times = self.run.scans.iter().filter_map(|it| it.numbers()?.reference_ms).filter(|it| *it > 0.0);
        let logs: Vec<f64> = times.map(f64::ln).collect();
        (!logs.is_empty()).then(|| (logs.iter().sum::<f64>() / logs.len() as f64).exp())
    }
}

/// The criterion of this kind with its usual gate.
fn by_boxes(kind: CriterionKind) -> Criterion {
    let known = Criterion::ALL.into_iter().find(|it| it.kind() == kind);
    known.expect("there is a criterion of every kind")
}

/// The moments of a baseline and of a run for each rule about streams; both come with their directories.
pub fn gated_streams(
    tolerances: &Tolerances,
    [before, after]: [(&RunArchive, &Path); 2],
) -> Result<Vec<StreamPair>, Failure> {
    // Runs that cannot be compared are refused by their judge.
    if tolerances.streams.is_empty() || check_comparable(before.0, after.0).is_err() {
        return Ok(Vec::new());
    }
    let pair = |rule: &StreamRule| {
        // A detector that only the later run has is not gated.
        let names = before.0.detector_names().into_iter().filter(|it| rule.rule.is_of_detector(it));
        let names: Vec<&str> = names.collect();
        let of_after = after.0.detector_names().into_iter().filter(|it| names.contains(it)).collect();
        let sides = [Stream::of(before.0, before.1, names)?, Stream::of(after.0, after.1, of_after)?];
        // The car's motion would look like a change of the detector.
        let [has_poses, has_now] = sides.each_ref().map(Stream::n_drives_with_poses);
        if has_poses != has_now {
            let words = format!(
                "[[streaming]]: poses are known of {has_poses} drives in the baseline and of {has_now} in the run: {POSES_CSV} is \
                 missing, or of an earlier program"
            );
            return Err(Failure::NotComparable(words.into()));
        }
        let references = sides.each_ref().map(Stream::reference_ms);
        let slower = references[0].zip(references[1]).map_or(1.0, |(before, after)| before / after);
        Ok(StreamPair { before: sides[0].moments(rule, 1.0)?, after: sides[1].moments(rule, slower)? })
    };
    tolerances.streams.iter().map(pair).collect()
}
