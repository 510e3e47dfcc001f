//! What a sweep has counted, scan by scan, as sums from which its numbers are made.
//!
//! Sums are kept by seconds of drives, and no scan: a sweep in one piece and its shards come to the same digits.

use std::collections::BTreeMap;

use detector::grid::cell_fitness::{CellTally, FitnessReading};
use reports::numbers::blocks::DriveSecond;
use reports::numbers::sweep_score::{SweepScores, SweepSubject};
use reports::protocols::drawn_scans::DrawnScans;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::protocols::swept_numbers::{SweptNumber, SweptNumbers};
use reports::rows::official_rows::OfficialRows;
use reports::rows::scan_name::ScanName;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::sweep_entry::SweepEntry;
use reports::vocabulary::extent::Extent;
use reports::vocabulary::task::Task;

use crate::metrics::counts::Counts;
use crate::sweep::journal_entry::TimedScan;
use crate::sweep::scan_at_point::{DetectorAtPoint, ScanAtPoint};

/// Sums of a sweep.
pub struct SweepTally<'a> {
    pub(super) manifest: &'a Manifest,
    pub(super) entry: &'a SweepEntry,
    pub(super) datasets: Vec<DatasetSums>,
    pub(super) times: Vec<TimedScan>,
    // Of each point, the rows of protocols of others.
    pub(super) protocols: Vec<ProtocolTally>,
}

/// Sums over scans of a data set.
#[derive(Debug, Clone, Default)]
pub(super) struct DatasetSums {
    pub(super) scans: Vec<(ScanName, DriveSecond)>,
    // Of each second, detector by detector and of each point by point.
    pub(super) of_seconds: BTreeMap<DriveSecond, Vec<PointSums>>,
}

/// What one detector made of some scans at one point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PointSums {
    /// For each of [`Task::ALL`].
    pub(super) counts: [Counts; Task::ALL.len()],
    pub(super) cells: Option<CellSums>,
}

/// What the cells of some scans on one grid come to.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellSums {
    pub(super) cell_size_m: f32,
    pub(super) n_dense_sparse_empty: [u64; 3],
    // Numerator and denominator of each of `FitnessReading::ALL`.
    pub(super) readings: [[f64; 2]; FitnessReading::ALL.len()],
}

impl<'a> SweepTally<'a> {
    /// Nothing yet, of the sweep of `manifest`; `None` if it is of no sweep.
    pub fn of(manifest: &'a Manifest) -> Option<Self> {
        let entry = manifest.sweep.as_ref()?;
        let datasets = vec![DatasetSums::default(); manifest.datasets.len()];
        let protocols = vec![ProtocolTally::default(); entry.points.len()];
        Some(Self { manifest, entry, datasets, times: Vec::new(), protocols })
    }

    /// Adds a scan at a point. Scans come in the order of the sweep, and each with its points in theirs.
    pub fn add(&mut self, scan: &ScanAtPoint) {
        let (n_detectors, n_points) = (self.manifest.detectors.len(), self.entry.points.len());
        let dataset = &mut self.datasets[scan.dataset_idx];
        if scan.point_idx == 0 {
            let id = self.manifest.datasets[scan.dataset_idx].id.clone();
            let name = ScanName { dataset: id, sequence: scan.sequence.clone(), scan: scan.scan };
            dataset.scans.push((name, scan.second.clone()));
        }
        let nothing = || vec![PointSums::default(); n_detectors * n_points];
        if !dataset.of_seconds.contains_key(&scan.second) {
            dataset.of_seconds.insert(scan.second.clone(), nothing());
        }
        let sums = dataset.of_seconds.get_mut(&scan.second).expect("it is there now");
        for (detector_idx, found) in scan.detectors.iter().enumerate() {
            sums[detector_idx * n_points + scan.point_idx].add(found);
        }
    }

    /// Adds the rows of a scan under protocols of others at a point of the sweep. Scans may come in any order.
    pub fn add_official(&mut self, point_idx: usize, rows: &OfficialRows) {
        self.protocols[point_idx].add(rows);
    }

