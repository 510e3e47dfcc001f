//! The method under joint settings of all values that the papers leave open, and its rivals beside it.

use std::sync::atomic::AtomicBool;

use evaluation::reproduction::open_values::{OPEN_VALUES, OpenRange};
use evaluation::reproduction::settings::{latin_hypercube, plan, point, points_at, rows_at_points};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::{ChosenDetector, built_in_named};
use evaluation::sweep::sweep_plan::SweepPoint;
use reports::numbers::tally::Tally;
use reports::reproduction::sensitivity::{Sensitivity, SetRate, SetValue};
use reports::vocabulary::extent::OVERALL;
use reports::vocabulary::task::Task;
use simulator::catalogue::DEFAULT_DATASETS;

use super::METHOD;
use crate::cli::{CatalogueArgs, DatasetArgs, ReproduceArgs, SourceArgs};
use crate::plumbing::failure::Failure;
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets};
use crate::plumbing::progress::progress_over_scans;

/// Setting of the method to the letter: printed constants where good faith has others.
pub const LETTER: &str = "vehicle_model.paper_as_printed=true";

/// Seed of the streets for development: nothing that is judged is looked at here.
const DEVELOPMENT_SEED: u64 = 9001;

/// The parameter that says how detections are matched.
const CRITERION: &str = "matching.criterion";

/// What detectors find at points: a tally of each.
pub struct FoundAtPoints(Vec<Tally>);

impl FoundAtPoints {
    /// Runs `detectors` on `datasets` at `points` of the parameters `names`, and adds their rows to tallies like `empty`.
    pub fn of(
        config: &RunConfig,
        detectors: &[&str],
        (names, points): (&[&str], Vec<SweepPoint>),
        datasets: &[OpenedDataset],
        empty: &Tally,
        interrupted: &AtomicBool,
    ) -> Result<Self, Failure> {
        let chosen: Vec<String> = detectors.iter().map(|it| (*it).to_owned()).collect();
        let chosen = built_in_named(&chosen, config)?.into_iter().map(ChosenDetector::from).collect();
        let plan = plan(config, chosen, names, points);
        let mut tallies = vec![empty.clone(); plan.points.len()];
        for it in datasets {
            let progress = progress_over_scans(it.scan_indices.len(), &it.dataset.description().id);
            let on_scan = || progress.inc(1);
            let rows = rows_at_points(&plan, &*it.dataset, &it.scan_indices, interrupted, on_scan)?;
            for (tally, rows) in tallies.iter_mut().zip(rows) {
                for row in &rows {
                    tally.add_scan(row);
                }
            }
            progress.finish_and_clear();
        }
        Ok(Self(tallies))
    }

    /// The tally of each point.
    pub fn tallies(&self) -> &[Tally] {
        &self.0
    }

    /// The F-rate at a point on `extent`, a data set or several; `None` where false detections are not known, or no
    /// annotation counts.
    pub fn f_rate(&self, point_idx: usize, extent: &str, detector: &str, task: Task) -> Option<f64> {
        self.0[point_idx].counts(extent, task, detector).filter(|it| it.no() > 0)?.f_rate()
    }
}

/// All settings, with their rates.
pub struct SettingsStudy {
    pub sensitivity: Sensitivity,
    methods: FoundAtPoints,
    // At each criterion.
    rivals: FoundAtPoints,
    criterion_of_setting: Vec<usize>,
}

/// The rivals, and the task in which each is one.
pub const RIVALS: [(&str, Task); 2] = [("kd-tree", Task::Objects), ("pca", Task::Vehicles)];

/// The criteria of matching that a paper could mean.
pub fn criteria() -> &'static [&'static str] {
    let open = OPEN_VALUES.iter().find(|it| it.parameter == CRITERION);
    match open.map(|it| it.range) {
        Some(OpenRange::Words(words)) => words,
        _ => &["points"],
    }
}

/// The points at which only the criterion differs, in the order of [`criteria`].
pub fn points_by_criterion(config: &RunConfig) -> Result<Vec<SweepPoint>, Failure> {
    let points = criteria().iter().map(|it| point(config, &[CRITERION], vec![(*it).to_owned()]));
    Ok(points.collect::<Result<_, _>>()?)
}

