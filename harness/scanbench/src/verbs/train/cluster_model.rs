//! `scanbench train clusters`.

use std::iter::repeat_n;
use std::sync::atomic::AtomicBool;

use detector::classify::vehicle_model::{CLUSTER_MODEL, VehicleModel};
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use detector::road_user::RoadUser;
use evaluation::run::config::{CLUSTERS_FILE, RunConfig};
use evaluation::training::cluster_training::{ClusterExample, described_clusters};
use evaluation::training::grouping_training::{ClassExample, train_road_users};
use evaluation::training::model_kind::ModelKind;
use evaluation::training::model_odds::ModelOdds;
use evaluation::training::operating_curves::OperatingCurves;
use evaluation::training::prototypes::is_seen_well;
use evaluation::training::{CHOICE_SEED, PROTOTYPES};
use jiff::Timestamp;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};

use crate::cli::TreeTrainingArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::ids_of;
use crate::plumbing::provenance::compact_utc;
use crate::plumbing::run_directory::{claim_named, claim_unnamed};
use crate::plumbing::standard_streams::print_result_in;
use crate::verbs::train::clusters::{ClustersOf, prototypes_of};
use crate::verbs::train::data::{TrainingData, TrainingParameters, nothing, weights_of};
use crate::verbs::train::files::{manifest, print_run_command};
use crate::verbs::train::groupings::{check_odds, drives, options, prototypes_from};

/// Trains the model that classifies clusters, evaluates it on held-out drives, and writes and prints the result.
pub fn train_clusters(arguments: &TreeTrainingArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    check_odds(&arguments.odds, &[CLUSTER_MODEL])?;
    let named = claim_named(&arguments.output)?;
    let TrainingParameters { config, parameters } = TrainingParameters::of(&arguments.parameters)?;
    let recorded = Some(&arguments.recorded);
    let data = TrainingData::open(config, &arguments.data, &arguments.sensors, recorded, &arguments.judging)?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&data.trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let made = data.provenance("train clusters", &options(arguments), &arguments.judging, CHOICE_SEED);
    let library = match &arguments.prototypes {
        Some(path) => prototypes_from(path)?,
        None => prototypes_in(&data, made.clone(), interrupted)?,
    };
    let clusters = TrainedClusters::of(&data, &library, &arguments.odds, interrupted)?;
    let text = format!("{}\n\n{}", drives(&data.parted), clusters.text());
    directory.write_file(MANIFEST_JSON, format!("{:#}\n", manifest(&data, started)).as_bytes())?;
    let file = clusters.model.to_file(made).with_parameters(parameters);
    directory.write_file(CLUSTERS_FILE, &file.to_bytes())?;
    let finished = directory.finish()?;
    let printed = print_result_in("Model", &finished, text);
    print_run_command("-d kd-tree", "clusters", &finished, &arguments.parameters);
    printed
}

/// The detector whose clusters are learned from, at its own parameters.
fn kd_tree_clusters(config: &RunConfig) -> ClustersOf<'_> {
    let min_points = config.hierarchical.cluster.min_vehicle_points;
    ClustersOf { config, detector: "kd-tree", min_points, seed: CHOICE_SEED }
}

/// Side profiles of the vehicles among the clusters of the drives trained on.
pub fn prototypes_in(
    data: &TrainingData<'_>,
    made: Provenance,
    interrupted: &AtomicBool,
) -> Result<PrototypeLibrary, Failure> {
    let mut candidates = Vec::new();
    for it in &data.trained {
        let id = &it.dataset.description().id;
        let clusters = kd_tree_clusters(&data.config);
        let kept = |found: Vec<_>| found.into_iter().filter(is_seen_well).collect();
        let found = clusters.candidates(it, ModelKind::Paper, interrupted, kept)?;
        candidates.extend(found.into_iter().filter(|found| !data.parted.is_held_out(id, &found.sequence)));
    }
    prototypes_of(&candidates.iter().collect::<Vec<_>>(), PROTOTYPES as usize, made)
}

/// The model that classifies vehicles among clusters, and how good it is on drives it has not seen.
struct TrainedClusters {
    model: VehicleModel,
    n_taught: usize,
    curves: OperatingCurves,
}

impl TrainedClusters {
    fn of(
        data: &TrainingData<'_>,
        library: &PrototypeLibrary,
        odds: &[ModelOdds],
        interrupted: &AtomicBool,
    ) -> Result<Self, Failure> {
        let (mut taught, mut judged): (Vec<ClusterExample>, Vec<ClusterExample>) = (Vec::new(), Vec::new());
        let mut n_by_dataset = Vec::new();
        for it in data.opened() {
            let n_before = taught.len();
            let id = &it.dataset.description().id;
            let clusters = kd_tree_clusters(&data.config);
            let described = |found: Vec<_>| described_clusters(&found, library);
            for found in clusters.candidates(it, ModelKind::Paper, interrupted, described)? {
                let is_held_out = data.parted.is_held_out(id, &found.sequence);
                if is_held_out { &mut judged } else { &mut taught }.push(found);
            }
            n_by_dataset.push((it, taught.len() - n_before));
        }
        let of_datasets = weights_of(&n_by_dataset);
        let weights: Vec<f64> =
            n_by_dataset.iter().zip(of_datasets).flat_map(|(it, weight)| repeat_n(weight, it.1)).collect();
        let examples = |road_user: RoadUser| {
            let weighted = taught.iter().zip(&weights).filter(|(it, _)| it.may_be.allows(road_user));
            let labeled = weighted.filter_map(|(it, &weight)| {
                Some(ClassExample { values: &it.values, is_so: it.shows[road_user as usize]?, weight })
            });
            labeled.collect::<Vec<_>>()
        };
        let forests = train_road_users(&examples, &|| ()).map_err(|error| nothing(&error))?;
        let forests = ModelOdds::applied(odds, CLUSTER_MODEL, forests);
        let is_vehicle = |it: &ClusterExample| it.shows[RoadUser::Vehicle as usize] == Some(true);
        let of_size = judged.iter().filter(|it| it.may_be.allows(RoadUser::Vehicle));
        let curves =
            OperatingCurves::of(of_size.map(|it| (forests.vehicles.sum(&it.values), is_vehicle(it))));
        Ok(Self { model: VehicleModel::new(library.clone(), forests), n_taught: taught.len(), curves })
    }

    fn text(&self) -> String {
        let share = |area: Option<f64>| area.map_or_else(|| "undefined".to_owned(), |it| format!("{it:.4}"));
        let [n_vehicles, n_others] = self.curves.totals();
        format!(
            "vehicles among clusters, trained on {}; on {n_vehicles} held-out vehicles and {n_others} others: ROC area {}, \
             precision-recall area {}",
            self.n_taught,
            share(self.curves.roc_area()),
            share(self.curves.precision_recall_area()),
        )
    }
}
