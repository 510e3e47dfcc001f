//! `scanbench ablation`.

use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use jiff::Timestamp;
use reports::files::csv_rows::CsvRowWriter;
use reports::numbers::ablation_score::AblationRow;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};
use reports::tables::formats::format::Format as _;
use reports::tables::formats::markdown::Markdown;
use reports::tables::formats::terminal::Terminal;
use reports::tables::studies::ablation_table::AblationTable;

use crate::cli::AblationArgs;
use crate::commands::config::{judging_config, warn_of_unknown_sensor};
use crate::commands::failure::NothingEvaluated;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, ids_of, open_datasets};
use crate::commands::progress::progress_over_scans;
use crate::commands::provenance::{compact_utc, machine};
use crate::commands::run_directory::begin_run_directory;
use crate::commands::run_manifest::{RunSettings, criterion_in_words, detector_entry, run_manifest};
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::run::ablation::{AblationScores, TASK, Variant, variants};
use crate::run::detector_list::{ListedDetector, detectors_named};
use crate::run::side_by_side::SideBySide;

/// The method whose parts are left out.
const METHOD: &str = "hierarchical";

const ABLATION_CSV: &str = "ablation.csv";
const ABLATION_MD: &str = "ablation.md";

/// Runs the hierarchical detector whole and without each of its parts on the same scans, writes the table and prints it.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged, or the output cannot be written; nothing is left behind then.
pub fn ablation(arguments: &AblationArgs) -> anyhow::Result<()> {
    let interrupted = interruption_flag();
    let started = Timestamp::now();
    let listed = detectors_named(&[METHOD.to_owned()])?;
    let config = judging_config(&arguments.config, &arguments.matching, &listed)?;
    let variants = variants(&config)?;
    let datasets = open_datasets(&arguments.data, &config.classes)?;
    let unnamed = format!("{}-ablation-{}", compact_utc(started), ids_of(&datasets));
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let mut evaluated = Vec::new();
    for opened in &datasets {
        evaluated.push(evaluate(arguments, opened, &listed[0], &variants, interrupted)?);
    }
    let settings = RunSettings {
        data: &arguments.data,
        n_warmup: arguments.timing.warmup,
        n_repeats: NonZeroUsize::MIN,
        config: &config,
        detectors: variants.iter().map(|it| detector_entry(&it.name, &listed[0], &it.config)).collect(),
        datasets: &datasets,
        started,
    };
    directory.write_file(MANIFEST_JSON, run_manifest(settings).to_json().as_bytes())?;
    let overall = AblationScores::overall(&evaluated).filter(|_| evaluated.len() > 1);
    let table = AblationTable {
        method: METHOD.to_owned(),
        task: TASK,
        matching_criterion: criterion_in_words(config.matching.criterion),
        cpu_model: machine().cpu_model,
        scores: evaluated.iter().chain(&overall).flat_map(AblationScores::scores).collect(),
    };
    write_table(&directory, &table)?;
    let finished = directory.finish()?;
    let printed = print_result(Terminal::UNFOLDED.text(&table));
    // Also where nobody takes the table: the files are there.
    print_diagnostic(format_args!("Ablation: {}", finished.display()));
    printed
}

fn evaluate(
    arguments: &AblationArgs,
    opened: &OpenedDataset,
    method: &ListedDetector,
    variants: &[Variant],
    interrupted: &AtomicBool,
) -> anyhow::Result<AblationScores> {
    let description = opened.dataset.description();
    warn_of_unknown_sensor(&variants[0].config, &description.sensor);
    let build = |variant: &Variant| {
        let of_sensor = variant.config.for_sensor(&description.sensor);
        method.build(of_sensor.as_ref().unwrap_or(&variant.config), description.sensor_height_m)
    };
    let mut detectors: Vec<_> = variants.iter().map(build).collect();
    let mut scores = AblationScores::new(description, variants);
    let side_by_side = SideBySide {
        dataset: &*opened.dataset,
        scan_indices: &opened.scan_indices,
        matching: variants[0].config.matching,
        n_warmup: arguments.timing.warmup.into(),
        n_repeats: NonZeroUsize::MIN,
        n_jobs: arguments.timing.n_jobs(),
        interrupted,
    };
    let progress = progress_over_scans(opened.scan_indices.len(), &description.id);
    side_by_side.run(&mut detectors, |results| -> anyhow::Result<()> {
        scores.add(description, results.scan, results.results);
        progress.inc(1);
        Ok(())
    })?;
    progress.finish_and_clear();
    opened.warn_of_points_left_out();
    if scores.n_annotations() == 0 {
        let reason = format!("no scan of {:?} has an annotation that counts", description.id);
        return Err(NothingEvaluated { reason }.into());
    }
    Ok(scores)
}

fn write_table(directory: &RunDirectory, table: &AblationTable) -> anyhow::Result<()> {
    let mut rows = CsvRowWriter::new(directory.begin_file(ABLATION_CSV)?)?;
    for score in &table.scores {
        rows.write(&AblationRow::new(table.task, score))?;
    }
    rows.finish()?;
    directory.write_file(ABLATION_MD, Markdown.text(table).as_bytes())?;
    Ok(())
}
