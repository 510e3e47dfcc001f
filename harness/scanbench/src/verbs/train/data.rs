//! Data that models are trained on, and judged by.

use detector::describe::trained_file::Provenance;
use evaluation::run::config::RunConfig;
use evaluation::run::config::override_option::OverrideOption;
use evaluation::training::HOLD_OUT_EVERY;
use evaluation::training::example_weights::{DatasetExamples, example_weights};
use evaluation::training::held_out::HeldOut;
use scans::dataset::Dataset;
use scans::dataset::class_table::ClassTable;
use simulator::simulated_street::StreetDrive;

use crate::cli::{DatasetArgs, HeldOutArgs, RecordedArgs, SourceArgs};
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::judged_streets::refuse_judged;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets};
use crate::plumbing::reproducible_command::reproducible_command;

/// Arguments for `datasets`, which have options of their own, if there are any. Options of the simulator are for the others.
fn beside(
    data: &DatasetArgs,
    datasets: &[String],
    scans: Option<&String>,
    format: Option<&String>,
) -> Option<DatasetArgs> {
    (!datasets.is_empty()).then(|| DatasetArgs {
        datasets: datasets.to_vec(),
        scans: scans.cloned(),
        source: SourceArgs {
            topic: None,
            annotation_topic: None,
            classes: data.source.classes.clone(),
            format: format.cloned(),
            seed: None,
            simulated_scans: None,
            sensor: None,
            sensor_height: None,
            labels_ahead: None,
            transform: None,
            columns: None,
            cache: data.source.cache.clone(),
            catalogue: data.source.catalogue.clone(),
        },
    })
}

/// Opened data sets that are trained on and judged by.
pub struct TrainingData<'a> {
    /// The parameters, with the density curves of sensors that have none of their own.
    pub config: RunConfig,
    /// How the data sets were opened.
    pub data: &'a DatasetArgs,
    /// How the data sets only to judge by were opened.
    pub held_out_data: Option<DatasetArgs>,
    /// How those of --recorded were opened.
    pub recorded_data: Option<DatasetArgs>,
    /// The data sets trained on, those of --recorded last.
    pub trained: Vec<OpenedDataset>,
    /// How many of them are of --recorded.
    pub n_recorded: usize,
    /// Data sets only to judge by; without any, drives of the others are held out.
    pub held_out: Vec<OpenedDataset>,
    /// Which drives are on which side.
    pub parted: HeldOut,
}

impl<'a> TrainingData<'a> {
    /// Opens the data sets, seen by each of `sensors` in turn if there are any. As in a run with `config`, sensor, height
    /// and density are those that the first scans show, unless they are stated.
    pub fn open(
        mut config: RunConfig,
        data: &'a DatasetArgs,
        sensors: &[String],
        recorded: Option<&RecordedArgs>,
        judging: &HeldOutArgs,
    ) -> Result<Self, Failure> {
        let mut trained = Vec::new();
        if sensors.is_empty() {
            trained = open_datasets(data, &ClassTable::default())?;
        }
        for sensor in sensors {
            let mut of_sensor = data.clone();
            of_sensor.source.sensor = Some(sensor.clone());
            trained.extend(open_datasets(&of_sensor, &ClassTable::default())?);
        }
        if let Some(it) = trained.iter().filter(|_| !sensors.is_empty()).find(|it| !it.is_simulated()) {
            let id = &it.dataset.description().id;
            return Err(Usage(format!(
                "{id} is recorded: --sensors simulates sensors; --recorded takes {id}"
            ))
            .into());
        }
        let recorded_data = recorded.and_then(|it| {
            beside(data, &it.recorded, it.recorded_scans.as_ref(), it.recorded_format.as_ref())
        });
        let n_others = trained.len();
        if let Some(arguments) = &recorded_data {
            let recorded = open_datasets(arguments, &ClassTable::default())?;
            if let Some(it) = recorded.iter().find(|it| it.is_simulated()) {
                let id = &it.dataset.description().id;
                return Err(Usage(format!("--recorded {id}: it is simulated")).into());
            }
            trained.extend(recorded);
        }
        refuse_judged(&trained)?;
        let held_out_data = beside(
            data,
            &judging.held_out,
            judging.held_out_scans.as_ref(),
            judging.held_out_format.as_ref(),
        );
        let held_out = match &held_out_data {
            Some(arguments) => open_datasets(arguments, &ClassTable::default())?,
            None => Vec::new(),
        };
        let parted = parted(judging, &trained, &held_out)?;
        let [trained, held_out] = [trained, held_out].map(|it| look_first_at_all(it, &mut config));
        let n_recorded = trained.len() - n_others;
        Ok(Self { config, data, held_out_data, recorded_data, trained, n_recorded, held_out, parted })
    }

