//! What is left and said at the end of a run, made in one piece or put together.

use std::path::Path;

use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::tally::Tally;
use reports::rows::agreement_row::AgreementRow;
use reports::run_folder::manifest::{DatasetEntry, Manifest};
use reports::run_folder::run_directory::{AGREEMENT_CSV, RunDirectory};
use reports::tables::agreement_table::AgreementOfDetectors as AgreementOfDetectorsTable;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::markdown::Markdown;
use reports::verdicts::standing::{Speeds, Standing, speeds, standings};

use crate::commands::failure::Failure;
use crate::commands::run_numbers::RunNumbers;
use crate::commands::standard_streams::{print_diagnostic, print_result, terminal};

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

/// Prints tables, `more` of them, and verdicts of the run that has been written to `finished`.
pub fn print_ending(
    (numbers, manifest, tally): (&RunNumbers, &Manifest, &Tally),
    (more, compared): (Vec<String>, &[AgreementRow]),
    finished: &Path,
) -> Result<(), Failure> {
    let is_compared = |it: &DatasetEntry| compared.iter().any(|row| row.dataset == it.id);
    let is_scored = !manifest.datasets.iter().all(is_compared);
    let standings = standings(tally, manifest, &numbers.report);
    let has_labels = |it: &&Standing| {
        let is_compared = |id: &String| compared.iter().any(|row| row.dataset == *id);
        !it.pool.datasets.iter().all(is_compared)
    };
    let terminal = terminal();
    let tables = numbers.tables.iter().filter(|_| is_scored).map(|it| terminal.text(it));
    let speeds = speeds(manifest, &numbers.report);
    let sentences = standings
        .iter()
        .filter(has_labels)
        .map(Standing::sentence)
        .chain(speeds.iter().filter_map(Speeds::sentence));
    let last = [terminal.text(&numbers.times), terminal.sentences(sentences)];
    let texts = tables.chain(more).chain(last);
    let printed = texts.into_iter().try_for_each(print_result);
    // Also where nobody takes the tables: the run is there.
    print_diagnostic(format_args!("Run directory: {}", finished.display()));
    printed
}
