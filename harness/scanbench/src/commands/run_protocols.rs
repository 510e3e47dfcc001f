//! What a run leaves behind of protocols of others: their numbers and tables.

use reports::numbers::tally::Tally;
use reports::protocols::protocol_report::ProtocolReport;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{PROTOCOLS_JSON, RunDirectory};
use reports::tables::formats::format::Format as _;
use reports::tables::formats::lists::protocol_formats;
use reports::tables::protocol_table::{ProtocolLines, ProtocolTable};

use crate::commands::failure::Failure;
use crate::commands::paper_files::write_table;
use crate::commands::standard_streams::terminal;

/// Makes the numbers of rows under protocols and writes them into `directory` in all their forms. Returns what is printed:
/// the short table of each protocol. Nothing where the run was evaluated under none.
pub fn write_protocols(
    directory: &RunDirectory,
    manifest: &Manifest,
    (tally, rows): (&Tally, &ProtocolTally),
) -> Result<Vec<String>, Failure> {
    if manifest.protocols.is_empty() {
        return Ok(Vec::new());
    }
    let report = ProtocolReport::new(rows.numbers(tally));
    directory.write_file(PROTOCOLS_JSON, report.to_json().as_bytes())?;
    for table in ProtocolTable::all(&report, manifest, ProtocolLines::Every) {
        for format in protocol_formats() {
            directory.write_file(&format.file_name(&table.file_stem()), format.text(&table).as_bytes())?;
        }
    }
    let short = ProtocolTable::all(&report, manifest, ProtocolLines::Short);
    for table in short.iter().filter(|it| it.is_short()) {
        write_table(directory, &table.file_stem(), table)?;
    }
    Ok(short.iter().map(|it| terminal().text(it)).collect())
}
