//! The recording of a run on one data set.
//!
//! ```text
//! /lidar/points, /annotations, /tf     the scans, as `data convert` writes them
//! /DETECTOR/TASK/outcomes              foxglove.SceneUpdate: one entity for each row of matches.csv
//! /DETECTOR/TASK/numbers               JSON: one message for each row of scans.csv
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use detector::detector::StageTime;
use reports::rows::counts::Counts;
use reports::rows::match_row::MatchRow;
use reports::rows::scan_row::{ScanOutcome, ScanRow};

use super::outcome_scene::outcome_entities;
use super::scan_numbers::{SCAN_NUMBERS, SCAN_NUMBERS_SCHEMA, ScanNumbersMessage};
use crate::annotation::LabeledScan;
use crate::conversion::convert::{sheet_of, times_of};
use crate::conversion::mcap_writer::{ChunkCompression, McapWriter};
use crate::conversion::scene::scene_of;
use crate::conversion::{ConversionError, ScanToWrite, ScanWriter as _};
use crate::dataset::Dataset;

/// What one detector made of one scan in one task.
#[derive(Debug, Clone, Copy)]
pub struct DetectorResult<'a> {
    /// Its row of `scans.csv`.
    pub scan_row: &'a ScanRow,
    /// Its rows of `matches.csv`.
    pub match_rows: &'a [MatchRow],
    /// How long its stages took.
    pub stage_times: &'a [StageTime],
}

/// A recording that grows scan by scan.
#[must_use = "a recording that is not finished is thrown away"]
pub struct ResultsRecording<'a> {
    dataset: &'a dyn Dataset,
    scan_indices: &'a [usize],
    times_ns: Vec<u64>,
    writer: Box<McapWriter>,
    time_ns: u64,
    counts_by_topic: BTreeMap<String, Counts>,
}

impl<'a> ResultsRecording<'a> {
    /// Begins the recording `path` of a run on the scans of `dataset` at `scan_indices`.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if nothing can be written there.
    pub fn create(
        path: &Path,
        dataset: &'a dyn Dataset,
        scan_indices: &'a [usize],
    ) -> Result<Self, ConversionError> {
        let sheet = sheet_of(dataset.description());
        let writer = Box::new(McapWriter::create(path, ChunkCompression::Zstd, sheet)?);
        let times_ns = times_of(dataset, scan_indices);
        Ok(Self { dataset, scan_indices, times_ns, writer, time_ns: 0, counts_by_topic: BTreeMap::new() })
    }

    /// Appends the scan at place `run_idx` of the run; the results of this scan come next.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if the disk does not take it, or where the sensor was cannot be read.
    pub fn add_scan(&mut self, run_idx: usize, scan: &LabeledScan) -> Result<(), ConversionError> {
        self.time_ns = self.times_ns[run_idx];
        let world_from_sensor = self.dataset.world_from_sensor(self.scan_indices[run_idx])?;
        self.writer.write(&ScanToWrite { scan, time_ns: self.time_ns, world_from_sensor })
    }

    /// Appends what a detector made of the scan that was added last.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if the disk does not take it.
    pub fn add_result(
        &mut self,
        scan: &LabeledScan,
        result: &DetectorResult<'_>,
    ) -> Result<(), ConversionError> {
        let DetectorResult { scan_row, match_rows, stage_times } = *result;
        let topic = format!("/{}/{}", scan_row.detector, scan_row.task);
        let scene = scene_of(self.time_ns, outcome_entities(self.time_ns, scan, match_rows));
        self.writer.write_scene(&format!("{topic}/outcomes"), self.time_ns, &scene)?;
        let so_far = self.counts_so_far(&topic, scan_row);
        if let Some(so_far) = so_far
            && let Some(message) = ScanNumbersMessage::new(scan_row, stage_times, so_far)
        {
            let schema = [SCAN_NUMBERS, SCAN_NUMBERS_SCHEMA];
            self.writer.write_json(&format!("{topic}/numbers"), schema, self.time_ns, &message)?;
        }
        Ok(())
    }

    /// The sums with this scan; `None` if it was not evaluated.
    fn counts_so_far(&mut self, topic: &str, scan_row: &ScanRow) -> Option<Counts> {
        let ScanOutcome::Evaluated(numbers) = &scan_row.outcome else { return None };
        let sum = match self.counts_by_topic.get(topic) {
            None => numbers.counts,
            Some(before) => sum_of(*before, numbers.counts)?,
        };
        self.counts_by_topic.insert(topic.to_owned(), sum);
        Some(sum)
    }

    /// Ends the recording, which appears under its name now.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if the disk does not take it.
    pub fn finish(self) -> Result<(), ConversionError> {
        self.writer.finish()
    }
}

/// False detections are known of the sum if they are of both.
fn sum_of(a: Counts, b: Counts) -> Option<Counts> {
    let fo = a.fo().zip(b.fo()).map(|(a, b)| a + b);
    Counts::new(a.no() + b.no(), a.tp() + b.tp(), fo)
}
