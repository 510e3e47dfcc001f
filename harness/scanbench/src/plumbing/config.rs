//! Detectors and parameters that the command line names.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use detector::params::PAPER_SENSOR;
use evaluation::matching::criterion::Criterion;
use evaluation::run::config::{RunConfig, TrainedModel};
use evaluation::run::detector_list::{ChosenDetector, ListedDetector, built_in_named, detectors_named};
use evaluation::run::foreign_detector::{ForeignDetector, ForeignWork, VehicleRule};
use evaluation::run::kept_names::kept;
use reports::run_folder::run_target::RUNS;
use scans::dataset::DatasetDescription;
use scans::dataset::class_table::ClassTable;

use crate::cli::{ConfigArgs, CriterionName, MatchingArgs, NamedResults};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::standard_streams::{print_detail, print_diagnostic};

/// The file that defines detectors and parameters, in the working directory or one above it.
pub const CONFIGURATION_FILE: &str = "scanbench.toml";

/// Variable of the environment with the file that stands for the nearest [`CONFIGURATION_FILE`]: a copy of it that Python has
/// added detectors to.
const PROJECT: &str = "SCANBENCH_PROJECT";

/// The detectors with these names, and the shipped parameters, overridden by the file and then by the options of
/// `arguments`. Short names of options are those of parameters of these detectors.
pub fn chosen_detectors(
    arguments: &ConfigArgs,
    names: &[String],
) -> Result<(Vec<ChosenDetector>, RunConfig), Failure> {
    let (chosen, config) = runnable_detectors(arguments, names)?;
    refuse_unread_models(chosen.iter().map(|it| (it, &config)))?;
    Ok((chosen, config))
}

/// As [`chosen_detectors`], but models that no detector reads are not refused yet: detectors may get more parameters.
pub fn runnable_detectors(
    arguments: &ConfigArgs,
    names: &[String],
) -> Result<(Vec<ChosenDetector>, RunConfig), Failure> {
    let (chosen, config) = choose(&load(arguments)?, arguments, names)?;
    let is_read = |it: &&ChosenDetector| {
        matches!(it, ChosenDetector::Foreign(ForeignDetector { work: ForeignWork::Results(_), .. }))
    };
    match chosen.iter().find(is_read) {
        Some(it) => {
            let problem =
                format!("{:?} is results of another program, which only `scanbench run` judges", it.name());
            Err(Usage(problem).into())
        }
        None => Ok((chosen, config)),
    }
}

/// As [`chosen_detectors`], and with detectors that left results: those that `left` names, and those of the file. Detectors
/// of `left` that are not among `names` come last.
pub fn chosen_with_results(
    arguments: &ConfigArgs,
    names: &[String],
    left: &[NamedResults],
) -> Result<(Vec<ChosenDetector>, RunConfig), Failure> {
    let mut config = load(arguments)?;
    let mut names = names.to_vec();
    for NamedResults { name, path } in left {
        if config.foreign.iter().any(|it| it.name == name) {
            return Err(Usage(format!("--detections: there is a detector {name:?} already")).into());
        }
        let folder = PathBuf::from(".");
        let (work, vehicles) = (ForeignWork::Results(path.clone()), VehicleRule::default());
        config.foreign.push(ForeignDetector { name: kept(name), folder, work, vehicles });
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    let (chosen, config) = choose(&config, arguments, &names)?;
    refuse_unread_models(chosen.iter().map(|it| (it, &config)))?;
    Ok((chosen, config))
}

/// Refuses directories of models that the command line or its file names, and that none of `compared_detectors` reads with its
/// parameters: they would have no effect. The file of a project is for many commands.
pub fn refuse_unread_models<'a>(
    compared_detectors: impl Iterator<Item = (&'a ChosenDetector, &'a RunConfig)>,
) -> Result<(), Failure> {
    let compared_detectors: Vec<(&ChosenDetector, &RunConfig)> = compared_detectors.collect();
    for model in TrainedModel::ALL {
        let directory = compared_detectors.iter().find_map(|(_, config)| config.directory_asked_for(model));
        let is_read = compared_detectors.iter().any(|(chosen, config)| {
            chosen.vehicle_model(config).is_some_and(|it| it.parameter() == model.parameter())
                // Without the models of vehicles, the one that comes with the program makes the boxes.
                || model == TrainedModel::Boxes
                    && config.vehicle_models.is_some()
                    && chosen.has_whole_boxes(config)
        });
        let Some(directory) = directory.filter(|_| !is_read) else { continue };
        let reads: BTreeSet<String> = compared_detectors
            .iter()
            .map(|(chosen, config)| {
                let read = chosen.vehicle_model(config).map_or("no model", TrainedModel::parameter);
                format!("{} reads {read}", chosen.name())
            })
            .collect();
        let reads: Vec<String> = reads.into_iter().collect();
        let parameter = model.parameter();
        let problem =
            format!("{parameter} = {directory:?}: no chosen detector reads it; {}", reads.join(", "));
        return Err(Usage(problem).into());
    }
    Ok(())
}

