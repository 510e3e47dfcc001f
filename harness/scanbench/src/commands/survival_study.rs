//! `scanbench ablation --oracle`.

use evaluation::run::survival::survival;
use jiff::Timestamp;
use reports::files::csv_rows::to_csv_bytes;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};
use reports::tables::formats::format::Format as _;
use reports::tables::studies::survival_table::SurvivalTable;
use std::num::NonZeroUsize;

use crate::cli::AblationArgs;
use crate::commands::config::built_in_detectors;
use crate::commands::failure::Failure;
use crate::commands::first_look::look_first_at_all;
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{ids_of, open_datasets};
use crate::commands::paper_files::write_table;
use crate::commands::progress::progress_over_scans;
use crate::commands::provenance::compact_utc;
use crate::commands::run_directory::begin_run_directory;
use crate::commands::run_manifest::{RunSettings, run_manifest};
use crate::commands::standard_streams::terminal;
use crate::commands::standard_streams::{print_diagnostic, print_result};

/// The method whose steps are looked into.
const METHOD: &str = "hierarchical";

const ORACLE_CSV: &str = "oracle.csv";

/// Counts the annotated objects that survive each step of the method, and writes and prints the table.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged, or the output cannot be
/// written; nothing is left behind then.
pub fn survival_study(arguments: &AblationArgs) -> Result<(), Failure> {
    let (interrupted, started) = (interruption_flag(), Timestamp::now());
    let (listed, mut config) = built_in_detectors(&arguments.config, &[METHOD.to_owned()])?;
    let datasets = look_first_at_all(open_datasets(&arguments.data, &config.classes)?, &mut config);
    let unnamed = format!("{}-oracle-{}", compact_utc(started), ids_of(&datasets));
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let mut rows = Vec::new();
    for it in &datasets {
        let description = it.dataset.description();
        let of_sensor = config.for_scans_of(description);
        let progress = progress_over_scans(it.scan_indices.len(), &description.id);
        let method = (listed[0], &of_sensor);
        rows.extend(survival(&*it.dataset, &it.scan_indices, method, interrupted, || progress.inc(1))?);
        progress.finish_and_clear();
        it.warn_of_points_left_out();
    }
    let manifest = run_manifest(RunSettings {
        selection: arguments.data.scans.as_deref(),
        n_warmup: arguments.timing.warmup,
        n_repeats: NonZeroUsize::MIN,
        config: &config,
        detectors: Vec::new(),
        datasets: &datasets,
        protocols: &[],
        started,
    });
    let table = SurvivalTable { rows: &rows };
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    directory.write_file(ORACLE_CSV, &to_csv_bytes(&rows)?)?;
    write_table(&directory, "oracle", &table)?;
    let finished = directory.finish()?;
    let printed = print_result(terminal().text(&table));
    print_diagnostic(format_args!("Oracle: {}", finished.display()));
    printed
}
