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
use evaluation::run::config::{PAPER_FILE, PCA_FILE, RunConfig};
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
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::ids_of;
use crate::plumbing::provenance::compact_utc;
use crate::plumbing::run_directory::{claim_named, claim_unnamed};
use crate::plumbing::standard_streams::print_result_in;
use crate::verbs::train::clusters::{ClustersOf, prototypes_of};
use crate::verbs::train::cross_validation::FoldedCandidates;
use crate::verbs::train::data::{TrainingData, nothing};
use crate::verbs::train::files::{TrainedModel, print_run_command, write_files};
use crate::verbs::train::summary::summary;

/// Largest number of steps of training. A ν below the share of objects that look like the other class needs so many.
const MOST_STEPS: usize = 500_000;

/// Trains a support vector machine, judges it by drives it has not seen, and writes and prints the result.
pub fn train_svm(arguments: &SvmTrainingArgs, kind: ModelKind) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let named = claim_named(&arguments.output)?;
    let config = RunConfig::without_vehicle_models()?;
    let data = TrainingData::open(config, &arguments.data, &[], None, &arguments.judging)?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&data.trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let candidates = collect_all(&data, arguments.choice_seed, kind, interrupted)?;
    let (judged, taught): (Vec<_>, Vec<_>) =
        candidates.iter().partition(|(dataset, it)| data.parted.is_held_out(dataset, &it.sequence));
    let (datasets_of_taught, taught) = taught.into_iter().map(|(dataset, it)| (*dataset, it)).unzip();
    let made = provenance(arguments, kind, &data);
    let training =
        Training { arguments, kind, data: &data, made, started, taught, datasets_of_taught, judged };
    let (files, printed) = match kind {
        ModelKind::Paper => {
            let describer_of = |of: &[&Candidate]| Ok(PaperDescriber::new(training.prototypes(of)?));
            let (params, said) = training.params(describer_of)?;
            let library = training.prototypes(&training.taught)?;
            let mut describer = PaperDescriber::new(library.clone());
            let file = |svm: &SvmModel<_>, made| (PAPER_FILE, PaperModel::file(&library, svm, made));
            training.fit_and_judge(&params, said, &mut describer, file, Some(&library))?
        }
        ModelKind::Pca => {
            let file = |svm: &SvmModel<_>, made| (PCA_FILE, PcaVehicleModel::file(svm, made));
            let (params, said) = training.params(|_| Ok(PcaDescriber::default()))?;
            training.fit_and_judge(&params, said, &mut PcaDescriber::default(), file, None)?
        }
    };
    for (name, content) in files {
        directory.write_file(name, &content)?;
    }
    let finished = directory.finish()?;
    let printed = print_result_in("Model", &finished, printed);
    let detector = kind.detector();
    print_run_command(&format!("-d {detector}"), detector, &finished, &[]);
    printed
}

fn collect_all<'a>(
    data: &'a TrainingData<'_>,
    seed: u64,
    kind: ModelKind,
    interrupted: &AtomicBool,
) -> Result<Vec<(&'a str, Candidate)>, Failure> {
    let config = &data.config;
    let min_points = match kind {
        ModelKind::Paper => config.paper.cluster.min_points,
        ModelKind::Pca => config.baselines.pca.cluster.min_points,
    };
    let mut candidates = Vec::new();
    for it in data.opened() {
        let source = ClustersOf { config, detector: kind.detector(), min_points, seed };
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
        ("--gamma", Some(comma_separated(&gammas(arguments, kind)))),
        ("--nu", Some(comma_separated(&nus(arguments, kind)))),
        ("--choice-seed", unless(arguments.choice_seed, CHOICE_SEED)),
    ];
    let verb = format!("train {}", kind.detector());
    data.provenance(&verb, &options, &arguments.judging, arguments.choice_seed)
}

fn gammas(arguments: &SvmTrainingArgs, kind: ModelKind) -> Vec<f32> {
    if arguments.gamma.is_empty() { vec![kind.gamma()] } else { arguments.gamma.clone() }
}

fn nus(arguments: &SvmTrainingArgs, kind: ModelKind) -> Vec<f64> {
    if arguments.nu.is_empty() { vec![kind.nu()] } else { arguments.nu.clone() }
}

fn comma_separated(numbers: &[impl ToString]) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

/// Everything that a model is made of and judged by.
struct Training<'a> {
    arguments: &'a SvmTrainingArgs,
    kind: ModelKind,
    data: &'a TrainingData<'a>,
    made: Provenance,
    started: Timestamp,
    taught: Vec<&'a Candidate>,
    // By candidate in `taught`.
    datasets_of_taught: Vec<&'a str>,
    judged: Vec<&'a (&'a str, Candidate)>,
}

/// Files by their names, and what is printed.
type FilesAndText = (Vec<(&'static str, Vec<u8>)>, String);

impl Training<'_> {
    fn prototypes(&self, candidates: &[&Candidate]) -> Result<PrototypeLibrary, Failure> {
        prototypes_of(candidates, self.arguments.prototypes as usize, self.made.clone())
    }

    /// The parameters that were asked for, or of several the best on drives that are held out, with a text about the choice.
    fn params<const D: usize, S: ObjectDescriber<D>>(
        &self,
        describer_of: impl Fn(&[&Candidate]) -> Result<S, Failure>,
    ) -> Result<(NuSvcParams, String), Failure> {
        let params =
            |gamma, nu| NuSvcParams { gamma, nu, tolerance: self.kind.tolerance(), max_steps: MOST_STEPS };
        let (gammas, nus) = (gammas(self.arguments, self.kind), nus(self.arguments, self.kind));
        let pairs: Vec<NuSvcParams> =
            nus.iter().flat_map(|&nu| gammas.iter().map(move |&gamma| params(gamma, nu))).collect();
        if let [only] = &pairs[..] {
            return Ok((*only, String::new()));
        }
        let folded = FoldedCandidates {
            taught: &self.taught,
            datasets: &self.datasets_of_taught,
            most_vehicles: self.arguments.vehicles as usize,
            others_per_vehicle: self.arguments.others,
            seed: self.arguments.choice_seed,
        };
        folded.best(&pairs, describer_of, interruption_flag())
    }

    fn fit_and_judge<const D: usize, S: ObjectDescriber<D>>(
        &self,
        params: &NuSvcParams,
        said: String,
        describer: &mut S,
        file: impl FnOnce(&SvmModel<D>, Provenance) -> (&'static str, ModelFile),
        library: Option<&PrototypeLibrary>,
    ) -> Result<FilesAndText, Failure> {
        let of = self.arguments;
        let selected = select(&self.taught, of.vehicles as usize, of.others, of.choice_seed);
        let model = fit_model(&selected, describer, params).map_err(|error| nothing(&error))?;
        let judged: Vec<(&str, &Candidate, DescribedObject<D>)> = self
            .judged
            .iter()
            .filter_map(|(dataset, it)| Some((*dataset, it, DescribedObject::of(it, describer)?)))
            .collect();
        let objects: Vec<DescribedObject<D>> = judged.iter().map(|&(_, _, object)| object).collect();
        let evaluation = evaluate(&model, &objects, self.arguments.choice_seed);
        let printed = said + &summary(&self.data.parted, &selected, library, &model, &evaluation);
        let (file_name, file) = file(&model, self.made.clone());
        let trained = TrainedModel { model, file_name, file, judged, evaluation };
        Ok((write_files(self.data, self.started, &trained)?, printed))
    }
}
