//! `scanbench train`.

use std::sync::atomic::AtomicBool;

use detector::classify::nu_svc_solver::NuSvcParams;
use detector::classify::nu_svm::NuSvm;
use detector::classify::svm_model::SvmModel;
use detector::classify::svm_training::train_svm;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::trained_file::Provenance;
use detector::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};
use detector::pipeline::vehicle_model::N_FEATURES;
use jiff::Timestamp;
use reports::archive::SCHEMA;
use reports::csv_rows::CsvRowWriter;
use reports::operating_curve::OperatingRow;
use reports::plot::operating_plot::operating_plot;
use reports::run_directory::{LatestPointer, MANIFEST_JSON, RunDirectory};
use reports::training_row::{ImportanceRow, JudgedObjectPlace, JudgedObjectRow};

use crate::cli::TrainArgs;
use crate::commands::config::warn_of_unknown_sensor;
use crate::commands::failure::{NothingEvaluated, Usage};
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, ids_of, open_datasets};
use crate::commands::progress::progress_over_scans;
use crate::commands::provenance::{command_line, compact_utc, git_state, rfc3339_utc, rustc_version};
use crate::commands::reproducible_command::reproducible_command;
use crate::commands::run_directory::begin_run_directory;
use crate::commands::run_manifest::dataset_entry;
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::run::config::RunConfig;
use crate::training::candidates::{Candidate, CandidateKind, collect_candidates};
use crate::training::evaluation::{Evaluation, JudgedObject, evaluate};
use crate::training::held_out::HeldOut;
use crate::training::prototypes::{COLUMN_M, find_prototypes};
use crate::training::selection::select;
use crate::training::{CHOICE_SEED, HOLD_OUT_EVERY, PROTOTYPES};

/// Training ends with decision values this near to where they should be, where the margin is 1; or gives up after so many
/// steps, which a ν below the share of objects that look like the other class needs.
const TOLERANCE: f64 = 0.1;
const MOST_STEPS: usize = 500_000;

/// Trains a vehicle model, judges it by drives it has not seen, and writes and prints the result.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged or too few, or the output cannot be written; nothing is left
/// behind then.
pub fn train(arguments: &TrainArgs) -> anyhow::Result<()> {
    // Before anything is written, so that Ctrl-C leaves nothing behind.
    let interrupted = interruption_flag()?;
    let started = Timestamp::now();
    let opened = open_datasets(&arguments.data)?;
    let drives = opened.iter().map(|it| (&*it.dataset, it.scan_indices.as_slice()));
    let parted = HeldOut::every(arguments.hold_out_every as usize, drives).ok_or_else(|| {
        Usage("the scans are of one drive: there is none to train on and another to judge by".to_owned())
    })?;
    let unnamed = format!("{}-train-{}", compact_utc(started), ids_of(&opened));
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let candidates = collect_all(&opened, arguments.choice_seed, interrupted)?;
    let (held_out, trained): (Vec<_>, Vec<_>) =
        candidates.iter().partition(|(dataset, it)| parted.is_held_out(dataset, &it.sequence));
    let trained: Vec<&Candidate> = trained.into_iter().map(|(_, it)| it).collect();
    let numbers = (arguments.vehicles as usize, arguments.others as usize);
    let selected = select(&trained, numbers, arguments.choice_seed);
    let made = provenance(arguments, &opened, &parted);
    let (library, model) = fit(arguments, &trained, &selected, &made)?;
    let mut describer = VehicleDescriber::new(library.clone());
    let judged: Vec<(&str, &Candidate, JudgedObject)> = held_out
        .into_iter()
        .filter_map(|(dataset, it)| Some((*dataset, it, judged_object(&mut describer, it)?)))
        .collect();
    let objects: Vec<JudgedObject> = judged.iter().map(|&(_, _, object)| object).collect();
    let svm = NuSvm::new(&model);
    let evaluation = evaluate(&svm, &objects, arguments.choice_seed);
    let manifest = manifest(arguments, &opened, &parted, started);
    directory.write_file(MANIFEST_JSON, format!("{manifest:#}\n").as_bytes())?;
    directory.write_file("model.toml", model.to_toml().as_bytes())?;
    directory.write_file("prototypes.toml", library.to_toml().as_bytes())?;
    write_rows(&directory, &judged, &svm, &evaluation, &title(&opened, &evaluation))?;
    let finished = directory.finish()?;
    let printed = print_result(summary(&parted, &selected, &library, &model, &evaluation));
    print_diagnostic(format_args!("Model: {}", finished.display()));
    printed
}

