//! What a run leaves behind once all scans are judged: its numbers, their tables and the page.

use std::collections::BTreeMap;

use evaluation::metrics::counts::SCORING_VERSION;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::run_report::RunReport;
use reports::numbers::tally::Tally;
use reports::pages::run_page::RunPage;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{PRECISION_RECALL_CSV, REPORT_JSON, RunDirectory};
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::tables::stage_table::StageTable;
use reports::tables::task_table::{TaskTable, task_tables};
use reports::tables::times_table::TimesTable;
use reports::tables::{csv::to_csv, latex::to_latex, markdown::to_markdown};

use crate::commands::failure::Failure;

/// The numbers of a run, and their tables.
pub struct RunNumbers {
    /// The numbers.
    pub report: RunReport,
    /// Task by task.
    pub tables: Vec<TaskTable>,
    /// How long detection took.
    pub times: TimesTable,
}

/// Makes the numbers of `tally` and writes them into `directory` in all their forms. The page is made of the files, so that
/// `scanbench report` makes the same.
///
/// # Errors
///
/// If they do not fit the manifest, or a file cannot be written.
pub fn write_numbers(
    directory: &RunDirectory,
    manifest: &Manifest,
    tally: &Tally,
) -> Result<RunNumbers, Failure> {
    let report = tally.report(SCORING_VERSION)?;
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    directory.write_file(REPORT_JSON, report.to_json().as_bytes())?;
    let tables = task_tables(&report, manifest)?;
    for table in &tables {
        let renderings =
            BTreeMap::from([("csv", to_csv(table)), ("md", to_markdown(table)), ("tex", to_latex(table))]);
        for (extension, text) in renderings {
            directory.write_file(&format!("{}.{extension}", table.file_stem()), text.as_bytes())?;
        }
    }
    let times = TimesTable::new(&report, manifest);
    directory.write_file("table_times.md", times.to_markdown().as_bytes())?;
    if let Some(stages) = StageTable::new(&report, manifest) {
        directory.write_file("table_stages.md", stages.to_markdown().as_bytes())?;
    }
    directory.write_file(PRECISION_RECALL_CSV, &to_csv_bytes(&tally.precision_recall_rows())?)?;
    RunPage::of(directory.folder())?.write(directory.folder())?;
    Ok(RunNumbers { report, tables, times })
}