/// The streets for development, with the number of simulated scans and the sensor that were asked for.
fn development_streets(asked: &DatasetArgs) -> DatasetArgs {
    let mut data = asked.clone();
    data.datasets = vec![DEFAULT_DATASETS.to_owned()];
    data.scans = None;
    let SourceArgs { simulated_scans, sensor, .. } = asked.source.clone();
    // Options about recorded files, or about the simulator elsewhere, are not for these.
    data.source = SourceArgs {
        topic: None,
        annotation_topic: None,
        classes: Vec::new(),
        format: None,
        seed: Some(DEVELOPMENT_SEED),
        simulated_scans,
        sensor,
        sensor_height: None,
        labels_ahead: None,
        transform: None,
        columns: None,
        cache: None,
        catalogue: CatalogueArgs { catalogue: None },
    };
    data
}

impl SettingsStudy {
    /// Runs the method under all settings that were asked for, on streets for development; `None` if none were.
    pub fn run(
        arguments: &ReproduceArgs,
        config: &RunConfig,
        interrupted: &AtomicBool,
    ) -> Result<Option<Self>, Failure> {
        let n = arguments.settings as usize;
        if n == 0 {
            return Ok(None);
        }
        let mut config = config.clone();
        let datasets = look_first_at_all(
            open_datasets(&development_streets(&arguments.data), &config.classes)?,
            &mut config,
        );
        let names: Vec<&str> = OPEN_VALUES.iter().map(|it| it.parameter).collect();
        let drawn = latin_hypercube(OPEN_VALUES.len(), n, arguments.settings_seed);
        let points = points_at(&config, &OPEN_VALUES, &drawn)?;
        let settings: Vec<Vec<String>> = points.iter().map(|it| it.values.clone()).collect();
        let found = |detectors: &[&str], points: (&[&str], Vec<SweepPoint>)| {
            FoundAtPoints::of(&config, detectors, points, &datasets, &Tally::default(), interrupted)
        };
        let methods = found(&[METHOD], (&names, points))?;
        let rivals = found(&RIVALS.map(|it| it.0), (&[CRITERION], points_by_criterion(&config)?))?;
        let index = names.iter().position(|it| *it == CRITERION).expect("it is one of them");
        let criterion_of =
            |it: &Vec<String>| criteria().iter().position(|word| *word == it[index]).unwrap_or(0);
        let criterion_of_setting: Vec<usize> = settings.iter().map(criterion_of).collect();
        let rate = |(rival, task): &(&str, Task)| SetRate {
            name: format!("{task}, F-rate"),
            method: METHOD.to_owned(),
            of_method: (0..n).map(|it| methods.f_rate(it, OVERALL, METHOD, *task)).collect(),
            rival: (*rival).to_owned(),
            of_rival: criterion_of_setting
                .iter()
                .map(|&it| rivals.f_rate(it, OVERALL, rival, *task))
                .collect(),
        };
        let values = OPEN_VALUES.iter().map(|it| SetValue {
            parameter: it.parameter.to_owned(),
            said: it.said.to_owned(),
            range: it.range.to_string(),
            chosen: config.value_of(it.parameter).map_or_else(String::new, ToString::to_string),
        });
        let sensitivity = Sensitivity {
            values: values.collect(),
            settings,
            rates: RIVALS.iter().map(rate).collect(),
            seed: arguments.settings_seed,
            scans: format!("simulated streets for development (seeds from {DEVELOPMENT_SEED})"),
        };
        Ok(Some(Self { sensitivity, methods, rivals, criterion_of_setting }))
    }

    /// Under how many settings the method leads the rival of the task, and of how many: on each data set, or on all
    /// together.
    pub fn n_leading(&self, task: Task, on_each: bool) -> Option<[usize; 2]> {
        let (rival, _) = RIVALS.iter().find(|it| it.1 == task)?;
        let datasets = self.methods.tallies().first()?.datasets();
        let scenes = if on_each { datasets } else { &[OVERALL.to_owned()] };
        let leads = |setting_idx: usize| {
            scenes.iter().all(|scene| {
                let method = self.methods.f_rate(setting_idx, scene, METHOD, task);
                let rival = self.rivals.f_rate(self.criterion_of_setting[setting_idx], scene, rival, task);
                method.zip(rival).is_some_and(|(method, rival)| method > rival)
            })
        };
        let n = self.criterion_of_setting.len();
        Some([(0..n).filter(|&it| leads(it)).count(), n])
    }
}
