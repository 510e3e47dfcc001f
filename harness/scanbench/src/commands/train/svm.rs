//! `scanbench train paper` and `train pca`.

use std::sync::atomic::AtomicBool;

use baselines::pca_features::PcaDescriber;
use baselines::pca_vehicle_model::PcaVehicleModel;
use detector::classify::model_file::ModelFile;
use detector::classify::nu_svc_solver::NuSvcParams;
use detector::classify::paper_model::PaperModel;
use detector::classify::svm_model::SvmModel;
use detector::describe::object_describer::ObjectDescriber;
use detector::describe::paper_features::PaperDescriber;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use evaluation::run::config::RunConfig;
use evaluation::run::config::{PAPER_FILE, PCA_FILE};
use evaluation::training::candidates::Candidate;
use evaluation::training::described_object::{DescribedObject, fit_model};
use evaluation::training::evaluation::evaluate;
use evaluation::training::model_kind::ModelKind;
use evaluation::training::selection::select;
use evaluation::training::{CHOICE_SEED, PROTOTYPES};
use jiff::Timestamp;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::LatestPointer;

use crate::cli::SvmTrainingArgs;
use crate::commands::failure::Failure;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::ids_of;
use crate::commands::provenance::compact_utc;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::standard_streams::{print_diagnostic, print_result_in};
use crate::commands::train::clusters::{ClustersOf, prototypes_of};
use crate::commands::train::data::{TrainingData, nothing};
use crate::commands::train::files::{TrainedModel, write_files};
use crate::commands::train::summary::summary;

/// Training gives up after so many steps, which a ν below the share of objects that look like the other class needs.
const MOST_STEPS: usize = 500_000;

/// Trains a support vector machine, judges it by drives it has not seen, and writes and prints the result.
pub fn train_svm(arguments: &SvmTrainingArgs, kind: ModelKind) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let named = claim_named(&arguments.output)?;
    let data = TrainingData::open(&arguments.data, &[], &arguments.judging)?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&data.trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let candidates = collect_all(&data, arguments.choice_seed, kind, interrupted)?;
    let (judged, taught): (Vec<_>, Vec<_>) =
        candidates.iter().partition(|(dataset, it)| data.parted.is_held_out(dataset, &it.sequence));
    let taught: Vec<&Candidate> = taught.into_iter().map(|(_, it)| it).collect();
    let made = provenance(arguments, kind, &data);
    let training = Training { arguments, kind, data: &data, made, started, taught, judged };
    let (files, printed) = match kind {
        ModelKind::Paper => {
            let library = training.prototypes()?;
            let mut describer = PaperDescriber::new(library.clone());
            let file = |svm: &SvmModel<_>, made| (PAPER_FILE, PaperModel::file(&library, svm, made));
            training.fit_and_judge(&mut describer, file, Some(&library))?
        }
        ModelKind::Pca => {
            let file = |svm: &SvmModel<_>, made| (PCA_FILE, PcaVehicleModel::file(svm, made));
            training.fit_and_judge(&mut PcaDescriber::default(), file, None)?
        }
    };
    for (name, content) in files {
        directory.write_file(name, &content)?;
    }
    let finished = directory.finish()?;
    let printed = print_result_in("Model", &finished, printed);
    let (detector, path) = (kind.detector(), finished.display());
    print_diagnostic(format_args!(
        "Run it: scanbench run -d {detector} -P vehicle_model.{detector}_directory={path}"
    ));
    printed
}

fn collect_all<'a>(
    data: &'a TrainingData<'_>,
    seed: u64,
    kind: ModelKind,
    interrupted: &AtomicBool,
) -> Result<Vec<(&'a str, Candidate)>, Failure> {
    let config = RunConfig::without_vehicle_models()?;
    let min_points = match kind {
        ModelKind::Paper => config.paper.cluster.min_points,
        ModelKind::Pca => config.baselines.pca.cluster.min_points,
    };
    let mut candidates = Vec::new();
    for it in data.opened() {
        let source = ClustersOf { config: &config, detector: kind.detector(), min_points, seed };
        let found = source.candidates(it, kind, interrupted, |candidates| candidates)?;
        candidates.extend(found.into_iter().map(|found| (it.dataset.description().id.as_str(), found)));
    }
    Ok(candidates)
}

fn provenance(arguments: &SvmTrainingArgs, kind: ModelKind, data: &TrainingData<'_>) -> Provenance {
    let unless = |value: u64, standard: u64| (value != standard).then(|| value.to_string());
    let options = [
        ("--vehicles", Some(arguments.vehicles.to_string())),
        ("--others", Some(arguments.others.to_string())),
        ("--prototypes", unless(arguments.prototypes.into(), PROTOTYPES.into())),
        ("--gamma", Some(arguments.gamma.unwrap_or(kind.gamma()).to_string())),
        ("--nu", Some(arguments.nu.unwrap_or(kind.nu()).to_string())),
        ("--choice-seed", unless(arguments.choice_seed, CHOICE_SEED)),
    ];
    let verb = format!("train {}", kind.detector());
    data.provenance(&verb, &options, &arguments.judging, arguments.choice_seed)
}

/// Everything that a model is made of and judged by.
struct Training<'a> {
    arguments: &'a SvmTrainingArgs,
    kind: ModelKind,
    data: &'a TrainingData<'a>,
    made: Provenance,
    started: Timestamp,
    taught: Vec<&'a Candidate>,
    judged: Vec<&'a (&'a str, Candidate)>,
}

/// Files by their names, and what is printed.
type FilesAndText = (Vec<(&'static str, Vec<u8>)>, String);

impl Training<'_> {
    fn prototypes(&self) -> Result<PrototypeLibrary, Failure> {
        prototypes_of(&self.taught, self.arguments.prototypes as usize, self.made.clone())
    }

    fn fit_and_judge<const D: usize, S: ObjectDescriber<D>>(
        &self,
        describer: &mut S,
        file: impl FnOnce(&SvmModel<D>, Provenance) -> (&'static str, ModelFile),
        library: Option<&PrototypeLibrary>,
    ) -> Result<FilesAndText, Failure> {
        let numbers = (self.arguments.vehicles as usize, self.arguments.others);
        let selected = select(&self.taught, numbers, self.arguments.choice_seed);
        let params = NuSvcParams {
            gamma: self.arguments.gamma.unwrap_or(self.kind.gamma()),
            nu: self.arguments.nu.unwrap_or(self.kind.nu()),
            tolerance: self.kind.tolerance(),
            max_steps: MOST_STEPS,
        };
        let model = fit_model(&selected, describer, &params).map_err(|error| nothing(&error))?;
        let judged: Vec<(&str, &Candidate, DescribedObject<D>)> = self
            .judged
            .iter()
            .filter_map(|(dataset, it)| Some((*dataset, it, DescribedObject::of(it, describer)?)))
            .collect();
        let objects: Vec<DescribedObject<D>> = judged.iter().map(|&(_, _, object)| object).collect();
        let evaluation = evaluate(&model, &objects, self.arguments.choice_seed);
        let printed = summary(&self.data.parted, &selected, library, &model, &evaluation);
        let (file_name, file) = file(&model, self.made.clone());
        let trained = TrainedModel { model, file_name, file, judged, evaluation };
        Ok((write_files((self.data, self.started), &trained)?, printed))
    }
}
