//! Files that a run leaves once all scans are judged: numbers, their tables, the page.

use reports::facts::run_facts::RunFacts;
use reports::files::csv_rows::to_csv_bytes;
use reports::numbers::processor_time_row::ProcessorTimeRow;
use reports::numbers::run_report::RunReport;
use reports::numbers::tally::Tally;
use reports::pages::run_page::RunPage;
use reports::protocols::protocol_report::ProtocolReport;
use reports::rows::agreement_row::AgreementRow;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{
    AGREEMENT_CSV, CONFUSION_CSV, ERRORS_CSV, PRECISION_RECALL_CSV, PROTOCOLS_JSON, REPORT_JSON,
    RunDirectory, TIMES_OF_PROCESSORS_CSV,
};
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::tables::agreement_table::AgreementOfDetectors as AgreementOfDetectorsTable;
use reports::tables::formats::format::Format as _;
use reports::tables::formats::lists::{TABLE_FORMATS, protocol_formats};
use reports::tables::formats::markdown::Markdown;
use reports::tables::protocol_table::{ProtocolLines, ProtocolTable};
use reports::tables::stage_table::StageTable;
use reports::tables::times_table::TimesTable;

use crate::plumbing::failure::Failure;
use crate::plumbing::paper_files::write_table;
use crate::plumbing::standard_streams::terminal;

/// Writes numbers, tables and page of a run into `directory`.
pub fn write_facts(directory: &RunDirectory, facts: &RunFacts) -> Result<(), Failure> {
    let RunFacts { manifest, report, .. } = facts;
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    directory.write_file(REPORT_JSON, report.to_json().as_bytes())?;
    for table in &facts.tables {
        for format in TABLE_FORMATS {
            directory.write_file(&format.file_name(&table.file_stem()), format.text(table).as_bytes())?;
        }
    }
    directory.write_file("table_times.md", Markdown.text(&TimesTable::new(report, manifest)).as_bytes())?;
    if let Some(stages) = StageTable::new(report, manifest) {
        directory.write_file("table_stages.md", Markdown.text(&stages).as_bytes())?;
    }
    directory.write_file(PRECISION_RECALL_CSV, &to_csv_bytes(&facts.tally.precision_recall_rows())?)?;
    directory.write_file(ERRORS_CSV, &to_csv_bytes(&facts.errors)?)?;
    for table in &facts.classes {
        write_table(directory, &table.file_stem(), table)?;
    }
    for table in &facts.slices {
        write_table(directory, &table.file_stem(), table)?;
    }
    if !facts.confusion.is_empty() {
        directory.write_file(CONFUSION_CSV, &to_csv_bytes(&facts.confusion)?)?;
    }
    Ok(RunPage::of(facts).write(directory.folder())?)
}

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

/// Writes the numbers of `manifest`'s run under protocols into `directory` in all their forms. Returns what is printed: the
/// short table of each protocol.
pub fn write_protocols(
    directory: &RunDirectory,
    manifest: &Manifest,
    report: &ProtocolReport,
) -> Result<Vec<String>, Failure> {
    directory.write_file(PROTOCOLS_JSON, report.to_json().as_bytes())?;
    for table in ProtocolTable::all(report, manifest, ProtocolLines::Every) {
        for format in protocol_formats() {
            directory.write_file(&format.file_name(&table.file_stem()), format.text(&table).as_bytes())?;
        }
    }
    let short = ProtocolTable::all(report, manifest, ProtocolLines::Short);
    for table in short.iter().filter(|it| it.is_short()) {
        write_table(directory, &table.file_stem(), table)?;
    }
    Ok(short.iter().map(|it| terminal().text(it)).collect())
}

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
        let report =
            RunReport::with_overall(manifest.scoring_version, tally.time_rows(), tally.overall_time_rows())?;
        let of_report = report.rows().iter().chain(report.overall());
        rows.extend(of_report.map(|it| ProcessorTimeRow::new(processor, it)));
        let mut on_processor = manifest.clone();
        on_processor.machine.cpu_model.clone_from(processor);
        tables.push(Markdown.text(&TimesTable::new(&report, &on_processor)));
    }
    directory.write_file(TIMES_OF_PROCESSORS_CSV, &to_csv_bytes(&rows)?)?;
    Ok(directory.write_file("table_times.md", tables.join("\n").as_bytes())?)
}
