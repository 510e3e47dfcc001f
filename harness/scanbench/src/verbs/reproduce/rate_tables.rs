//! The F-rates of a run on one part of the objects after another.

use reports::numbers::tally::Tally;
use reports::reproduction::lead::LeadsOf;
use reports::reproduction::steps::{Basis, DENIED_RIVALS, GOOD_FAITH, SEARCHED_RIVAL, STEPS};
use reports::tables::studies::rate_table::{RateRow, RateTable, printed_rows};
use reports::tables::studies::step_table::{StepRow, StepTable};
use reports::uncertainty::sample::{Question, Sample};
use reports::vocabulary::metric::Metric;
use reports::vocabulary::slice::Slice;
use reports::vocabulary::task::Task;

use super::METHOD;
use super::settings_study::RIVALS;

pub struct RateTables<'a> {
    pub tally: &'a Tally,
    /// Samples of the run.
    pub leads: &'a LeadsOf<'a>,
}

impl RateTables<'_> {
    /// Table 1 of each paper: the F-rate of method and rivals, scene by scene.
    pub fn by_scene(&self) -> Vec<RateTable> {
        let table = |task: Task| {
            let rows =
                self.scenes().into_iter().filter_map(|scene| self.row(&scene, &scene, task, Slice::All));
            let detectors = self.detectors();
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

    /// F-rates by range and by number of points, over all scenes.
    pub fn by_part(&self) -> Vec<RateTable> {
        let Some(pool) = self.tally.pools().into_iter().next() else { return Vec::new() };
        let table = |task: Task| {
            let slices = self.tally.slices(task, METHOD).into_iter();
            let slices = slices.filter(Slice::has_false_detections);
            let rows = slices.filter_map(|slice| self.row(&slice.name(), pool.extent.name(), task, slice));
            RateTable {
                title: format!(
                    "Task {task}, {}, by range in metres and by number of points",
                    pool.extent.name()
                ),
                rate: "F-rate %",
                detectors: self.detectors(),
                rows: rows.collect(),
                notes: Vec::new(),
            }
        };
        Task::ALL.map(table).to_vec()
    }

    /// The F-rate of the method after each step, and of its rivals, scene by scene: a table for each task.
    pub fn by_step(&self) -> Vec<StepTable> {
        let steps = STEPS.iter().map(|step| (step.detector, step.name, step.place, Some(step.basis)));
        let rivals = RIVALS.iter().map(|(rival, task)| (*task, (*rival, *rival, "", None)));
        let denied = DENIED_RIVALS.iter().map(|it| (Task::Objects, (it.detector, it.name, "", None)));
        let rivals: Vec<_> = rivals.chain(denied).collect();
        let table = |task: Task| {
            let of_task = rivals.iter().filter(|it| it.0 == task).map(|it| it.1);
            let rows: Vec<_> = steps.clone().chain(of_task).collect();
            let detectors: Vec<String> = rows.iter().map(|it| it.0.to_owned()).collect();
            let row_of = |scene: &String| self.rates_of(&detectors, scene, task, Slice::All);
            let known = self.scenes().into_iter().filter_map(|scene| Some((row_of(&scene)?, scene)));
            let (counts, scenes): (Vec<_>, Vec<String>) = known.unzip();
            let of_row =
                |(idx, (_, name, place, basis)): (usize, &(&str, &str, &str, Option<Basis>))| StepRow {
                    name: (*name).to_owned(),
                    place: (*place).to_owned(),
                    basis: *basis,
                    rates: counts.iter().map(|(_, rates)| rates[idx]).collect(),
                };
            StepTable {
                title: format!("Task {task}, F-rate in %, step by step"),
                scenes: scenes.into_iter().zip(counts.iter().map(|it| it.0)).collect(),
                rows: rows.iter().enumerate().map(of_row).collect(),
                notes: STEPS.iter().map(|step| format!("{}: {}", step.name, step.says)).collect(),
            }
        };
        Task::ALL.map(table).to_vec()
    }

    /// All detectors but the steps, which have a table of their own.
    fn detectors(&self) -> Vec<String> {
        let steps = STEPS.iter().map(|step| step.detector).filter(|it| *it != GOOD_FAITH);
        let rivals = DENIED_RIVALS.iter().chain([&SEARCHED_RIVAL]).map(|it| it.detector);
        let apart: Vec<&str> = steps.chain(rivals).collect();
        self.tally.detectors().iter().filter(|it| !apart.contains(&it.as_str())).cloned().collect()
    }

    /// The data sets, and their pools if there are several.
    fn scenes(&self) -> Vec<String> {
        let mut scenes: Vec<String> = self.tally.datasets().to_vec();
        if scenes.len() > 1 {
            scenes.extend(self.tally.pools().into_iter().map(|it| it.extent.name().to_owned()));
        }
        scenes
    }

    fn row(&self, name: &str, dataset: &str, task: Task, slice: Slice) -> Option<RateRow> {
        let (no, rates) = self.rates_of(&self.detectors(), dataset, task, slice)?;
        Some(RateRow { name: name.to_owned(), no, rates, is_printed: false })
    }

    /// The annotations that count, and the F-rate of each of `detectors`; `None` if nothing was seen of the kind.
    fn rates_of(
        &self,
        detectors: &[String],
        dataset: &str,
        task: Task,
        slice: Slice,
    ) -> Option<(u64, Vec<Option<f64>>)> {
        let sample = |detector: &String| -> Option<Sample> {
            self.leads.sample(&Question { dataset, task, detector, slice })
        };
        let samples: Vec<Option<Sample>> = detectors.iter().map(sample).collect();
        let no = samples.iter().flatten().find_map(|it| it.value(&Metric::No))?;
        Some((no as u64, samples.iter().map(|it| it.as_ref()?.value(&Metric::FRate)).collect()))
    }
}
