//! `scanbench train`.

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use baselines::pca_features::{PcaDescriber, PcaFeatures};
use detector::Detector;
use detector::classify::nu_svc_solver::NuSvcParams;
use detector::describe::paper_features::{PaperDescriber, PaperFeatures};
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use detector::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::built_in_named;
use evaluation::training::candidates::{Candidate, CandidateBoxes, CandidateSource, collect_candidates};
use evaluation::training::described_object::{CandidateDescriber, DescribedObject, fit_model};
use evaluation::training::evaluation::evaluate;
use evaluation::training::held_out::HeldOut;
use evaluation::training::model_kind::ModelKind;
use evaluation::training::prototypes::{COLUMN_M, find_prototypes};
use evaluation::training::selection::select;
use evaluation::training::{CHOICE_SEED, HOLD_OUT_EVERY, PROTOTYPES};
use jiff::Timestamp;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::LatestPointer;
use scans::dataset::class_table::ClassTable;

use crate::cli::{ModelName, TrainArgs, TrainedTask};
use crate::commands::config::warn_of_unknown_sensor;
use crate::commands::failure::{Failure, Usage};
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, ids_of, open_datasets};
use crate::commands::progress::progress_over_scans;
use crate::commands::provenance::compact_utc;
use crate::commands::reproducible_command::reproducible_command;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::train_files::{TrainedModel, TrainingSettings, write_files};
use crate::commands::train_groupings::train_groupings;
use crate::commands::train_partial::train_partial;
use crate::commands::train_summary::summary;
use crate::commands::training_data::{held_out_arguments, name_with_seed, nothing, parted};

/// Training gives up after so many steps, which a ν below the share of objects that look like the other class needs.
const MOST_STEPS: usize = 500_000;

/// Trains a vehicle model, judges it by drives it has not seen, and writes and prints the result.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged or too few, or the output cannot be written; nothing is left
/// behind then.
pub fn train(arguments: &TrainArgs) -> Result<(), Failure> {
    if arguments.partial.task == Some(TrainedTask::Partial) {
        return train_partial(arguments);
    }
    match arguments.detector {
        ModelName::Hierarchical => train_groupings(arguments),
        ModelName::KdTree => train_svm(arguments, ModelKind::Clusters),
        ModelName::Paper => train_svm(arguments, ModelKind::Paper),
        ModelName::Pca => train_svm(arguments, ModelKind::Pca),
    }
}

fn train_svm(arguments: &TrainArgs, kind: ModelKind) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    if !arguments.sensors.is_empty() {
        let problem = "--sensors is for --detector hierarchical; --sensor names one for the others";
        return Err(Usage(problem.to_owned()).into());
    }
    let named = claim_named(&arguments.output)?;
    let trained = open_datasets(&arguments.data, &ClassTable::default())?;
    let held_out_arguments = held_out_arguments(arguments);
    let held_out = match &held_out_arguments {
        Some(arguments) => open_datasets(arguments, &ClassTable::default())?,
        None => Vec::new(),
    };
    let parted = parted(arguments, &trained, &held_out)?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let mut candidates = Vec::new();
    for opened in [&trained, &held_out] {
        candidates.extend(collect_all(opened, arguments, kind, interrupted)?);
    }
    let settings = TrainingSettings {
        made: provenance(arguments, kind, &trained, &parted),
        data: &arguments.data,
        held_out_data: held_out_arguments.as_ref(),
        trained: &trained,
        held_out: &held_out,
        parted: &parted,
        started,
    };
    let (judged, taught): (Vec<_>, Vec<_>) =
        candidates.iter().partition(|(dataset, it)| parted.is_held_out(dataset, &it.sequence));
    let taught: Vec<&Candidate> = taught.into_iter().map(|(_, it)| it).collect();
    let training = Training { arguments, kind, settings, taught, judged };
    let (files, printed) = match kind {
        ModelKind::Clusters => {
            let library = training.prototypes()?;
            let named = (VehicleFeatures::NAMES, VehicleDescriber::name(&library));
            training.fit_and_judge(&mut VehicleDescriber::new(library.clone()), named, Some(&library))?
        }
        ModelKind::Paper => {
            let library = training.prototypes()?;
            let named = (PaperFeatures::NAMES, VehicleDescriber::name(&library));
            training.fit_and_judge(&mut PaperDescriber::new(library.clone()), named, Some(&library))?
        }
        ModelKind::Pca => {
            let named = (PcaFeatures::NAMES, PcaDescriber::name());
            training.fit_and_judge(&mut PcaDescriber::default(), named, None)?
        }
    };
    for (name, content) in files {
        directory.write_file(name, &content)?;
    }
    let finished = directory.finish()?;
    let printed = print_result(printed);
    print_diagnostic(format_args!("Model: {}", finished.display()));
    printed
}

