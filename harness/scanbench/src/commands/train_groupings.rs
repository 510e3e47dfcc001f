//! `scanbench train --detector hierarchical`.

use std::sync::atomic::AtomicBool;

use detector::classify::forest::Forest;
use detector::classify::forest_file::write_forest;
use detector::classify::grouping_model::{
    MORE_LOOKS_PURPOSES, OBJECTS_PURPOSE, SECOND_LOOK_VALUES, VEHICLE_VALUES, vehicles_purpose,
};
use detector::classify::object_looks::{LookBuffers, ObjectLooks};
use detector::classify::vehicle_model::VehicleModel;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use detector::group::node_values::NODE_VALUES;
use evaluation::run::config::RunConfig;
use evaluation::training::boosting::{BoostingParams, Target, boost};
use evaluation::training::calibration::{CalibrationBin, calibration};
use evaluation::training::group_examples::{GroupLabels, LEAST_IOU, ScanGroups, collect_groups};
use evaluation::training::held_out::HeldOut;
use evaluation::training::looks::{N_FORESTS, train_looks};
use evaluation::training::operating_curves::OperatingCurves;
use evaluation::training::{CHOICE_SEED, HOLD_OUT_EVERY, OTHERS_PER_VEHICLE, PROTOTYPES};
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::rows::training_row::CalibrationRow;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};
use scans::dataset::class_table::ClassTable;

use crate::cli::{DEFAULT_VEHICLES, TrainArgs};
use crate::commands::config::warn_of_unknown_sensor;
use crate::commands::failure::{Failure, Usage};
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, ids_of, open_datasets};
use crate::commands::progress::{progress_over_results, progress_over_scans};
use crate::commands::provenance::compact_utc;
use crate::commands::reproducible_command::reproducible_command;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::train_files::{TrainingSettings, manifest};
use crate::commands::training_data::{held_out_arguments, name_with_seed, nothing, parted};

/// Chosen on held-out drives of the training streets. Trees that each learn from half of the examples and values do as well, and
/// take less time.
const OBJECTS: BoostingParams =
    BoostingParams { n_trees: 80, depth: 6, learning_rate: 0.18, least_leaf_weight: 50.0, drawn_share: 0.5 };
/// More trees are better on held-out drives, and rank the cars of recorded scans worse.
const VEHICLES: BoostingParams =
    BoostingParams { n_trees: 400, depth: 6, learning_rate: 0.1, least_leaf_weight: 5.0, drawn_share: 0.5 };

/// The forest of vehicles learns from groups that the looks say are worth so much: what is worth less is not taken for an object.
const LEAST_WORTH_TOLD: f32 = 0.25;

/// Trains both forests, judges them by drives they have not seen, and writes and prints the result.
///
/// # Errors
///
/// If an option is given that says nothing here, anything asked for is not there, data are damaged or too few, or the output
/// cannot be written; nothing is left behind then.
pub fn train_groupings(arguments: &TrainArgs) -> Result<(), Failure> {
    check_options(arguments)?;
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let named = claim_named(&arguments.output)?;
    let trained = open_for_sensors(arguments)?;
    let held_out_arguments = held_out_arguments(arguments);
    let held_out = match &held_out_arguments {
        Some(arguments) => open_datasets(arguments, &ClassTable::default())?,
        None => Vec::new(),
    };
    let parted = parted(arguments, &trained, &held_out)?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&trained));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    // The side profiles are those of the vehicle model.
    let library = VehicleModel::shipped().prototypes().clone();
    let mut scans = Vec::new();
    for opened in [&trained, &held_out] {
        scans.extend(collect_all(opened, &library, interrupted)?);
    }
    let made = provenance(arguments, &trained, &parted);
    let (judged, taught): (Vec<_>, Vec<_>) =
        scans.iter().partition(|(dataset, it)| parted.is_held_out(dataset, &it.sequence));
    let taught: Vec<&ScanGroups> = taught.into_iter().map(|(_, it)| it).collect();
    let judged: Vec<&ScanGroups> = judged.into_iter().map(|(_, it)| it).collect();
    let forests = Forests::train(&taught)?;
    let judgement = Judgement::of(&forests, &judged);
    let purpose = vehicles_purpose(&library);
    let settings = TrainingSettings {
        made: made.clone(),
        data: &arguments.data,
        held_out_data: held_out_arguments.as_ref(),
        trained: &trained,
        held_out: &held_out,
        parted: &parted,
        started,
    };
    let second_look = |look_idx: usize| {
        let forest = &forests.objects.more[look_idx];
        write_forest(forest, MORE_LOOKS_PURPOSES[look_idx], SECOND_LOOK_VALUES, &made)
    };
    for (name, content) in [
        (MANIFEST_JSON, format!("{:#}\n", manifest(&settings))),
        ("prototypes.toml", library.to_toml()),
        ("objects.toml", write_forest(&forests.objects.first, OBJECTS_PURPOSE, NODE_VALUES, &made)),
        ("objects_second_look.toml", second_look(0)),
        ("objects_third_look.toml", second_look(1)),
        ("vehicles.toml", write_forest(&forests.vehicles, &purpose, VEHICLE_VALUES, &made)),
    ] {
        directory.write_file(name, content.as_bytes())?;
    }
    directory.write_file("calibration.csv", &to_csv_bytes(&judgement.rows())?)?;
    let finished = directory.finish()?;
    let n_taught = taught.iter().flat_map(|it| &it.groups).filter(|it| it.labels.is_some()).count();
    let printed = print_result(judgement.text(&parted, n_taught));
    print_diagnostic(format_args!("Model: {}", finished.display()));
    printed
}

