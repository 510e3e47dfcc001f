//! What a run leaves behind once all scans are judged: its numbers, their tables and the page.

use evaluation::metrics::counts::SCORING_VERSION;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::run_report::RunReport;
use reports::numbers::tally::Tally;
use reports::pages::run_page::RunPage;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{ERRORS_CSV, PRECISION_RECALL_CSV, REPORT_JSON, RunDirectory};
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::lists::TABLE_FORMATS;
use reports::tables::formats::markdown::Markdown;
use reports::tables::run_in_short::RunInShort;
use reports::tables::stage_table::StageTable;
use reports::tables::task_table::task_tables;
use reports::tables::times_table::TimesTable;

use crate::commands::failure::Failure;

/// The numbers of a run, and their tables.
pub struct RunNumbers {
    /// The numbers.
    pub report: RunReport,
    /// What is printed of it.
    pub short: RunInShort,
    /// How long detection took.
    pub times: TimesTable,
}

/// Makes the numbers of `tally` and writes them into `directory` in all their forms. The page is made of the files, so that
/// `scanbench report` makes the same.
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
        for format in TABLE_FORMATS {
            directory.write_file(&format.file_name(&table.file_stem()), format.text(table).as_bytes())?;
        }
    }
    let times = TimesTable::new(&report, manifest);
    directory.write_file("table_times.md", Markdown.text(&times).as_bytes())?;
    if let Some(stages) = StageTable::new(&report, manifest) {
        directory.write_file("table_stages.md", Markdown.text(&stages).as_bytes())?;
    }
    directory.write_file(PRECISION_RECALL_CSV, &to_csv_bytes(&tally.precision_recall_rows())?)?;
    let page = RunPage::of(directory.folder())?;
    directory.write_file(ERRORS_CSV, &to_csv_bytes(&page.errors)?)?;
    page.write(directory.folder())?;
    Ok(RunNumbers { report, short: page.short, times })
}