fn choose(
    config: &RunConfig,
    arguments: &ConfigArgs,
    names: &[String],
) -> Result<(Vec<ChosenDetector>, RunConfig), Failure> {
    let mut chosen = detectors_named(names, config)?;
    let tables: Vec<String> = chosen.iter().map(ChosenDetector::table).collect();
    let tables: Vec<&str> = tables.iter().map(String::as_str).collect();
    let mut config = config.overridden(&arguments.parameters, &tables)?;
    config.places_of_labels.push(RUNS.into());
    for it in &mut chosen {
        if let ChosenDetector::Foreign(foreign) = it {
            *foreign = foreign.clone().identified(&config)?;
        }
    }
    Ok((chosen, config))
}

/// Keeps network and labels from `detector`, whatever its configuration says; returns whether it is a program.
pub fn wall_in(detector: &mut ChosenDetector) -> bool {
    let ChosenDetector::Foreign(ForeignDetector { work: ForeignWork::Process(process), .. }) = detector
    else {
        return false;
    };
    process.sandbox = true;
    true
}

/// Hides the run at `directory`, and what is finished of one, from detectors that must not see labels.
pub fn hide_run(directory: &Path, config: &mut RunConfig) {
    config.places_of_labels.extend([directory.to_owned(), directory.with_added_extension("unfinished")]);
}

/// As [`chosen_detectors`], for built-in detectors alone.
pub fn built_in_detectors(
    arguments: &ConfigArgs,
    names: &[String],
) -> Result<(Vec<ListedDetector>, RunConfig), Failure> {
    let (listed, config) = built_in_methods(arguments, names)?;
    let chosen: Vec<ChosenDetector> = listed.iter().map(|it| ChosenDetector::BuiltIn(*it)).collect();
    refuse_unread_models(chosen.iter().map(|it| (it, &config)))?;
    Ok((listed, config))
}

/// As [`built_in_detectors`], but models that no detector reads are not refused yet: variants may read others.
pub fn built_in_methods(
    arguments: &ConfigArgs,
    names: &[String],
) -> Result<(Vec<ListedDetector>, RunConfig), Failure> {
    let config = load(arguments)?;
    let listed = built_in_named(names, &config)?;
    Ok((listed, choose(&config, arguments, names)?.1))
}

/// Overrides the criterion of the configuration, and the slice that is judged, with those of `matching`, if it names them.
pub fn choose_matching(config: &mut RunConfig, matching: &MatchingArgs) -> Result<(), Usage> {
    match matching.criterion {
        Some(CriterionName::Points) => config.choose_criterion(Criterion::POINTS),
        Some(CriterionName::BevIou) => config.choose_criterion(Criterion::BEV_IOU),
        Some(CriterionName::Iou3d) => config.choose_criterion(Criterion::IOU_3D),
        Some(CriterionName::Centre) => config.choose_criterion(Criterion::CENTRE),
        None => {}
    }
    let Some(only) = &matching.only else { return Ok(()) };
    config.judge_only(only).map_err(|problem| Usage(format!("--only: {problem}")))
}

pub fn load(arguments: &ConfigArgs) -> Result<RunConfig, Failure> {
    let found = if arguments.config.is_some() { None } else { configuration_file() };
    if let Some(found) = &found {
        let said = format!("Configuration: {}", found.display());
        // What lies in the folder itself is seen there.
        let is_here = std::env::current_dir().is_ok_and(|it| found.parent() == Some(&it));
        if is_here { print_detail(said) } else { print_diagnostic(said) }
    }
    Ok(match &found {
        Some(found) => RunConfig::of_project(found)?,
        None => RunConfig::load(arguments.config.as_deref())?,
    })
}

/// Meanings of class names in the nearest [`CONFIGURATION_FILE`], for verbs that take nothing else from it. Its own classes are
/// known from then on.
pub fn classes_of_project() -> Result<ClassTable, Failure> {
    let found = configuration_file();
    Ok(found.map(|it| RunConfig::classes_in(&it)).transpose()?.unwrap_or_default())
}

/// The nearest [`CONFIGURATION_FILE`] in the working directory or above it, or what stands for it.
fn configuration_file() -> Option<PathBuf> {
    if let Some(copy) = std::env::var_os(PROJECT).filter(|it| !it.is_empty()) {
        return Some(copy.into());
    }
    let folder = std::env::current_dir().ok()?;
    folder.ancestors().map(|it| it.join(CONFIGURATION_FILE)).find(|it| it.is_file())
}

/// Warns if there is no density curve for the sensor of `dataset`.
pub fn warn_of_unknown_sensor(config: &RunConfig, dataset: &DatasetDescription) {
    if config.for_dataset(&dataset.id, &dataset.sensor).is_none() {
        warn_of_missing_curve(&dataset.sensor);
    }
}

/// Warns that there is no density curve for `sensor`, and that that of another sensor stands in.
pub fn warn_of_missing_curve(sensor: &str) {
    print_diagnostic(format_args!(
        "warning: there is no density curve for the sensor {sensor:?}; the detector uses that of {PAPER_SENSOR}; \
         fit one with scanbench fit-density, and give the file to --config"
    ));
}