/// The data sets, seen by each sensor in turn.
fn open_for_sensors(arguments: &TrainArgs) -> Result<Vec<OpenedDataset>, Failure> {
    if arguments.sensors.is_empty() {
        return open_datasets(&arguments.data, &ClassTable::default());
    }
    let mut opened = Vec::new();
    for sensor in &arguments.sensors {
        let mut data = arguments.data.clone();
        data.source.sensor = Some(sensor.clone());
        opened.extend(open_datasets(&data, &ClassTable::default())?);
    }
    Ok(opened)
}

/// Refuses what is there for the other models.
fn check_options(arguments: &TrainArgs) -> Result<(), Failure> {
    let given = [
        ("--clusters", arguments.clusters.is_some()),
        ("--vehicles", arguments.vehicles != DEFAULT_VEHICLES),
        ("--others", arguments.others != OTHERS_PER_VEHICLE),
        ("--parts-and-pairs", arguments.parts_and_pairs),
        ("--any-size", arguments.any_size),
        ("--prototypes", arguments.prototypes != PROTOTYPES),
        ("--gamma", arguments.gamma.is_some()),
        ("--nu", arguments.nu.is_some()),
        ("--choice-seed", arguments.choice_seed != CHOICE_SEED),
    ];
    match given.iter().find(|it| it.1) {
        Some((option, _)) => {
            let problem = format!(
                "{option} says nothing about --detector hierarchical, which is trained on all groups; --detector kd-tree, paper and pca \
                 have it"
            );
            Err(Usage(problem).into())
        }
        None => Ok(()),
    }
}

fn collect_all<'a>(
    opened: &'a [OpenedDataset],
    library: &PrototypeLibrary,
    interrupted: &AtomicBool,
) -> Result<Vec<(&'a str, ScanGroups)>, Failure> {
    let config = RunConfig::without_vehicle_models()?;
    let mut scans = Vec::new();
    for it in opened {
        let OpenedDataset { dataset, scan_indices, .. } = it;
        let description = dataset.description();
        warn_of_unknown_sensor(&config, description);
        let of_sensor = config.for_scans_of(description);
        let progress = progress_over_scans(scan_indices.len(), &description.id);
        let described_with = (&of_sensor.hierarchical, library);
        let found =
            collect_groups(&**dataset, scan_indices, described_with, interrupted, || progress.inc(1))?;
        scans.extend(found.into_iter().map(|it| (description.id.as_str(), it)));
        progress.finish_and_clear();
        it.warn_of_points_left_out();
    }
    Ok(scans)
}

fn provenance(arguments: &TrainArgs, opened: &[OpenedDataset], parted: &HeldOut) -> Provenance {
    let hold_out_every =
        (arguments.hold_out_every != HOLD_OUT_EVERY).then(|| arguments.hold_out_every.to_string());
    let mut options =
        vec![("--detector", Some("groupings".to_owned())), ("--hold-out-every", hold_out_every)];
    let sensors = (!arguments.sensors.is_empty()).then(|| arguments.sensors.join(","));
    options.push(("--sensors", sensors));
    options.extend(arguments.held_out.iter().map(|it| ("--held-out", Some(it.clone()))));
    options.extend([
        ("--held-out-format", arguments.held_out_format.clone()),
        ("--held-out-scans", arguments.held_out_scans.clone()),
    ]);
    Provenance {
        command: reproducible_command("train", &arguments.data, &options),
        data: opened.iter().map(name_with_seed).collect(),
        seed: arguments.choice_seed,
        split: format!("held out: {}", HeldOut::names(&parted.held_out)),
    }
}

struct Forests {
    objects: ObjectLooks,
    vehicles: Forest<{ VEHICLE_VALUES.len() }>,
}

