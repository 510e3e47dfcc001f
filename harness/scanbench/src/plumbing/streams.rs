//! Runs as streams: their drives, and their moments for rules of a gate.

use std::collections::BTreeMap;
use std::path::Path;

use evaluation::matching::criterion::Criterion;
use evaluation::streaming::latencies::{LatencySource, NoLatency};
use evaluation::streaming::logged_drive::{LoggedDrive, NoStream, logged_drives};
use evaluation::streaming::stream_study::StreamStudy;
use reports::files::csv_rows::read_rows;
use reports::numbers::tally::Tally;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::run_archive::RunArchive;
use reports::run_folder::run_directory::POSES_CSV;
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
        let named = run.manifest.named_drives();
        let drive_of = |row: &ScanRow| {
            let name = format!("{}/{:06}", row.sequence, row.scan);
            named
                .get(&(row.dataset.as_str(), name))
                .map_or_else(|| row.sequence.clone(), |it| (*it).to_owned())
        };
        let (drives, left_out) = logged_drives(&detectors, (&run.scans, &run.matches, &poses), drive_of);
        let words = |NoStream { dataset, reason }: &NoStream| format!("{dataset} {reason}");
        let mut notes: Vec<String> = left_out.iter().map(|it| format!("Left out: {}.", words(it))).collect();
        if drives.is_empty() {
            let reasons: Vec<String> = left_out.iter().map(words).collect();
            let reason = format!("{}; of streets, `streaming-streets` are a stream", reasons.join("; "));
            return Err(NothingEvaluated { reason }.into());
        }
        let mut without: BTreeMap<&str, usize> = BTreeMap::new();
        for it in drives.iter().filter(|it| !it.has_poses) {
            *without.entry(&it.dataset).or_default() += 1;
        }
        notes.extend(without.iter().map(|(dataset, n)| {
            format!(
                "The car's motion is unknown on {dataset} ({n} drives): boxes are held there, and there are no speeds."
            )
        }));
        Ok(Self { run, detectors, drives, notes })
    }

    /// The times of detection from `source`.
    pub fn latencies(&self, source: &LatencySource<'_>) -> Result<Vec<Vec<Vec<f64>>>, Usage> {
        let latencies = source.latencies(&self.drives, &self.detectors);
        latencies.map_err(|NoLatency { detector }| {
            Usage(format!(
                "no time of detection of {detector} is known: give it with --latency {detector}=120ms"
            ))
        })
    }

    /// Its moments as `rule` asks for them; measured times are taken `slower` times as long.
    fn moments(&self, rule: &StreamRule, slower: f64) -> Result<Tally, Failure> {
        let fixed_ms = match rule.lateness {
            Lateness::Fixed(ms) => self.detectors.iter().map(|it| ((*it).to_owned(), ms)).collect(),
            Lateness::Measured => BTreeMap::new(),
        };
        let mut latencies = self.latencies(&LatencySource { fixed_ms, elsewhere: None })?;
        if rule.lateness == Lateness::Measured {
            latencies.iter_mut().flatten().flatten().for_each(|it| *it *= slower);
        }
        let known = self.run.tally();
        let tasks: Vec<Task> =
            known.tasks().iter().copied().filter(|it| rule.rule.is_within(it.name())).collect();
        let study = StreamStudy {
            drives: &self.drives,
            detectors: &self.detectors,
            tasks: &tasks,
            latencies: &latencies,
            criterion: by_boxes(rule.criterion),
            step_us: GATED_STEP_US,
            is_in_full: false,
        };
        Ok(study.run(|| self.run.manifest.tally_of_moments(), || Ok::<(), Failure>(()))?.streamed)
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
    // A detector that only the later run has is not gated.
    let names: Vec<&str> = before.0.detector_names();
    let of_after: Vec<&str> = after.0.detector_names().into_iter().filter(|it| names.contains(it)).collect();
    let sides = [Stream::of(before.0, before.1, names)?, Stream::of(after.0, after.1, of_after)?];
    let references = sides.each_ref().map(Stream::reference_ms);
    let slower = references[0].zip(references[1]).map_or(1.0, |(before, after)| before / after);
    let pair = |rule: &StreamRule| {
        Ok(StreamPair { before: sides[0].moments(rule, 1.0)?, after: sides[1].moments(rule, slower)? })
    };
    tolerances.streams.iter().map(pair).collect()
}
