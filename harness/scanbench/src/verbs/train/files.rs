//! Files of `scanbench train`.

use std::path::Path;

use detector::classify::model_file::ModelFile;
use detector::classify::nu_svm::NuSvm;
use detector::classify::svm_model::SvmModel;
use evaluation::run::config::override_option::OverrideOption;
use evaluation::training::candidates::Candidate;
use evaluation::training::described_object::DescribedObject;
use evaluation::training::evaluation::Evaluation;
use jiff::Timestamp;
use reports::files::archive::SCHEMA;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::operating_curve::OperatingRow;
use reports::plots::operating_plot::operating_plot;
use reports::rows::training_row::{ImportanceRow, JudgedObjectFacts, JudgedObjects};
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_target::MANIFEST_JSON;

use crate::cli::DatasetArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::provenance::{command_line, git_state, rfc3339_utc, rustc_version};
use crate::plumbing::run_manifest::dataset_entry;
use crate::plumbing::standard_streams::print_diagnostic;
use crate::verbs::train::data::TrainingData;

/// A model and how it was judged.
pub struct TrainedModel<'a, const D: usize> {
    pub model: SvmModel<D>,
    pub file_name: &'static str,
    /// The file, with what it compares with.
    pub file: ModelFile,
    /// Held-out objects, with their data sets.
    pub judged: Vec<(&'a str, &'a Candidate, DescribedObject<D>)>,
    /// How the classifier does on them.
    pub evaluation: Evaluation<D>,
}

/// Prints the command that runs what was trained: with the option that chooses its `detectors`, the model's `folder`, and the
/// parameters that it was trained with.
pub fn print_run_command(detectors: &str, model: &str, folder: &Path, parameters: &[OverrideOption]) {
    let setting = format!("vehicle_model.{model}_directory={}", folder.display());
    let parameters = parameters.iter().map(ToString::to_string).chain([setting]);
    let parameters: Vec<String> = parameters.map(|it| format!("-P {}", shell_word(&it))).collect();
    let chosen = if detectors.is_empty() { String::new() } else { format!("{detectors} ") };
    print_diagnostic(format_args!("Run it: scanbench run {chosen}{}", parameters.join(" ")));
}

/// The files by their names.
pub fn write_files<const D: usize>(
    data: &TrainingData<'_>,
    started: Timestamp,
    trained: &TrainedModel<'_, D>,
) -> Result<Vec<(&'static str, Vec<u8>)>, Failure> {
    let TrainedModel { model, file_name, file, judged, evaluation } = trained;
    let totals = evaluation.curves.totals();
    let points = evaluation.curves.points().iter();
    let curve: Vec<OperatingRow> =
        points.map(|it| OperatingRow::new(it.threshold, [it.n_true, it.n_false], totals)).collect();
    let importance: Vec<ImportanceRow> = evaluation
        .importance
        .iter()
        .map(|&(name, loss)| ImportanceRow::new(name, loss, judged.len()))
        .collect();
    Ok(vec![
        (MANIFEST_JSON, format!("{:#}\n", manifest(data, started)).into_bytes()),
        (*file_name, file.to_bytes()),
        ("objects.csv", objects(model, judged)?),
        ("importance.csv", to_csv_bytes(&importance)?),
        ("curves.csv", to_csv_bytes(&curve)?),
        ("curves.svg", operating_plot(&curve, &title(data, totals)).into_bytes()),
    ])
}

/// Manifest of the training: everything that decides the model.
pub fn manifest(data: &TrainingData<'_>, started: Timestamp) -> serde_json::Value {
    let entries = |opened: &[OpenedDataset], arguments: &DatasetArgs| {
        opened.iter().map(|it| dataset_entry(it, arguments.scans.as_deref())).collect::<Vec<_>>()
    };
    let (others, recorded) = data.trained.split_at(data.trained.len() - data.n_recorded);
    let mut trained = entries(others, data.data);
    trained.extend(data.recorded_data.iter().flat_map(|it| entries(recorded, it)));
    let to_judge_by = data.held_out_data.as_ref().map_or_else(Vec::new, |it| entries(&data.held_out, it));
    serde_json::json!({
        "schema": SCHEMA,
        "scanbench_version": env!("CARGO_PKG_VERSION"),
        "created": rfc3339_utc(started),
        "argv": command_line(),
        "datasets": trained,
        "held_out_datasets": to_judge_by,
        "trained": data.parted.trained,
        "held_out": data.parted.held_out,
        "git": git_state(),
        "rustc_version": rustc_version(),
    })
}

/// Title of the curves: how many objects were judged, and whether they are simulated.
fn title(data: &TrainingData<'_>, [n_vehicles, n_others]: [usize; 2]) -> String {
    let judged_by = if data.held_out.is_empty() { &data.trained } else { &data.held_out };
    let n_simulated = judged_by.iter().filter(|it| it.dataset.description().is_simulated()).count();
    let simulated = match n_simulated {
        0 => "",
        n if n == judged_by.len() => " (simulated)",
        _ => " (partly simulated)",
    };
    format!("Held-out drives{simulated}: {n_vehicles} vehicles, {n_others} others")
}

fn objects<const D: usize>(
    model: &SvmModel<D>,
    judged: &[(&str, &Candidate, DescribedObject<D>)],
) -> Result<Vec<u8>, Failure> {
    let svm = NuSvm::new(model);
    let mut rows = JudgedObjects::new(&model.features)?;
    for (dataset, candidate, object) in judged {
        let [x_m, y_m, _] = candidate.bounding_box.center_m.map(f64::from);
        let facts = JudgedObjectFacts {
            data: dataset,
            sequence: &candidate.sequence,
            kind: object.kind,
            is_vehicle: object.is_vehicle,
            n_points: candidate.positions_m.len(),
            range_m: x_m.hypot(y_m),
        };
        rows.write(facts, svm.decision(&object.features), &object.features)?;
    }
    Ok(rows.into_csv())
}
