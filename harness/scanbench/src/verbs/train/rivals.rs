//! `scanbench train rivals`.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use baselines::kd_tree_groups::component_groups;
use baselines::kd_tree_linkage::{KdTreeLinkage, NESTED_TOLERANCES_M};
use baselines::kd_tree_models::{KD_TREE_TRAINED, KD_TREE_TREE, TrainedComponents};
use detector::classify::model_file::ModelFile;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use detector::params::{HierarchicalParams, PAPER_SENSOR};
use evaluation::run::config::{COMPONENTS_FILE, NESTED_FILE};
use evaluation::training::CHOICE_SEED;
use evaluation::training::group_examples::ScanGroups;
use evaluation::training::grouping_training::best_tolerances;
use evaluation::training::model_odds::ModelOdds;
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};

use crate::cli::TreeTrainingArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, ids_of};
use crate::plumbing::provenance::compact_utc;
use crate::plumbing::run_directory::{claim_named, claim_unnamed};
use crate::plumbing::standard_streams::print_result_in;
use crate::verbs::train::cluster_model::prototypes_in;
use crate::verbs::train::data::{TrainingData, TrainingParameters, nothing};
use crate::verbs::train::files::{manifest, print_run_command};
use crate::verbs::train::groupings::{
    TrainedTrees, check_odds, drives, groups_of_all, options, prototypes_from,
};

/// Trains the models of the rivals over a kd-tree, evaluates them on held-out drives, and writes and prints the result.
pub fn train_rivals(arguments: &TreeTrainingArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    check_odds(&arguments.odds, &[KD_TREE_TRAINED, KD_TREE_TREE])?;
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
        None => prototypes_in(&data, made.clone(), interrupted)?,
    };
    let rivals = Rivals::train(&data, library, &arguments.odds, interrupted)?;
    let text = rivals.text(&data);
    directory.write_file(MANIFEST_JSON, format!("{:#}\n", manifest(&data, started)).as_bytes())?;
    for (name, content) in rivals.files(&made, &parameters)? {
        directory.write_file(name, &content)?;
    }
    let finished = directory.finish()?;
    let printed = print_result_in("Models", &finished, text);
    print_run_command("-d kd-tree-trained,kd-tree-tree", "rivals", &finished, &arguments.parameters);
    printed
}

/// The models of all rivals, and how good they are on held-out drives.
struct Rivals {
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
        Ok(Self { nested, components, tolerances_m })
    }

    /// The chosen tolerances, and how the models do, for people.
    fn text(&self, data: &TrainingData<'_>) -> String {
        let chosen: Vec<String> =
            self.tolerances_m.iter().map(|(sensor, it)| format!("{sensor} {it} m")).collect();
        let parts = [
            drives(&data.parted),
            format!("kd-tree-trained, at {}\n{}", chosen.join(", "), self.components.text()),
            format!("kd-tree-tree\n{}", self.nested.text()),
        ];
        parts.join("\n\n")
    }

    /// Models and calibration by the names of their files.
    fn files(
        self,
        made: &Provenance,
        parameters: &toml::Table,
    ) -> Result<[(&'static str, Vec<u8>); 3], Failure> {
        let in_file = |it: ModelFile| it.with_parameters(parameters.clone()).to_bytes();
        let mut rows = self.components.judgement.rows("kd-tree-trained");
        rows.extend(self.nested.judgement.rows("kd-tree-tree"));
        let components = TrainedComponents::new(Arc::new(self.components.model), self.tolerances_m);
        let nested = self.nested.model.to_file(KD_TREE_TREE, made.clone(), toml::Table::new());
        Ok([
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
