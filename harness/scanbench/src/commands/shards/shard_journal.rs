//! Keeps every scan of a shard as soon as it is judged.

use std::cell::Cell;

use evaluation::journal::Journal;
use evaluation::run::rows::TaskRows;
use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use reports::files::csv_rows::to_csv_lines;
use reports::rows::official_rows::OfficialLines;
use reports::vocabulary::protocol::Protocol;
use reports::worst::objects::{ObjectName, WorstObjects};
use reports::worst::points::Patch;

use super::shard_entry::{ShardEntry, ShardScan};
use crate::commands::failure::Failure;
use crate::commands::official_evaluation::OfficialEvaluation;
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::scan_agreement::agreement_of;
use crate::commands::sinks::plan_cells::plan_cells;

/// Writes scans to the journal, each in a line of its own.
pub struct ShardJournal<'a> {
    journal: &'a Journal,
    datasets: &'a [OpenedDataset],
    dataset_idx: usize,
    // Of each data set, how many of the scans that were skipped are in the journal.
    n_skipped: Vec<usize>,
    // Which mistakes may be among the worst, and which matches among the best.
    worst: WorstObjects<()>,
    // `None` without protocols of others.
    official: Option<OfficialEvaluation>,
    // The number behind that of the last scan.
    end: &'a Cell<Option<u64>>,
}

impl<'a> ShardJournal<'a> {
    /// Writes what happens in `datasets`, also under `protocols` of others, and sets `end` to the number after that of the
    /// last scan.
    pub fn new(
        journal: &'a Journal,
        datasets: &'a [OpenedDataset],
        protocols: &[Protocol],
        end: &'a Cell<Option<u64>>,
    ) -> Self {
        // What opening a data set left out is reported again when it is opened again.
        let n_skipped = datasets.iter().map(|it| it.skipped.borrow().len()).collect();
        Self {
            journal,
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
            self.journal.add(&ShardEntry::Skipped { dataset_idx: self.dataset_idx, scan, reason })?;
        }
        *n_known = skipped.len();
        Ok(())
    }

    fn official_lines(&mut self, judged: &JudgedScan<'_>) -> Result<OfficialLines, Failure> {
        let Some(official) = &mut self.official else { return Ok(OfficialLines::default()) };
        Ok(official.rows(judged)?.to_lines()?)
    }

    /// What the sensor saw around the mistakes that are worse than those before, and the matches that are better.
    fn patches(&mut self, judged: &JudgedScan<'_>) -> Vec<Patch> {
        let cloud = &judged.results.scan.cloud;
        let sensor_height_m = judged.dataset().sensor_height_m;
        let mut patches: Vec<Patch> = Vec::new();
        for row in judged.rows.iter().flat_map(|it| &it.tasks).flat_map(|it| &it.matches) {
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

impl RunSink<Failure> for ShardJournal<'_> {
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
        let entry = ShardScan {
            dataset_idx: self.dataset_idx,
            place: judged.results.run_idx,
            number: judged.number() as u64,
            is_labeled: scan.is_labeled(),
            n_labels: scan.annotations.len() as u64,
            n_points_left_out: scan.points_left_out.len() as u64,
            scans: text(to_csv_lines(tasks.iter().map(|it| &it.scan))?),
            n_scan_rows: tasks.len() as u64,
            matches: text(to_csv_lines(tasks.iter().flat_map(|it| &it.matches))?),
            stages: text(to_csv_lines(judged.rows.iter().flat_map(|it| &it.stages))?),
            official: self.official_lines(judged)?,
            agreement: if scan.is_labeled() { Vec::new() } else { agreement_of(judged) },
            patches: self.patches(judged),
        };
        self.end.set(Some(entry.number + 1));
        Ok(self.journal.add(&ShardEntry::Scan(Box::new(entry)))?)
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        if let Some(official) = &self.official {
            official.end_dataset();
        }
        self.add_skipped()
    }
}

fn text(lines: Vec<u8>) -> String {
    String::from_utf8(lines).expect("rows are text")
}
