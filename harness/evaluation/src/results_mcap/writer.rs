//! The recording of a run on one data set.
//!
//! ```text
//! /lidar/points, /annotations, /tf     the scans, as `data convert` writes them
//! /DETECTOR/TASK/outcomes              foxglove.SceneUpdate: one entity for each row of matches.csv
//! /DETECTOR/TASK/numbers               JSON: one message for each row of scans.csv
//! ```

use std::path::Path;

use reports::numbers::tally::Tally;
use scans::annotation::LabeledScan;
use scans::conversion::convert::{sheet_of, times_of};
use scans::conversion::mcap_writer::{ChunkCompression, McapWriter};
use scans::conversion::scene::scene_of;
use scans::conversion::{ConversionError, ScanToWrite, ScanWriter as _};
use scans::dataset::Dataset;

use super::outcome_scene::outcome_entities;
use super::scan_numbers::{SCAN_NUMBERS, SCAN_NUMBERS_SCHEMA, ScanNumbersMessage};
use crate::run::rows::{DetectorRows, TaskRows};
use crate::run::sink::JudgedScan;

/// A recording that grows scan by scan.
#[must_use = "a recording that is not finished is thrown away"]
pub struct ResultsMcap {
    // Time of each scan of the run.
    times_ns: Vec<u64>,
    writer: Box<McapWriter>,
    tally: Tally,
}

impl ResultsMcap {
    /// Begins the recording `path` of a run on the scans of `dataset` at `scan_indices`.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if nothing can be written there.
    pub fn create(
        path: &Path,
        dataset: &dyn Dataset,
        scan_indices: &[usize],
    ) -> Result<Self, ConversionError> {
        let sheet = sheet_of(dataset.description());
        let writer = Box::new(McapWriter::create(path, ChunkCompression::Zstd, sheet)?);
        Ok(Self { times_ns: times_of(dataset, scan_indices), writer, tally: Tally::default() })
    }

    /// Appends a scan of that data set, with the results of all detectors.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if the disk does not take it, or the pose of the sensor cannot be read.
    pub fn add(&mut self, judged: &JudgedScan<'_>) -> Result<(), ConversionError> {
        let time_ns = self.times_ns[judged.results.run_idx];
        let world_from_sensor = judged.watched.dataset.world_from_sensor(judged.scan_idx())?;
        let scan = judged.results.scan;
        self.writer.write(&ScanToWrite { scan, time_ns, world_from_sensor })?;
        for detector in &judged.rows {
            for task in &detector.tasks {
                self.add_result(time_ns, scan, detector, task)?;
            }
        }
        Ok(())
    }

    fn add_result(
        &mut self,
        time_ns: u64,
        scan: &LabeledScan,
        detector: &DetectorRows,
        task: &TaskRows,
    ) -> Result<(), ConversionError> {
        let TaskRows { scan: row, matches } = task;
        let topic = format!("/{}/{}", row.detector, row.task);
        let scene = scene_of(time_ns, outcome_entities(time_ns, scan, matches));
        self.writer.write_scene(&format!("{topic}/outcomes"), time_ns, &scene)?;
        self.tally.add_scan(row);
        let so_far = self.tally.counts(&row.dataset, row.task, &row.detector);
        if let Some(so_far) = so_far
            && let Some(message) = ScanNumbersMessage::new(row, &detector.stages, so_far)
        {
            let schema = [SCAN_NUMBERS, SCAN_NUMBERS_SCHEMA];
            self.writer.write_json(&format!("{topic}/numbers"), schema, time_ns, &message)?;
        }
        Ok(())
    }

    /// Completes the recording; only then it appears under its name.
    ///
    /// # Errors
    ///
    /// [`ConversionError`] if the disk does not take it.
    pub fn finish(self) -> Result<(), ConversionError> {
        self.writer.finish()
    }
}
