//! What a run leaves behind of how far detectors agree.

use reports::files::csv_rows::to_csv_bytes;
use reports::rows::agreement_row::AgreementRow;
use reports::run_folder::run_directory::{AGREEMENT_CSV, RunDirectory};
use reports::tables::agreement_table::AgreementOfDetectors as AgreementOfDetectorsTable;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::markdown::Markdown;

use crate::commands::failure::Failure;
use crate::commands::standard_streams::terminal;

/// Writes how far detectors agree where nothing is labelled, and returns the table; `None` if everything is.
pub fn write_agreement(directory: &RunDirectory, rows: &[AgreementRow]) -> Result<Option<String>, Failure> {
    if rows.is_empty() {
        return Ok(None);
    }
    let table = AgreementOfDetectorsTable { rows };
    directory.write_file(AGREEMENT_CSV, &to_csv_bytes(rows)?)?;
    directory.write_file("table_agreement.md", Markdown.text(&table).as_bytes())?;
    Ok(Some(terminal().text(&table)))
}