fn collect_all<'a>(
    opened: &'a [OpenedDataset],
    arguments: &TrainArgs,
    kind: ModelKind,
    interrupted: &AtomicBool,
) -> Result<Vec<(&'a str, Candidate)>, Failure> {
    let mut config = RunConfig::without_vehicle_models()?;
    // Models are asked about objects before these are completed.
    config.hierarchical.completion.enabled = false;
    // The tree of groupings has models of its own.
    config.hierarchical.grouping.enabled = false;
    let min_points = match kind {
        ModelKind::Clusters => config.hierarchical.cluster.min_points,
        ModelKind::Paper => config.paper.cluster.min_points,
        ModelKind::Pca => config.baselines.pca.cluster.min_points,
    };
    let clusters = arguments.clusters.as_deref().unwrap_or(kind.clusters());
    let listed = built_in_named(&[clusters.to_owned()], &config)?[0];
    let boxes = if clusters == kind.clusters() {
        CandidateBoxes::OfDetector(kind.object_box())
    } else {
        CandidateBoxes::Fitted(kind.object_box())
    };
    // Only this model is asked about what regrouping might make of its own clusters; another may learn from it.
    let is_asked = kind == ModelKind::Clusters && clusters == kind.clusters();
    let is_regrouped = is_asked || arguments.parts_and_pairs;
    let regrouping = is_regrouped.then(|| config.hierarchical.regrouping.clone());
    let mut candidates = Vec::new();
    for it in opened {
        let OpenedDataset { dataset, scan_indices, .. } = it;
        let description = dataset.description();
        warn_of_unknown_sensor(&config, description);
        let of_sensor = config.for_scans_of(description);
        let new_detector = || -> Box<dyn Detector> { listed.build(&of_sensor, description.sensor_height_m) };
        let source = CandidateSource {
            new_detector: &new_detector,
            boxes,
            ground: &of_sensor.hierarchical,
            min_points,
            regrouping: regrouping.as_ref(),
            seed: arguments.choice_seed,
        };
        let progress = progress_over_scans(scan_indices.len(), &description.id);
        let found = collect_candidates(&**dataset, scan_indices, &source, interrupted, || progress.inc(1))?;
        candidates.extend(found.into_iter().map(|it| (description.id.as_str(), it)));
        progress.finish_and_clear();
        it.warn_of_points_left_out();
    }
    Ok(candidates)
}

fn provenance(
    arguments: &TrainArgs,
    kind: ModelKind,
    opened: &[OpenedDataset],
    parted: &HeldOut,
) -> Provenance {
    let unless = |value: u64, standard: u64| (value != standard).then(|| value.to_string());
    let mut options =
        vec![("--detector", Some(kind.detector().to_owned())), ("--clusters", arguments.clusters.clone())];
    options.extend(arguments.held_out.iter().map(|it| ("--held-out", Some(it.clone()))));
    options.extend([
        ("--held-out-format", arguments.held_out_format.clone()),
        ("--held-out-scans", arguments.held_out_scans.clone()),
        ("--hold-out-every", unless(arguments.hold_out_every.into(), HOLD_OUT_EVERY.into())),
        ("--vehicles", Some(arguments.vehicles.to_string())),
        ("--others", Some(arguments.others.to_string())),
        ("--parts-and-pairs", arguments.parts_and_pairs.then(String::new)),
        ("--any-size", arguments.any_size.then(String::new)),
        ("--prototypes", unless(arguments.prototypes.into(), PROTOTYPES.into())),
        ("--gamma", Some(arguments.gamma.unwrap_or(kind.gamma()).to_string())),
        ("--nu", Some(arguments.nu.unwrap_or(kind.nu()).to_string())),
        ("--choice-seed", unless(arguments.choice_seed, CHOICE_SEED)),
    ]);
    Provenance {
        command: reproducible_command("train", &arguments.data, &options),
        data: opened.iter().map(name_with_seed).collect(),
        seed: arguments.choice_seed,
        split: format!("held out: {}", HeldOut::names(&parted.held_out)),
    }
}