impl Forests {
    fn train(taught: &[&ScanGroups]) -> Result<Self, Failure> {
        let progress = progress_over_results(N_FORESTS + 1, 0, "forests");
        let on_forest = || progress.inc(1);
        let objects = train_looks(taught, &OBJECTS, &on_forest).map_err(|error| nothing(&error))?;
        let mut buffers = LookBuffers::default();
        let (mut values, mut are_vehicles) = (Vec::new(), Vec::new());
        for scan in taught {
            for (worth, it) in scan.worths(&objects, &mut buffers).into_iter().zip(&scan.groups) {
                let told = it.labels.and_then(|it| it.is_vehicle).filter(|_| worth >= LEAST_WORTH_TOLD);
                if let Some(is_vehicle) = told {
                    values.push(&it.vehicle_values);
                    are_vehicles.push(f64::from(u8::from(is_vehicle)));
                }
            }
        }
        let vehicles =
            boost(&values, &are_vehicles, Target::Yes, &VEHICLES).map_err(|error| nothing(&error))?;
        progress.finish_and_clear();
        Ok(Self { objects, vehicles })
    }
}

/// How the forests do on groups of drives they have not seen.
struct Judgement {
    n: usize,
    n_objects: usize,
    objects: OperatingCurves,
    n_vehicles: usize,
    vehicles: OperatingCurves,
    ious: Vec<CalibrationBin>,
    probabilities: Vec<CalibrationBin>,
}

impl Judgement {
    fn of(forests: &Forests, judged: &[&ScanGroups]) -> Self {
        let mut buffers = LookBuffers::default();
        let (mut worths, mut odds) = (Vec::new(), Vec::new());
        for scan in judged {
            for (worth, it) in scan.worths(&forests.objects, &mut buffers).into_iter().zip(&scan.groups) {
                let Some(GroupLabels { iou, is_vehicle }) = it.labels else { continue };
                worths.push((worth, iou));
                if let Some(is_vehicle) = is_vehicle.filter(|_| worth >= LEAST_WORTH_TOLD) {
                    odds.push((forests.vehicles.sum(&it.vehicle_values), is_vehicle));
                }
            }
        }
        let probability = |log_odds: f32| 1.0 / (1.0 + f64::from(-log_odds).exp());
        Self {
            n: worths.len(),
            n_objects: worths.iter().filter(|it| it.1 >= LEAST_IOU).count(),
            objects: OperatingCurves::of(worths.iter().map(|it| (it.0, it.1 >= LEAST_IOU))),
            n_vehicles: odds.iter().filter(|it| it.1).count(),
            vehicles: OperatingCurves::of(odds.iter().copied()),
            ious: calibration(worths.iter().map(|it| (f64::from(it.0).clamp(0.0, 1.0), f64::from(it.1)))),
            probabilities: calibration(odds.iter().map(|it| (probability(it.0), f64::from(u8::from(it.1))))),
        }
    }

    fn rows(&self) -> Vec<CalibrationRow> {
        let row =
            |what: &str, it: &CalibrationBin| CalibrationRow::new(what, [it.expected, it.observed], it.n);
        let ious = self.ious.iter().map(|it| row("iou", it));
        ious.chain(self.probabilities.iter().map(|it| row("vehicle", it))).collect()
    }

    fn text(&self, parted: &HeldOut, n_taught: usize) -> String {
        let share = |area: Option<f64>| area.map_or_else(|| "undefined".to_owned(), |it| format!("{it:.4}"));
        let Self { n, n_objects, n_vehicles, .. } = self;
        let mut lines = vec![
            format!("Trained on {} drives: {}", parted.trained.len(), HeldOut::summary(&parted.trained)),
            format!("Held out {} drives: {}", parted.held_out.len(), HeldOut::summary(&parted.held_out)),
            format!("Trained on {n_taught} groups"),
            String::new(),
            format!(
                "On {n} held-out groups, of which {n_objects} show an object; of those worth {LEAST_WORTH_TOLD} and more, {n_vehicles} show a \
                 vehicle:"
            ),
            format!("{:<12}{:>10}{:>24}", "", "ROC area", "precision-recall area"),
        ];
        for (what, curves) in [("objects", &self.objects), ("vehicles", &self.vehicles)] {
            let areas = [curves.roc_area(), curves.precision_recall_area()].map(share);
            lines.push(format!("{what:<12}{:>10}{:>24}", areas[0], areas[1]));
        }
        for (title, bins) in [
            ("Intersection over union with an object", &self.ious),
            ("Probability of a vehicle", &self.probabilities),
        ] {
            lines.push(String::new());
            lines.push(title.to_owned());
            lines.push(format!("{:>10}{:>10}{:>10}", "expected", "observed", "groups"));
            for it in bins {
                lines.push(format!("{:>10.3}{:>10.3}{:>10}", it.expected, it.observed, it.n));
            }
        }
        lines.join("\n")
    }
}
