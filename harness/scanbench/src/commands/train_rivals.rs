//! `scanbench train rivals`.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use baselines::kd_tree_groups::{component_stages, nested_stages};
use baselines::kd_tree_linkage::NESTED_TOLERANCES_M;
use baselines::kd_tree_models::{KD_TREE_TREE, TrainedComponents};
use detector::classify::vehicle_model::VehicleModel;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use detector::params::PAPER_SENSOR;
use evaluation::run::config::{CLUSTERS_FILE, COMPONENTS_FILE, NESTED_FILE, RunConfig};
use evaluation::training::boosting::{Target, boost};
use evaluation::training::cluster_training::{ClusterExample, described_clusters};
use evaluation::training::grouping_training::{VEHICLES, best_tolerances};
use evaluation::training::model_kind::ModelKind;
use evaluation::training::operating_curves::OperatingCurves;
use evaluation::training::prototypes::is_seen_well;
use evaluation::training::{CHOICE_SEED, PROTOTYPES};
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};

use crate::cli::TreeTrainingArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::ids_of;
use crate::commands::provenance::compact_utc;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::train_files::manifest;
use crate::commands::train_groupings::{TrainedTrees, drives, groups_of_all, options, prototypes_from};
use crate::commands::training_clusters::{ClustersOf, prototypes_of};
use crate::commands::training_data::{TrainingData, nothing};

/// Trains what the rivals over a kd-tree judge by, judges that by drives it has not seen, and writes and prints the result.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged or too few, or the output cannot be written; nothing is left behind then.
pub fn train_rivals(arguments: &TreeTrainingArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let named = claim_named(&arguments.output)?;
    let data = TrainingData::open(&arguments.data, &arguments.sensors, &arguments.judging)?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&data.trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let made = data.provenance("train rivals", &options(arguments), &arguments.judging, CHOICE_SEED);
    let library = match &arguments.prototypes {
        Some(path) => prototypes_from(path)?,
        None => found_prototypes(&data, made.clone(), interrupted)?,
    };
    let clusters = TrainedClusters::of(&data, &library, interrupted)?;
    let nested = groups_of_all(
        data.opened(),
        &library,
        &|_, params, height_m| nested_stages(params.clone(), height_m),
        interrupted,
    )?;
    let is_taught = |dataset: &str, sequence: &str| !data.parted.is_held_out(dataset, sequence);
    let taught = nested.iter().filter_map(|(opened, groups)| {
        let description = opened.dataset.description();
        is_taught(&description.id, &groups.sequence).then_some((description.sensor.as_str(), groups))
    });
    let mut tolerances_m = best_tolerances(taught, &NESTED_TOLERANCES_M);
    let tree = TrainedTrees::of(&data, &nested, library.clone())?;
    drop(nested);
    let of_others = tolerances_m.values().next().copied();
    let of_others = of_others.ok_or_else(|| Usage("all drives are held out".to_owned()))?;
    tolerances_m.entry(PAPER_SENSOR.to_owned()).or_insert(of_others);
    let tolerance_m = |sensor: &str| tolerances_m.get(sensor).copied().unwrap_or(of_others);
    let components = groups_of_all(
        data.opened(),
        &library,
        &|sensor, params, height_m| component_stages(params.clone(), tolerance_m(sensor), height_m),
        interrupted,
    )?;
    let flat = TrainedTrees::of(&data, &components, library)?;
    let sensors: BTreeSet<&str> =
        data.trained.iter().map(|it| it.dataset.description().sensor.as_str()).collect();
    let chosen: Vec<String> = sensors.iter().map(|it| format!("{it} {} m", tolerance_m(it))).collect();
    let texts = [
        drives(&data.parted),
        format!("kd-tree-trained, at {}\n{}", chosen.join(", "), flat.text()),
        format!("kd-tree-tree\n{}", tree.text()),
        clusters.text(),
    ];
    let mut rows = flat.judgement.rows("kd-tree-trained");
    rows.extend(tree.judgement.rows("kd-tree-tree"));
    let components = TrainedComponents::new(Arc::new(flat.model), tolerances_m);
    let tree = tree.model.to_file(KD_TREE_TREE, made.clone(), toml::Table::new());
    for (name, content) in [
        (MANIFEST_JSON, format!("{:#}\n", manifest(&data, started)).into_bytes()),
        (CLUSTERS_FILE, clusters.model.to_file(made.clone()).to_bytes()),
        (COMPONENTS_FILE, components.to_bytes(made)),
        (NESTED_FILE, tree.to_bytes()),
        ("calibration.csv", to_csv_bytes(&rows)?),
    ] {
        directory.write_file(name, &content)?;
    }
    let finished = directory.finish()?;
    let printed = print_result(texts.join("\n\n"));
    let path = finished.display();
    print_diagnostic(format_args!(
        "Models: {path}\nRun them: scanbench run -d kd-tree-trained,kd-tree-tree,kd-tree -P vehicle_model.rivals_directory={path}"
    ));
    printed
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
    let config = RunConfig::without_vehicle_models()?;
    let mut candidates = Vec::new();
    for it in &data.trained {
        let id = &it.dataset.description().id;
        let clusters = kd_tree_clusters(&config);
        let kept = |found: Vec<_>| found.into_iter().filter(is_seen_well).collect();
        let found = clusters.candidates(it, ModelKind::Paper, interrupted, kept)?;
        candidates.extend(found.into_iter().filter(|found| !data.parted.is_held_out(id, &found.sequence)));
    }
    prototypes_of(&candidates.iter().collect::<Vec<_>>(), PROTOTYPES as usize, made)
}

/// What tells vehicles among clusters, and how it does on drives it has not seen.
struct TrainedClusters {
    model: VehicleModel,
    n_taught: usize,
    curves: OperatingCurves,
}

impl TrainedClusters {
    fn of(
        data: &TrainingData<'_>,
        library: &PrototypeLibrary,
        interrupted: &AtomicBool,
    ) -> Result<Self, Failure> {
        let config = RunConfig::without_vehicle_models()?;
        let (mut taught, mut judged): (Vec<ClusterExample>, Vec<ClusterExample>) = (Vec::new(), Vec::new());
        for it in data.opened() {
            let id = &it.dataset.description().id;
            let clusters = kd_tree_clusters(&config);
            let described = |found: Vec<_>| described_clusters(&found, library);
            for found in clusters.candidates(it, ModelKind::Paper, interrupted, described)? {
                let is_held_out = data.parted.is_held_out(id, &found.sequence);
                if is_held_out { &mut judged } else { &mut taught }.push(found);
            }
        }
        let values: Vec<_> = taught.iter().map(|it| &it.values).collect();
        let are_vehicles: Vec<f64> = taught.iter().map(|it| f64::from(u8::from(it.is_vehicle))).collect();
        let forest =
            boost(&values, &are_vehicles, Target::Yes, &VEHICLES).map_err(|error| nothing(&error))?;
        let curves = OperatingCurves::of(judged.iter().map(|it| (forest.sum(&it.values), it.is_vehicle)));
        Ok(Self { model: VehicleModel::new(library.clone(), forest), n_taught: taught.len(), curves })
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
