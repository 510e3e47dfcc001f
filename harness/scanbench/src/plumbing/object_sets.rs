//! Sets of objects that the command line names, and a check of the options about them.

use std::path::PathBuf;

use scans::dataset::class_table::ClassTable;
use scans::object_cloud::object_cloud_set::ObjectCloudSet;
use simulator::catalogue::Catalogue;
use simulator::object_clouds::open_objects::{ObjectOptions, ObjectSource, open_objects};
use simulator::open::OpenOptions;

use crate::cli::{ObjectArgs, SourceArgs};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::open_datasets::{open_catalogue, open_options};
use crate::plumbing::remote::local_name;

pub struct ObjectOpening {
    catalogue: Catalogue,
    options: OpenOptions,
    cache: Option<PathBuf>,
}

impl ObjectOpening {
    /// Opens objects as `source` says.
    pub fn of(source: &SourceArgs) -> Result<Self, Failure> {
        let catalogue = open_catalogue(source.catalogue.catalogue.as_deref())?;
        let options = open_options(source, &ClassTable::default())?;
        Ok(Self { catalogue, options, cache: source.cache.clone() })
    }

    pub fn open(&self, name: &str, objects: &ObjectOptions) -> Result<Box<dyn ObjectCloudSet>, Failure> {
        let name = local_name(name, self.cache.as_deref())?;
        Ok(open_objects(&name, objects, &self.options, &self.catalogue)?)
    }
}

/// Refuses options that say nothing about any of the objects: those of data sets where no data set is named, those of
/// simulated objects where none are. `--part` is about `judged` alone: `learned_from` are of the training part in any case.
pub fn refuse_idle_options(
    judged: &[String],
    learned_from: &[String],
    choice: &ObjectArgs,
    source: &SourceArgs,
) -> Result<(), Failure> {
    let all = || judged.iter().chain(learned_from).map(|it| ObjectSource::of(it));
    let has_dataset = all().any(|it| it == ObjectSource::Dataset);
    let has_simulated = all().any(|it| it == ObjectSource::Simulated);
    let has_files = all().any(|it| it != ObjectSource::Simulated);
    let judges_simulated = judged.iter().any(|it| ObjectSource::of(it) == ObjectSource::Simulated);
    let (of_datasets, of_simulated) =
        ("data sets, and none is given", "simulated objects, and none are given");
    let options = [
        ("--format", source.format.is_some(), has_dataset, of_datasets),
        ("--topic", source.topic.is_some(), has_dataset, of_datasets),
        ("--annotation-topic", source.annotation_topic.is_some(), has_dataset, of_datasets),
        ("--class", !source.classes.is_empty(), has_dataset, of_datasets),
        ("--seed", source.seed.is_some(), has_dataset, of_datasets),
        ("--simulated-scans", source.simulated_scans.is_some(), has_dataset, of_datasets),
        ("--sensor", source.sensor.is_some(), has_dataset, of_datasets),
        ("--sensor-height", source.sensor_height.is_some(), has_dataset, of_datasets),
        ("--labels-ahead", source.labels_ahead.is_some(), has_dataset, of_datasets),
        ("--columns", source.columns.is_some(), has_files, "files of scans, and none are given"),
        ("--transform", source.transform.is_some(), has_dataset, of_datasets),
        ("--registered", choice.registered, has_dataset, of_datasets),
        ("--part", choice.part.is_some(), judges_simulated, of_simulated),
        ("--per-class", choice.per_class.is_some(), has_simulated, of_simulated),
    ];
    match options.iter().find(|(_, is_given, is_of_use, _)| *is_given && !is_of_use) {
        Some((option, _, _, what)) => Err(Usage(format!("{option} is for {what}")).into()),
        None => Ok(()),
    }
}
