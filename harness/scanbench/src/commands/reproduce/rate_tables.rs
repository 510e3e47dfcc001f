//! The F-rates of a run on one part of the objects after another.

use reports::numbers::tally::Tally;
use reports::reproduction::lead::LeadsOf;
use reports::tables::studies::rate_table::{RateRow, RateTable, printed_rows};
use reports::uncertainty::sample::{Question, Sample};
use reports::vocabulary::metric::Metric;
use reports::vocabulary::slice::Slice;
use reports::vocabulary::task::Task;

use super::METHOD;

/// The tables of the run of a tally.
pub struct RateTables<'a> {
    /// The run.
    pub tally: &'a Tally,
    /// Its samples.
    pub leads: &'a LeadsOf<'a>,
}

impl RateTables<'_> {
    /// Table 1 of each paper: the F-rate of method and rivals, scene by scene.
    pub fn by_scene(&self) -> Vec<RateTable> {
        let overall = self.tally.pools().into_iter().map(|it| it.extent.name().to_owned());
        let mut scenes: Vec<String> = self.tally.datasets().to_vec();
        scenes.extend(overall.filter(|_| scenes.len() > 1).collect::<Vec<_>>());
        let table = |task: Task| {
            let rows = scenes.iter().filter_map(|scene| self.row(scene.clone(), scene, task, Slice::All));
            let detectors = self.tally.detectors().to_vec();
            RateTable {
                title: format!("Task {task}, scene by scene"),
                rate: "F-rate %",
                rows: rows.chain(printed_rows(task, &detectors)).collect(),
                detectors,
                notes: vec![format!(
                    "Vehicles among the clusters of kd-tree are classified by trees that are in no paper; pca and paper have the classifiers of their \
                     papers. The papers' scans of Budapest are not public."
                )],
            }
        };
        Task::ALL.map(table).to_vec()
    }

    /// The same by range and by number of points, over all scenes.
    pub fn by_part(&self) -> Vec<RateTable> {
        let Some(pool) = self.tally.pools().into_iter().next() else { return Vec::new() };
        let table = |task: Task| {
            let slices = self.tally.slices(task, METHOD).into_iter();
            let slices = slices.filter(Slice::has_false_detections);
            let rows = slices.filter_map(|slice| self.row(slice.name(), pool.extent.name(), task, slice));
            RateTable {
                title: format!(
                    "Task {task}, {}, by range in metres and by number of points",
                    pool.extent.name()
                ),
                rate: "F-rate %",
                detectors: self.tally.detectors().to_vec(),
                rows: rows.collect(),
                notes: Vec::new(),
            }
        };
        Task::ALL.map(table).to_vec()
    }

    fn row(&self, name: String, dataset: &str, task: Task, slice: Slice) -> Option<RateRow> {
        let sample = |detector: &String| -> Option<Sample> {
            self.leads.sample(&Question { dataset, task, detector, slice })
        };
        let samples: Vec<Option<Sample>> = self.tally.detectors().iter().map(sample).collect();
        let no = samples.iter().flatten().find_map(|it| it.value(&Metric::No))?;
        let rates = samples.iter().map(|it| it.as_ref()?.value(&Metric::FRate)).collect();
        Some(RateRow { name, no: no as u64, rates, is_printed: false })
    }
}
