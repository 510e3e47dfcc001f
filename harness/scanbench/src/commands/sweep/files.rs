//! What `scanbench sweep` leaves behind.

use crate::commands::failure::NothingEvaluated;
use crate::commands::paper_files::{write_figure, write_table};
use crate::commands::standard_streams::terminal;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::CsvRowWriter;
use reports::numbers::sweep_score::{SweepScores, SweepTime};
use reports::plots::fitness_plot::fitness_plot;
use reports::plots::pareto_plot::pareto_plot;
use reports::plots::rate_plot::rate_plot;
use reports::run_folder::run_directory::{RunDirectory, SWEEP_CSV, SWEEP_TIMES_CSV, TIMES_OF_PROCESSORS_CSV};
use reports::tables::formats::format::Format as _;
use reports::tables::studies::fitness_table::FitnessTable;
use reports::tables::studies::sweep_table::{SweepTable, best_of};
use reports::verdicts::fitness_verdict::fitness_verdicts;

/// Writes tables and plots into `directory`, and returns what is to be printed.
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

/// Writes the times of `unlike` processors, each by itself; nothing if there are none.
pub fn write_times_of_unlike(
    directory: &RunDirectory,
    sweep: &SweepScores,
    unlike: &[(String, Vec<SweepTime>)],
) -> Result<(), ArchiveError> {
    if unlike.is_empty() {
        return Ok(());
    }
    let path = directory.path_of(TIMES_OF_PROCESSORS_CSV);
    let rows = sweep.times_of_processors_to_csv(unlike);
    let rows = rows.map_err(|source| ArchiveError::Csv { path, source })?;
    directory.write_file(TIMES_OF_PROCESSORS_CSV, &rows)
}

/// A sweep over scans in which there is nothing to find.
pub fn refuse_nothing(scores: &SweepScores) -> Result<(), NothingEvaluated> {
    if scores.scores.iter().any(|it| it.counts.no() > 0) {
        return Ok(());
    }
    Err(NothingEvaluated { reason: "no scan has an annotation that counts".to_owned() })
}