fn collect_all<'a>(
    opened: &'a [OpenedDataset],
    seed: u64,
    interrupted: &AtomicBool,
) -> anyhow::Result<Vec<(&'a str, Candidate)>> {
    let config = RunConfig::load(None)?;
    let mut candidates = Vec::new();
    for OpenedDataset { dataset, scan_indices, .. } in opened {
        let description = dataset.description();
        warn_of_unknown_sensor(&config, &description.sensor);
        let of_sensor = config.for_sensor(&description.sensor).unwrap_or_else(|| config.clone());
        let progress = progress_over_scans(scan_indices.len(), &description.id);
        let detector_and_seed = (&of_sensor.hierarchical, seed);
        let found =
            collect_candidates(&**dataset, scan_indices, detector_and_seed, interrupted, || progress.inc(1))?;
        candidates.extend(found.into_iter().map(|it| (description.id.as_str(), it)));
        progress.finish_and_clear();
    }
    Ok(candidates)
}

/// Everything that decides the model.
fn manifest(
    arguments: &TrainArgs,
    opened: &[OpenedDataset],
    parted: &HeldOut,
    started: Timestamp,
) -> serde_json::Value {
    let datasets: Vec<_> = opened.iter().map(|it| dataset_entry(it, &arguments.data)).collect();
    serde_json::json!({
        "schema": SCHEMA,
        "scanbench_version": env!("CARGO_PKG_VERSION"),
        "created": rfc3339_utc(started),
        "argv": command_line(),
        "datasets": datasets,
        "trained": parted.trained,
        "held_out": parted.held_out,
        "git": git_state(),
        "rustc_version": rustc_version(),
    })
}

fn provenance(arguments: &TrainArgs, opened: &[OpenedDataset], parted: &HeldOut) -> Provenance {
    let unless = |value: u64, standard: u64| (value != standard).then(|| value.to_string());
    let options = [
        ("--hold-out-every", unless(arguments.hold_out_every.into(), HOLD_OUT_EVERY.into())),
        ("--vehicles", Some(arguments.vehicles.to_string())),
        ("--others", Some(arguments.others.to_string())),
        ("--prototypes", unless(arguments.prototypes.into(), PROTOTYPES.into())),
        ("--gamma", Some(arguments.gamma.to_string())),
        ("--nu", Some(arguments.nu.to_string())),
        ("--choice-seed", unless(arguments.choice_seed, CHOICE_SEED)),
    ];
    let name = |it: &OpenedDataset| {
        let description = it.dataset.description();
        match &description.simulation {
            Some(drive) => format!("{} (simulated, seeds from {})", description.id, drive.seed),
            None => description.id.clone(),
        }
    };
    Provenance {
        command: reproducible_command("train", &arguments.data, &options),
        data: opened.iter().map(name).collect(),
        seed: arguments.choice_seed,
        split: format!("held out: {}", HeldOut::names(&parted.held_out)),
    }
}

/// What was judged, and whether it is simulated.
fn title(opened: &[OpenedDataset], evaluation: &Evaluation) -> String {
    let n_simulated = opened.iter().filter(|it| it.dataset.description().is_simulated()).count();
    let simulated = match n_simulated {
        0 => "",
        n if n == opened.len() => " (simulated)",
        _ => " (partly simulated)",
    };
    let [n_vehicles, n_others] = evaluation.curves.totals();
    format!("Held-out drives{simulated}: {n_vehicles} vehicles, {n_others} others")
}

fn fit(
    arguments: &TrainArgs,
    trained: &[&Candidate],
    selected: &[&Candidate],
    made: &Provenance,
) -> anyhow::Result<(PrototypeLibrary, SvmModel<N_FEATURES>)> {
    let prototypes = find_prototypes(trained, arguments.prototypes as usize);
    let nothing = |error: &dyn std::fmt::Display| NothingEvaluated { reason: error.to_string() };
    anyhow::ensure!(!prototypes.is_empty(), nothing(&"no vehicle is seen well enough for a side profile"));
    let library =
        PrototypeLibrary::new(made.clone(), COLUMN_M, prototypes).map_err(|error| nothing(&error))?;
    let mut describer = VehicleDescriber::new(library.clone());
    let objects: Vec<JudgedObject> =
        selected.iter().filter_map(|it| judged_object(&mut describer, it)).collect();
    let vectors: Vec<[f32; N_FEATURES]> = objects.iter().map(|it| it.features).collect();
    let is_vehicle: Vec<bool> = objects.iter().map(|it| it.is_vehicle).collect();
    let params =
        NuSvcParams { gamma: arguments.gamma, nu: arguments.nu, tolerance: TOLERANCE, max_steps: MOST_STEPS };
    let model = train_svm(&vectors, &is_vehicle, VehicleFeatures::NAMES, &params, made.clone())
        .map_err(|error| nothing(&error))?;
    Ok((library, model))
}

