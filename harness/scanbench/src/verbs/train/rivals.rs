//! `scanbench train rivals`.

use std::collections::BTreeMap;
use std::iter::repeat_n;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use baselines::kd_tree_groups::component_groups;
use baselines::kd_tree_linkage::{KdTreeLinkage, NESTED_TOLERANCES_M};
use baselines::kd_tree_models::{KD_TREE_TRAINED, KD_TREE_TREE, TrainedComponents};
use detector::classify::model_file::ModelFile;
use detector::classify::vehicle_model::{CLUSTER_MODEL, VehicleModel};
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use detector::params::{HierarchicalParams, PAPER_SENSOR};
use detector::road_user::RoadUser;
use evaluation::run::config::{CLUSTERS_FILE, COMPONENTS_FILE, NESTED_FILE, RunConfig};
use evaluation::training::cluster_training::{ClusterExample, described_clusters};
use evaluation::training::group_examples::ScanGroups;
use evaluation::training::grouping_training::{ClassExample, best_tolerances, train_road_users};
use evaluation::training::model_kind::ModelKind;
use evaluation::training::model_odds::ModelOdds;
use evaluation::training::operating_curves::OperatingCurves;
use evaluation::training::prototypes::is_seen_well;
use evaluation::training::{CHOICE_SEED, PROTOTYPES};
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};

use crate::cli::TreeTrainingArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, ids_of};
use crate::plumbing::provenance::compact_utc;
use crate::plumbing::run_directory::{claim_named, claim_unnamed};
use crate::plumbing::standard_streams::{print_diagnostic, print_result_in};
use crate::verbs::train::clusters::{ClustersOf, prototypes_of};
use crate::verbs::train::data::{TrainingData, TrainingParameters, nothing, weights_of};
use crate::verbs::train::files::manifest;
use crate::verbs::train::groupings::{
    TrainedTrees, check_odds, drives, groups_of_all, options, prototypes_from,
};

/// Trains the models of the rivals over a kd-tree, evaluates them on held-out drives, and writes and prints the result.
pub fn train_rivals(arguments: &TreeTrainingArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    check_odds(&arguments.odds, &[CLUSTER_MODEL, KD_TREE_TRAINED, KD_TREE_TREE])?;
    let named = claim_named(&arguments.output)?;
    let TrainingParameters { config, parameters } = TrainingParameters::of(&arguments.parameters)?;
    let data = TrainingData::open(
        config,
        &arguments.data,
        &arguments.sensors,
        Some(&arguments.recorded),
        &arguments.judging,
    )?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&data.trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let made = data.provenance("train rivals", &options(arguments), &arguments.judging, CHOICE_SEED);
    let library = match &arguments.prototypes {
        Some(path) => prototypes_from(path)?,
        None => found_prototypes(&data, made.clone(), interrupted)?,
    };
    let rivals = Rivals::train(&data, library, &arguments.odds, interrupted)?;
    let text = rivals.text(&data);
    directory.write_file(MANIFEST_JSON, format!("{:#}\n", manifest(&data, started)).as_bytes())?;
    for (name, content) in rivals.files(&made, &parameters)? {
        directory.write_file(name, &content)?;
    }
    let finished = directory.finish()?;
    let printed = print_result_in("Models", &finished, text);
    let setting = shell_word(&format!("vehicle_model.rivals_directory={}", finished.display()));
    print_diagnostic(format_args!(
        "Run them: scanbench run -d kd-tree-trained,kd-tree-tree,kd-tree -P {setting}"
    ));
    printed
}

/// The models of all rivals, and how good they are on held-out drives.
struct Rivals {
    clusters: TrainedClusters,
    nested: TrainedTrees,
    components: TrainedTrees,
    // By sensor.
    tolerances_m: BTreeMap<String, f32>,
}

