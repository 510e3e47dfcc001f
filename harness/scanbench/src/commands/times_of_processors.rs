//! Times of a run whose shards ran on unlike processors: each processor by itself.

use evaluation::metrics::counts::SCORING_VERSION;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::processor_time_row::ProcessorTimeRow;
use reports::numbers::run_report::RunReport;
use reports::numbers::tally::Tally;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{RunDirectory, TIMES_OF_PROCESSORS_CSV};
use reports::tables::formats::format::Format as _;
use reports::tables::formats::markdown::Markdown;
use reports::tables::times_table::TimesTable;

use crate::commands::failure::Failure;

/// Writes a table of times for each of `processors`, and all of them as rows; nothing if there are none.
pub fn write_times_of_processors(
    directory: &RunDirectory,
    manifest: &Manifest,
    processors: &[(String, Tally)],
) -> Result<(), Failure> {
    if processors.is_empty() {
        return Ok(());
    }
    let (mut rows, mut tables) = (Vec::new(), Vec::new());
    for (processor, tally) in processors {
        let report = RunReport::with_overall(SCORING_VERSION, tally.time_rows(), tally.overall_time_rows())?;
        let of_report = report.rows().iter().chain(report.overall());
        rows.extend(of_report.map(|it| ProcessorTimeRow::new(processor, it)));
        let mut on_processor = manifest.clone();
        on_processor.machine.cpu_model.clone_from(processor);
        tables.push(Markdown.text(&TimesTable::new(&report, &on_processor)));
    }
    directory.write_file(TIMES_OF_PROCESSORS_CSV, &to_csv_bytes(&rows)?)?;
    Ok(directory.write_file("table_times.md", tables.join("\n").as_bytes())?)
}