    /// All data sets.
    pub fn opened(&self) -> impl Iterator<Item = &OpenedDataset> {
        self.trained.iter().chain(&self.held_out)
    }

    /// Provenance of a model that is made of them: `verb` and `options` are those of the command.
    pub fn provenance(
        &self,
        verb: &str,
        options: &[(&str, Option<String>)],
        judging: &HeldOutArgs,
        seed: u64,
    ) -> Provenance {
        let hold_out_every =
            (judging.hold_out_every != HOLD_OUT_EVERY).then(|| judging.hold_out_every.to_string());
        let mut all = options.to_vec();
        all.extend(judging.held_out.iter().map(|it| ("--held-out", Some(it.clone()))));
        all.extend([
            ("--held-out-format", judging.held_out_format.clone()),
            ("--held-out-scans", judging.held_out_scans.clone()),
            ("--hold-out-every", hold_out_every),
        ]);
        Provenance {
            command: reproducible_command(verb, self.data, &all),
            data: self.trained.iter().map(name_with_seed).collect(),
            seed,
            split: format!("held out: {}", HeldOut::names(&self.parted.held_out)),
        }
    }
}

/// Parameters by which the groups are found that are learned from.
pub struct TrainingParameters {
    /// All of them; vehicles are classified by their size.
    pub config: RunConfig,
    /// Those that are not the shipped ones, by their full names.
    pub parameters: toml::Table,
}

impl TrainingParameters {
    /// The shipped ones with those of `options`.
    pub fn of(options: &[OverrideOption]) -> Result<Self, Failure> {
        const TABLE: &str = "hierarchical";
        let shipped = RunConfig::without_vehicle_models()?;
        let config = shipped.overridden(options, &[TABLE])?;
        let mut parameters = toml::Table::new();
        for option in options {
            let name = shipped.full_name(option, &[TABLE])?;
            if name.split('.').next() != Some(TABLE) {
                let problem =
                    format!("-P {option}: {name} changes no groups that are trained on; those of {TABLE} do");
                return Err(Usage(problem).into());
            }
            if config.value_of(&name) != shipped.value_of(&name) {
                let value = config.value_of(&name).expect("it has a full name").clone();
                parameters.insert(name, value);
            }
        }
        Ok(Self { config, parameters })
    }
}

/// Which drives are trained on and which are judged by.
fn parted(
    judging: &HeldOutArgs,
    trained: &[OpenedDataset],
    held_out: &[OpenedDataset],
) -> Result<HeldOut, Failure> {
    fn drives(opened: &[OpenedDataset]) -> impl Iterator<Item = (&dyn Dataset, &[usize])> {
        opened.iter().map(|it| (&*it.dataset, it.scan_indices.as_slice()))
    }
    if held_out.is_empty() {
        let every = judging.hold_out_every as usize;
        return HeldOut::every(every, drives(trained)).ok_or_else(|| {
            let problem = "all scans are of one drive; training and testing need at least two";
            Usage(problem.to_owned()).into()
        });
    }
    HeldOut::apart(drives(trained), drives(held_out)).map_err(|(dataset, sequence)| {
        Usage(format!("the drive {sequence} of {dataset} is both in the training data and in --held-out"))
            .into()
    })
}

/// Name of a data set in files that were made of it.
fn name_with_seed(opened: &OpenedDataset) -> String {
    let description = opened.dataset.description();
    match StreetDrive::of(description) {
        Some(drive) => format!("{} (simulated, seeds from {})", description.id, drive.seed),
        None => description.id.clone(),
    }
}

/// Weight of an example by data set; each data set has its number of examples beside it.
pub fn weights_of(n_by_dataset: &[(&OpenedDataset, usize)]) -> Vec<f64> {
    let examples = n_by_dataset
        .iter()
        .map(|&(opened, n_examples)| DatasetExamples { is_recorded: !opened.is_simulated(), n_examples });
    example_weights(&examples.collect::<Vec<_>>())
}

/// There is nothing to train on, for this reason.
pub fn nothing(reason: &dyn std::fmt::Display) -> NothingEvaluated {
    NothingEvaluated { reason: reason.to_string() }
}
