//! What `scanbench sweep` leaves behind.

use crate::commands::paper_files::{write_figure, write_table};
use crate::commands::standard_streams::terminal;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::CsvRowWriter;
use reports::numbers::sweep_score::SweepScores;
use reports::plots::fitness_plot::fitness_plot;
use reports::plots::pareto_plot::pareto_plot;
use reports::plots::rate_plot::rate_plot;
use reports::run_folder::run_directory::{RunDirectory, SWEEP_CSV, SWEEP_TIMES_CSV};
use reports::tables::formats::format::Format as _;
use reports::tables::studies::fitness_table::FitnessTable;
use reports::tables::studies::sweep_table::{SweepTable, best_of};
use reports::verdicts::fitness_verdict::fitness_verdicts;

/// Writes tables and plots into `directory`, and returns what is to be printed.
///
/// # Errors
///
/// [`ArchiveError`] if a file cannot be written.
pub fn write_sweep(directory: &RunDirectory, sweep: &SweepScores) -> Result<String, ArchiveError> {
    let not_written = |name: &str| {
        let path = directory.path_of(name);
        move |source| ArchiveError::Csv { path, source }
    };
    directory.write_file(SWEEP_CSV, &sweep.to_csv().map_err(not_written(SWEEP_CSV))?)?;
    if !sweep.times.is_empty() {
        let times = sweep.times_to_csv().map_err(not_written(SWEEP_TIMES_CSV))?;
        directory.write_file(SWEEP_TIMES_CSV, &times)?;
    }
    for extent in sweep.extents() {
        let name = extent.name();
        write_figure(directory, &format!("f_rate_{name}"), &rate_plot(sweep, extent))?;
        if let Some(plot) = fitness_plot(sweep, extent) {
            write_figure(directory, &format!("fitness_{name}"), &plot)?;
        }
        if let Some(plot) = pareto_plot(sweep, extent) {
            write_figure(directory, &format!("pareto_{name}"), &plot)?;
        }
    }
    let verdicts = fitness_verdicts(sweep);
    let table = SweepTable { sweep };
    write_table(directory, "sweep", &table)?;
    let mut printed = terminal().text(&table);
    if !verdicts.is_empty() {
        let mut rows = CsvRowWriter::new(directory.begin_file("cell_fitness.csv")?)?;
        verdicts.iter().try_for_each(|it| rows.write(it))?;
        rows.finish()?;
        let table = FitnessTable { verdicts: &verdicts };
        write_table(directory, "cell_fitness", &table)?;
        printed.push('\n');
        printed.push_str(&terminal().text(&table));
    }
    // The answer last.
    printed.push_str(&terminal().sentences(best_of(sweep)));
    Ok(printed)
}