    /// Makes sure that the rows under protocols of others fit together.
    ///
    /// # Errors
    ///
    /// A sentence that says in which scan they do not, and how.
    pub fn check_official(&self) -> Result<(), String> {
        self.protocols.iter().try_for_each(ProtocolTally::check)
    }

    /// Adds a scan that was timed. Scans come in the order of the sweep.
    pub fn add_times(&mut self, scan: TimedScan) {
        self.times.push(scan);
    }

    /// The different processors that scans were timed on, in the order of the sweep.
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

impl PointSums {
    fn add(&mut self, found: &DetectorAtPoint) {
        for (sum, counts) in self.counts.iter_mut().zip(&found.counts) {
            *sum += *counts;
        }
        if let Some(tally) = &found.cells {
            self.cells.get_or_insert_with(|| CellSums::none(tally.cell_size_m)).add(tally);
        }
    }

    /// Adds the sums of other scans.
    pub(super) fn add_sums(&mut self, other: &Self) {
        for (sum, counts) in self.counts.iter_mut().zip(&other.counts) {
            *sum += *counts;
        }
        if let Some(cells) = &other.cells {
            self.cells.get_or_insert_with(|| CellSums::none(cells.cell_size_m)).add_sums(cells);
        }
    }
}

impl CellSums {
    fn none(cell_size_m: f32) -> Self {
        Self { cell_size_m, n_dense_sparse_empty: [0; 3], readings: [[0.0; 2]; FitnessReading::ALL.len()] }
    }

    fn add(&mut self, tally: &CellTally) {
        self.add_sums(&Self {
            cell_size_m: tally.cell_size_m,
            n_dense_sparse_empty: [tally.n_dense, tally.n_sparse, tally.n_empty],
            readings: FitnessReading::ALL.map(|it| it.ratio(tally)),
        });
    }

    fn add_sums(&mut self, other: &Self) {
        for (sum, number) in self.n_dense_sparse_empty.iter_mut().zip(other.n_dense_sparse_empty) {
            *sum += number;
        }
        for (sum, terms) in self.readings.iter_mut().zip(other.readings) {
            *sum = [sum[0] + terms[0], sum[1] + terms[1]];
        }
    }
}

impl SweepTally<'_> {
    /// The numbers of each data set and, if there are several, of all together; `scores` is the summary of the same sweep.
    /// `on_point` is called after each point.
    pub fn protocol_numbers(&self, scores: &SweepScores, on_point: impl Fn()) -> SweptNumbers {
        let key = |it: &SweepSubject| (it.point_idx, it.extent.name().to_owned(), it.detector.clone());
        let subjects: BTreeMap<_, &SweepSubject> =
            scores.scores.iter().map(|it| (key(&it.subject), &it.subject)).collect();
        let detectors: Vec<&str> = self.manifest.detectors.iter().map(|it| it.name.as_str()).collect();
        let drawn: Vec<(&str, DrawnScans)> =
            scores.extents().into_iter().map(|it| (it.name(), self.drawn_scans(it))).collect();
        let mut numbers = Vec::new();
        for (point_idx, tally) in self.protocols.iter().enumerate() {
            for number in tally.numbers_on(&drawn, &detectors) {
                let subject = &subjects[&(point_idx, number.dataset.clone(), number.detector.clone())];
                numbers.push(SweptNumber { subject: (*subject).clone(), number });
            }
            on_point();
        }
        SweptNumbers { parameters: scores.parameters.clone(), n_swept: scores.n_swept, numbers }
    }

    fn drawn_scans(&self, extent: &Extent) -> DrawnScans {
        let datasets = self.manifest.datasets.iter().zip(&self.datasets);
        let is_asked = datasets.filter(|(entry, _)| match extent {
            Extent::Dataset(id) => entry.id == *id,
            Extent::Overall => true,
            Extent::OverallOf(origin) => entry.origin() == *origin,
        });
        DrawnScans::of_datasets(is_asked.map(|(entry, sums)| (entry.id.as_str(), sums.scans.clone())))
    }
}