fn judged_object(describer: &mut VehicleDescriber, candidate: &Candidate) -> Option<JudgedObject> {
    let features = describer.describe(&candidate.bounding_box, candidate.positions_m.iter().copied())?;
    Some(JudgedObject {
        kind: candidate.kind.name(),
        is_vehicle: candidate.kind.is_vehicle(),
        features: features.values(),
    })
}

fn write_rows(
    directory: &RunDirectory,
    judged: &[(&str, &Candidate, JudgedObject)],
    svm: &NuSvm<N_FEATURES>,
    evaluation: &Evaluation,
    title: &str,
) -> anyhow::Result<()> {
    let mut rows = CsvRowWriter::new(directory.begin_file("objects.csv")?)?;
    for (dataset, candidate, object) in judged {
        let [x_m, y_m, _] = candidate.bounding_box.center_m.map(f64::from);
        let place = JudgedObjectPlace {
            data: dataset,
            sequence: &candidate.sequence,
            kind: object.kind,
            is_vehicle: object.is_vehicle,
            n_points: candidate.positions_m.len(),
            range_m: x_m.hypot(y_m),
        };
        rows.write(&JudgedObjectRow::new(place, svm.decision(&object.features), &object.features))?;
    }
    rows.finish()?;
    let mut rows = CsvRowWriter::new(directory.begin_file("importance.csv")?)?;
    for (feature, loss) in evaluation.importance {
        rows.write(&ImportanceRow::new(feature, loss, judged.len()))?;
    }
    rows.finish()?;
    let totals = evaluation.curves.totals();
    let points = evaluation.curves.points().iter();
    let curve: Vec<OperatingRow> =
        points.map(|it| OperatingRow::new(it.threshold, [it.n_true, it.n_false], totals)).collect();
    let mut rows = CsvRowWriter::new(directory.begin_file("curves.csv")?)?;
    for row in &curve {
        rows.write(row)?;
    }
    rows.finish()?;
    directory.write_file("curves.svg", operating_plot(&curve, title).as_bytes())?;
    Ok(())
}

fn summary(
    parted: &HeldOut,
    selected: &[&Candidate],
    library: &PrototypeLibrary,
    model: &SvmModel<N_FEATURES>,
    evaluation: &Evaluation,
) -> String {
    let n_vehicles = selected.iter().filter(|it| it.kind.is_vehicle()).count();
    let n_cut = selected.iter().filter(|it| it.kind == CandidateKind::CutRegion).count();
    let mut lines = vec![
        format!("Trained on {} drives: {}", parted.trained.len(), HeldOut::names(&parted.trained)),
        format!("Held out {} drives: {}", parted.held_out.len(), HeldOut::names(&parted.held_out)),
        format!(
            "{n_vehicles} vehicles and {} others, {n_cut} of them cut regions; {} prototypes, {} support vectors",
            selected.len() - n_vehicles,
            library.prototypes().len(),
            model.support_vectors.len()
        ),
        String::new(),
        format!("{:<16}{:>14}{:>18}", "held out", "told vehicle", "told background"),
    ];
    for ((_, kind), told) in &evaluation.told {
        lines.push(format!("{kind:<16}{:>14}{:>18}", told.n_vehicle, told.n_background));
    }
    let share = |area: Option<f64>| area.map_or_else(|| "undefined".to_owned(), |it| format!("{it:.4}"));
    lines.push(String::new());
    lines.push(format!("ROC area {}", share(evaluation.curves.roc_area())));
    lines.push(format!("Precision-recall area {}", share(evaluation.curves.precision_recall_area())));
    lines.push(String::new());
    lines.push("Loss of ROC area with one value mixed up between the held-out objects:".to_owned());
    for (feature, loss) in evaluation.importance {
        lines.push(format!("{feature:<22}{:>10}", share(loss)));
    }
    lines.join("\n")
}
