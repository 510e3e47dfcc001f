//! Makes an event of every scan as soon as it is judged.

use std::cell::Cell;

use evaluation::run::rows::TaskRows;
use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use reports::rows::official_rows::OfficialRows;
use reports::vocabulary::protocol::Protocol;
use reports::worst::objects::{ObjectName, WorstObjects};
use reports::worst::points::Patch;

use super::run_event::{RunEvent, ScanEvent};
use super::run_log::RunLog;
use crate::plumbing::failure::Failure;
use crate::plumbing::official_evaluation::OfficialEvaluation;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::scan_agreement::agreement_of;
use crate::plumbing::sinks::plan_cells::plan_cells;

/// Adds an event to the log for each scan that is judged or left out.
pub struct ScanEvents<'a> {
    log: &'a RunLog<'a>,
    datasets: &'a [OpenedDataset],
    dataset_idx: usize,
    // By data set, how many of the skipped scans are in the log.
    n_skipped: Vec<usize>,
    // Which mistakes may be among the worst, and which matches among the best.
    worst: WorstObjects<()>,
    // `None` without protocols of others.
    official: Option<OfficialEvaluation>,
    // The number after that of the last scan.
    end: &'a Cell<Option<u64>>,
}

impl<'a> ScanEvents<'a> {
    /// Logs the scans of `datasets`, also under `protocols` of others, and sets `end` to the number after that of the last
    /// scan.
    pub fn new(
        log: &'a RunLog<'a>,
        datasets: &'a [OpenedDataset],
        protocols: &[Protocol],
        end: &'a Cell<Option<u64>>,
    ) -> Self {
        // Scans that are left out when a data set is opened are reported whenever it is opened again.
        let n_skipped = datasets.iter().map(|it| it.skipped.borrow().len()).collect();
        Self {
            log,
            datasets,
            dataset_idx: 0,
            n_skipped,
            worst: WorstObjects::default(),
            official: OfficialEvaluation::of(protocols),
            end,
        }
    }

    fn add_skipped(&mut self) -> Result<(), Failure> {
        let skipped = self.datasets[self.dataset_idx].skipped.borrow();
        let n_known = &mut self.n_skipped[self.dataset_idx];
        for it in &skipped[*n_known..] {
            let (scan, reason) = (it.scan.clone(), it.reason.clone());
            self.log.add(&RunEvent::Skipped { dataset_idx: self.dataset_idx, scan, reason })?;
        }
        *n_known = skipped.len();
        Ok(())
    }

    fn official_rows(&mut self, judged: &JudgedScan<'_>) -> Result<OfficialRows, Failure> {
        self.official.as_mut().map_or(Ok(OfficialRows::default()), |it| it.rows(judged))
    }

    /// Patches around the mistakes that are worse than those before, and the matches that are better.
    fn patches(&mut self, judged: &JudgedScan<'_>) -> Vec<Patch> {
        let cloud = &judged.results.scan.cloud;
        let sensor_height_m = judged.dataset().sensor_height_m;
        let mut patches: Vec<Patch> = Vec::new();
        let rows = judged.rows.iter().flat_map(|it| &it.tasks).flat_map(|it| &it.matches);
        for row in rows.filter(|it| it.task.class().is_none()) {
            self.worst.add(row, |window| {
                let Some(object) = ObjectName::shown_of(row) else { return };
                // Both tasks may show it.
                if patches.iter().all(|it| it.object != object) {
                    patches.push(Patch { object, cells: plan_cells(cloud, window, sensor_height_m) });
                }
            });
        }
        patches
    }
}

impl RunSink<Failure> for ScanEvents<'_> {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        let id = &watched.dataset.description().id;
        let dataset_idx = self.datasets.iter().position(|it| it.dataset.description().id == *id);
        self.dataset_idx = dataset_idx.expect("it is one of those that are run");
        self.official.as_mut().map_or(Ok(()), |it| it.begin_dataset(watched))
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        self.add_skipped()?;
        let scan = judged.results.scan;
        let tasks: Vec<&TaskRows> = judged.rows.iter().flat_map(|it| &it.tasks).collect();
        let event = ScanEvent {
            dataset_idx: self.dataset_idx,
            place: judged.results.run_idx,
            number: judged.number() as u64,
            is_labeled: scan.is_labeled(),
            n_labels: scan.annotations.len() as u64,
            n_points_left_out: scan.points_left_out.len() as u64,
            scans: tasks.iter().map(|it| it.scan.clone()).collect(),
            matches: tasks.iter().flat_map(|it| &it.matches).cloned().collect(),
            stages: judged.rows.iter().flat_map(|it| &it.stages).cloned().collect(),
            pose: judged.pose_row()?.into_iter().collect(),
            official: self.official_rows(judged)?,
            agreement: if scan.is_labeled() { Vec::new() } else { agreement_of(judged) },
            patches: self.patches(judged),
        };
        self.end.set(Some(event.number + 1));
        self.log.add(&RunEvent::Scan(Box::new(event)))
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        if let Some(official) = &self.official {
            official.end_dataset();
        }
        self.add_skipped()
    }
}