/// Everything that a model is made of and judged by.
struct Training<'a> {
    arguments: &'a TrainArgs,
    kind: ModelKind,
    settings: TrainingSettings<'a>,
    taught: Vec<&'a Candidate>,
    judged: Vec<&'a (&'a str, Candidate)>,
}

/// Files by their names, and what is printed.
type FilesAndText = (Vec<(&'static str, Vec<u8>)>, String);

impl Training<'_> {
    fn prototypes(&self) -> Result<PrototypeLibrary, Failure> {
        let prototypes = find_prototypes(&self.taught, self.arguments.prototypes as usize);
        if prototypes.is_empty() {
            return Err(nothing(&"no vehicle has enough points for a side profile").into());
        }
        let made = self.settings.made.clone();
        Ok(PrototypeLibrary::new(made, COLUMN_M, prototypes).map_err(|error| nothing(&error))?)
    }

    fn fit_and_judge<const D: usize, S: CandidateDescriber<D>>(
        &self,
        describer: &mut S,
        named: ([&'static str; D], String),
        library: Option<&PrototypeLibrary>,
    ) -> Result<FilesAndText, Failure> {
        let numbers = (self.arguments.vehicles as usize, self.arguments.others);
        let is_looked_at = |it: &Candidate| self.arguments.any_size || S::is_looked_at(it);
        let taught: Vec<&Candidate> = self.taught.iter().copied().filter(|it| is_looked_at(it)).collect();
        let selected = select(&taught, numbers, self.arguments.choice_seed);
        let params = NuSvcParams {
            gamma: self.arguments.gamma.unwrap_or(self.kind.gamma()),
            nu: self.arguments.nu.unwrap_or(self.kind.nu()),
            tolerance: self.kind.tolerance(),
            max_steps: MOST_STEPS,
        };
        let model = fit_model(&selected, describer, named, &params, self.settings.made.clone())
            .map_err(|error| nothing(&error))?;
        // Judged by what the detector finds.
        let found = self.judged.iter().copied().filter(|(_, it)| !it.is_regrouped);
        let (looked_at, refused): (Vec<_>, Vec<_>) = found.partition(|(_, it)| is_looked_at(it));
        let judged: Vec<(&str, &Candidate, DescribedObject<D>)> = looked_at
            .into_iter()
            .filter_map(|(dataset, it)| Some((*dataset, it, DescribedObject::of(it, describer)?)))
            .collect();
        let objects: Vec<DescribedObject<D>> = judged.iter().map(|&(_, _, object)| object).collect();
        let evaluation = evaluate(&model, &objects, self.arguments.choice_seed);
        let mut printed = summary(self.settings.parted, &selected, library, &model, &evaluation);
        if !refused.is_empty() {
            let n_vehicles = refused.iter().filter(|(_, it)| it.kind.is_vehicle()).count();
            let n_others = refused.len() - n_vehicles;
            // Writing to a string cannot fail.
            let _ = write!(
                printed,
                "\nNot tested, because no vehicle has their size: {n_vehicles} vehicles and {n_others} others"
            );
        }
        let trained = TrainedModel { model, library, judged, evaluation };
        Ok((write_files(&self.settings, &trained)?, printed))
    }
}
