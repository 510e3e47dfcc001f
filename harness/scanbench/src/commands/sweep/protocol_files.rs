//! What `scanbench sweep --protocol` leaves behind.

use evaluation::sweep::sweep_tally::SweepTally;
use reports::files::archive::ArchiveError;
use reports::numbers::sweep_score::SweepScores;
use reports::plots::swept_protocol_plot::swept_protocol_plot;
use reports::protocols::swept_numbers::SweptNumbers;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{RunDirectory, SWEEP_PROTOCOLS_CSV, SWEEP_PROTOCOLS_JSON};
use reports::tables::formats::format::Format as _;
use reports::tables::studies::swept_protocol_table::SweptProtocolTable;
use reports::vocabulary::protocol::Protocol;

use crate::commands::official_evaluation::warning_of_no_ground;
use crate::commands::paper_files::{write_figure, write_table};
use crate::commands::progress::progress_over_results;
use crate::commands::standard_streams::{print_diagnostic, terminal};

/// Makes the numbers of a sweep under its protocols and writes them into `directory` in all their forms. Returns the table
/// that is printed.
pub fn write_swept_protocols(
    directory: &RunDirectory,
    manifest: &Manifest,
    tally: &SweepTally<'_>,
    scores: &SweepScores,
) -> Result<String, ArchiveError> {
    let n_points = manifest.sweep.as_ref().map_or(0, |it| it.points.len());
    let bar = progress_over_results(n_points, 0, "protocols");
    let swept = tally.protocol_numbers(scores, || bar.inc(1));
    bar.finish_and_clear();
    if manifest.protocols.contains(&Protocol::Ground) {
        warn_of_no_ground(manifest, &swept);
    }
    let not_written = |source| ArchiveError::Csv { path: directory.path_of(SWEEP_PROTOCOLS_CSV), source };
    directory.write_file(SWEEP_PROTOCOLS_CSV, &swept.to_csv().map_err(not_written)?)?;
    directory.write_file(SWEEP_PROTOCOLS_JSON, swept.to_json().as_bytes())?;
    for (protocol, extent) in swept.extents() {
        if let Some(plot) = swept_protocol_plot(&swept, protocol, extent) {
            write_figure(directory, &format!("protocol_{protocol}_{}", extent.name()), &plot)?;
        }
    }
    let table = SweptProtocolTable { swept: &swept };
    write_table(directory, "sweep_protocols", &table)?;
    Ok(format!("\n{}", terminal().text(&table)))
}

fn warn_of_no_ground(manifest: &Manifest, swept: &SweptNumbers) {
    for detector in manifest.detectors.iter().map(|it| &it.name) {
        let mut of_ground = swept.numbers.iter().filter(|it| it.number.protocol == Protocol::Ground);
        if of_ground.all(|it| it.number.detector != *detector) {
            print_diagnostic(warning_of_no_ground(detector));
        }
    }
}
