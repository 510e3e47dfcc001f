//! Sums of the counts of a sweep, added scan by scan, from which its numbers are made.
//!
//! A detector at a point counts as a detector of its own. Sums of cells are kept by seconds of drives instead of scans: a
//! sweep in one piece and its merged shards give the same digits.

use std::collections::BTreeMap;

use detector::grid::cell_fitness::{CellTally, FitnessReading};
use reports::numbers::blocks::DriveSecond;
use reports::numbers::tally::Tally;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::official_rows::OfficialRows;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::sweep_entry::SweepEntry;

use crate::sweep::scan_at_point::{ScanAtPoint, TimedScan};

/// Sums of a sweep.
pub struct SweepTally<'a> {
    pub(super) manifest: &'a Manifest,
    pub(super) entry: &'a SweepEntry,
    // Counts of every detector at every point.
    pub(super) counts: Tally,
    // Of each data set and each second, the sums of every detector at every point.
    pub(super) cells: Vec<BTreeMap<DriveSecond, Vec<Option<CellSums>>>>,
    pub(super) times: Vec<TimedScan>,
    // Of each point, the tally under official protocols.
    pub(super) protocols: Vec<ProtocolTally>,
}

/// A detector at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct AtPoint {
    pub(super) detector_idx: usize,
    pub(super) point_idx: usize,
}

/// Sums of the cells of some scans on one grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellSums {
    pub(super) cell_size_m: f32,
    pub(super) n_dense_sparse_empty: [u64; 3],
    // Numerator and denominator of each of `FitnessReading::ALL`.
    pub(super) readings: [[f64; 2]; FitnessReading::ALL.len()],
}

impl<'a> SweepTally<'a> {
    /// An empty tally of the sweep of `manifest`; `None` if the manifest has no sweep.
    pub fn of(manifest: &'a Manifest) -> Option<Self> {
        let entry = manifest.sweep.as_ref()?;
        let n_points = entry.points.len();
        let at_points = manifest.detectors.iter().flat_map(|it| {
            (0..n_points).map(|point_idx| entry.entrant(&it.name, point_idx)).collect::<Vec<_>>()
        });
        Some(Self {
            manifest,
            entry,
            counts: manifest.tally().with_detectors(at_points.collect()),
            cells: vec![BTreeMap::new(); manifest.datasets.len()],
            times: Vec::new(),
            protocols: vec![ProtocolTally::default(); n_points],
        })
    }

    /// Index of a detector at a point among all detectors at all points.
    pub(super) fn index_of(&self, at: AtPoint) -> usize {
        at.detector_idx * self.entry.points.len() + at.point_idx
    }

    /// Adds a scan at a point. Scans come in the order of the sweep, and the points of each scan in order, too.
    pub fn add(&mut self, scan: &ScanAtPoint) {
        for row in &scan.scans {
            self.counts.add_scan(row);
        }
        let Some(first) = scan.scans.first() else { return };
        let second = self.counts.block_of(first);
        for (detector_idx, tally) in scan.cells.iter().enumerate() {
            let Some(tally) = tally else { continue };
            let index = self.index_of(AtPoint { detector_idx, point_idx: scan.point_idx });
            let n_sums = self.counts.detectors().len();
            let of_seconds = &mut self.cells[scan.dataset_idx];
            let sums = of_seconds.entry(second.clone()).or_insert_with(|| vec![None; n_sums]);
            let of_scan = CellSums::of(tally);
            sums[index] = Some(sums[index].map_or(of_scan, |it| it.with(of_scan)));
        }
    }

    /// Adds the rows of a scan under official protocols at a point of the sweep. Scans may come in any order.
    pub fn add_official(&mut self, point_idx: usize, rows: &OfficialRows) {
        self.protocols[point_idx].add(rows);
    }

    /// Checks that the rows under official protocols are consistent.
    ///
    /// # Errors
    ///
    /// A sentence that names the scan and the inconsistency.
    pub fn check_official(&self) -> Result<(), String> {
        self.protocols.iter().try_for_each(ProtocolTally::check)
    }

    /// Adds a timed scan. Scans come in the order of the sweep.
    pub fn add_times(&mut self, scan: TimedScan) {
        self.times.push(scan);
    }

    /// Names of the different processors that scans were timed on, in the order of the sweep.
    pub fn processors(&self) -> Vec<&str> {
        let mut processors: Vec<&str> = Vec::new();
        for processor in self.times.iter().map(|it| it.processor.as_str()) {
            if !processors.contains(&processor) {
                processors.push(processor);
            }
        }
        processors
    }
}

impl CellSums {
    fn of(tally: &CellTally) -> Self {
        Self {
            cell_size_m: tally.cell_size_m,
            n_dense_sparse_empty: [tally.n_dense, tally.n_sparse, tally.n_empty],
            readings: FitnessReading::ALL.map(|it| it.ratio(tally)),
        }
    }

    /// Sums of both, on grids of the same size.
    pub(super) fn with(mut self, other: Self) -> Self {
        for (sum, number) in self.n_dense_sparse_empty.iter_mut().zip(other.n_dense_sparse_empty) {
            *sum += number;
        }
        for (sum, terms) in self.readings.iter_mut().zip(other.readings) {
            *sum = [sum[0] + terms[0], sum[1] + terms[1]];
        }
        self
    }
}