impl Rivals {
    fn train(
        data: &TrainingData<'_>,
        library: PrototypeLibrary,
        odds: &[ModelOdds],
        interrupted: &AtomicBool,
    ) -> Result<Self, Failure> {
        let rounds = data.config.hierarchical.grouping.rounds;
        let clusters = TrainedClusters::of(data, &library, odds, interrupted)?;
        let nested_for = |_: &str, params: &HierarchicalParams, height_m| {
            component_groups(KdTreeLinkage::nested(), params, height_m)
        };
        let scans = groups_of_all(data, &library, &nested_for, interrupted)?;
        let tolerances_m = chosen_tolerances(data, &scans)?;
        let nested = TrainedTrees::of(data, &scans, rounds, library.clone(), (KD_TREE_TREE, odds))?;
        drop(scans);
        let components_for = |sensor: &str, params: &HierarchicalParams, height_m| {
            let tolerance_m = tolerances_m.get(sensor).unwrap_or(&tolerances_m[PAPER_SENSOR]);
            component_groups(KdTreeLinkage::at(*tolerance_m), params, height_m)
        };
        let scans = groups_of_all(data, &library, &components_for, interrupted)?;
        let components = TrainedTrees::of(data, &scans, rounds, library, (KD_TREE_TRAINED, odds))?;
        Ok(Self { clusters, nested, components, tolerances_m })
    }

    /// The chosen tolerances, and how the models do, for people.
    fn text(&self, data: &TrainingData<'_>) -> String {
        let chosen: Vec<String> =
            self.tolerances_m.iter().map(|(sensor, it)| format!("{sensor} {it} m")).collect();
        let parts = [
            drives(&data.parted),
            format!("kd-tree-trained, at {}\n{}", chosen.join(", "), self.components.text()),
            format!("kd-tree-tree\n{}", self.nested.text()),
            self.clusters.text(),
        ];
        parts.join("\n\n")
    }

    /// Models and calibration by the names of their files.
    fn files(
        self,
        made: &Provenance,
        parameters: &toml::Table,
    ) -> Result<[(&'static str, Vec<u8>); 4], Failure> {
        let in_file = |it: ModelFile| it.with_parameters(parameters.clone()).to_bytes();
        let mut rows = self.components.judgement.rows("kd-tree-trained");
        rows.extend(self.nested.judgement.rows("kd-tree-tree"));
        let components = TrainedComponents::new(Arc::new(self.components.model), self.tolerances_m);
        let nested = self.nested.model.to_file(KD_TREE_TREE, made.clone(), toml::Table::new());
        Ok([
            (CLUSTERS_FILE, in_file(self.clusters.model.to_file(made.clone()))),
            (COMPONENTS_FILE, in_file(components.to_file(made.clone()))),
            (NESTED_FILE, in_file(nested)),
            ("calibration.csv", to_csv_bytes(&rows)?),
        ])
    }
}

/// The tolerance for each sensor that was trained on, and for the paper's, which stands in for others.
fn chosen_tolerances(
    data: &TrainingData<'_>,
    scans: &[(&OpenedDataset, ScanGroups)],
) -> Result<BTreeMap<String, f32>, Failure> {
    let taught = scans.iter().filter_map(|(opened, groups)| {
        let description = opened.dataset.description();
        let is_taught = !data.parted.is_held_out(&description.id, &groups.sequence);
        is_taught.then_some((description.sensor.as_str(), groups))
    });
    let mut tolerances_m = best_tolerances(taught, &NESTED_TOLERANCES_M);
    let first = tolerances_m.values().next().copied();
    let first = first.ok_or_else(|| nothing(&"all scans are held out"))?;
    tolerances_m.entry(PAPER_SENSOR.to_owned()).or_insert(first);
    Ok(tolerances_m)
}

/// The detector whose clusters are learned from, at its own parameters.
fn kd_tree_clusters(config: &RunConfig) -> ClustersOf<'_> {
    let min_points = config.hierarchical.cluster.min_vehicle_points;
    ClustersOf { config, detector: "kd-tree", min_points, seed: CHOICE_SEED }
}

/// Side profiles of the vehicles among the clusters of the drives trained on.
fn found_prototypes(
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
        let mut forests = train_road_users(&examples, &|| ()).map_err(|error| nothing(&error))?;
        forests.vehicles = ModelOdds::applied(odds, CLUSTER_MODEL, forests.vehicles);
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
