//! Rows of a run, gathered one by one: its numbers and its page are made of them.

use std::collections::BTreeMap;

use super::seen_boxes::SeenBoxes;
use crate::numbers::confusion::Confusion;
use crate::numbers::pools::Pool;
use crate::numbers::tally::Tally;
use crate::protocols::given_classes::GivenClasses;
use crate::rows::kitti_object_row::KittiObjectRow;
use crate::rows::match_row::MatchRow;
use crate::rows::ranked_box_row::RankedBoxRow;
use crate::rows::scan_name::ScanName;
use crate::rows::scan_row::{ScanOutcome, ScanRow};
use crate::rows::stage_row::StageRow;
use crate::run_folder::manifest::Manifest;
use crate::verdicts::reason_gains::ReasonTally;
use crate::vocabulary::task::Task;
use crate::worst::objects::WorstObjects;
use crate::worst::points::PlanCells;

/// Rows of a run, gathered one by one: those of a scan before its matches, and these scan by scan.
#[derive(Debug)]
pub struct GatheredRun {
    /// The sums.
    pub tally: Tally,
    /// The worst mistakes, with what was seen around them.
    pub worst: WorstObjects<Surroundings>,
    pub(crate) pools: Vec<Pool>,
    /// Times of all scans in milliseconds, of every pool and detector.
    pub(crate) times_ms: Vec<Vec<(String, Vec<f64>)>>,
    /// The first scan that a detector gave no answer to, and why.
    pub(crate) failures: BTreeMap<String, (ScanName, String)>,
    pub(crate) reasons: ReasonTally,
    pub(crate) boxes: SeenBoxes,
    pub(crate) given: GivenClasses,
    pub(crate) confusion: Confusion,
    has_like_processors: bool,
    first_task: Option<Task>,
}

/// Points around an object, and its scan.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surroundings {
    /// Cells with points around it.
    pub cells: PlanCells,
    /// Number of its scan among all scans of the run.
    pub scan_number: u64,
    /// Index of the shard that has seen it.
    pub shard_idx: usize,
}

impl GatheredRun {
    /// No rows yet of the run of `manifest`.
    pub fn of(manifest: &Manifest) -> Self {
        let pools = manifest.pools();
        let no_times = || manifest.detectors.iter().map(|it| (it.name.clone(), Vec::new())).collect();
        Self {
            tally: manifest.tally(),
            worst: WorstObjects::default(),
            times_ms: pools.iter().map(|_| no_times()).collect(),
            pools,
            failures: BTreeMap::new(),
            reasons: ReasonTally::default(),
            boxes: SeenBoxes::default(),
            given: GivenClasses::default(),
            confusion: Confusion::default(),
            has_like_processors: manifest.is_of_like_processors(),
            first_task: None,
        }
    }

    /// Adds the row of one detector on one scan in one task.
    pub fn add_scan(&mut self, row: &ScanRow) {
        self.tally.add_scan(row);
        let ScanOutcome::Evaluated(numbers) = &row.outcome else { return };
        if let Some(reason) = &numbers.failure {
            let first = || (row.scan_name(), reason.clone());
            self.failures.entry(row.detector.clone()).or_insert_with(first);
        }
        // Every task has a row about the same detection.
        let is_first = *self.first_task.get_or_insert(row.task) == row.task;
        let pool_idx = self.pools.iter().position(|it| it.datasets.contains(&row.dataset));
        let of_pool = pool_idx.filter(|_| is_first && self.has_like_processors);
        let of_pool = of_pool.map(|it| &mut self.times_ms[it]);
        let times = of_pool.and_then(|it| it.iter_mut().find(|(name, _)| *name == row.detector));
        if let Some((_, times)) = times {
            times.extend(numbers.latency_ms.filter(|it| *it > 0.0));
        }
    }

    /// Adds the outcome of an object; `surroundings` is called if the object is among the worst.
    pub fn add_match(&mut self, row: &MatchRow, surroundings: impl FnOnce() -> Surroundings) {
        self.tally.add_match(row);
        self.confusion.add_match(row);
        if row.task.class().is_some() {
            // The same objects are in the rows of all objects.
            return;
        }
        self.boxes.add(row, &self.worst);
        self.worst.add(row, |_| surroundings());
        self.reasons.add_match(row);
    }

    /// Adds the time of a stage.
    pub fn add_stage(&mut self, row: &StageRow) {
        self.tally.add_stage(row);
    }

    /// Adds a box under a protocol that ranks boxes.
    pub fn add_ranked_box(&mut self, row: &RankedBoxRow) {
        self.given.add_ranked_box(row);
    }

    /// Adds an object under KITTI's protocols.
    pub fn add_kitti_object(&mut self, row: &KittiObjectRow) {
        self.given.add_kitti_object(row);
    }
}
