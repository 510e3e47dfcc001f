//! Files of `scanbench sweep`.

use crate::plumbing::failure::{Failure, NothingEvaluated};
use crate::plumbing::official_evaluation::warning_of_no_ground;
use crate::plumbing::paper_files::{write_figure, write_table};
use crate::plumbing::progress::progress_over_results;
use crate::plumbing::run_manifest::detector_entry;
use crate::plumbing::standard_streams::{Verbosity, is_said, print_diagnostic, terminal};
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::built_in_named;
use evaluation::sweep::drawn_sweep::DrawnSweep;
use evaluation::sweep::sweep_tally::SweepTally;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::CsvRowWriter;
use reports::numbers::sweep_score::{SweepScores, SweepTime};
use reports::plots::fitness_plot::fitness_plot;
use reports::plots::pareto_plot::pareto_plot;
use reports::plots::rate_plot::rate_plot;
use reports::plots::swept_protocol_plot::swept_protocol_plot;
use reports::protocols::swept_numbers::SweptNumbers;
use reports::run_folder::detector_changes::detector_changes;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{
    RunDirectory, SWEEP_BEST_TXT, SWEEP_CSV, SWEEP_PROTOCOLS_CSV, SWEEP_PROTOCOLS_JSON, SWEEP_TIMES_CSV,
    TIMES_OF_PROCESSORS_CSV,
};
use reports::tables::formats::format::Format as _;
use reports::tables::studies::fitness_table::{FitnessTable, fitness_sentences};
use reports::tables::studies::sweep_rates::SweepRates;
use reports::tables::studies::sweep_recommendation::recommendations;
use reports::tables::studies::sweep_table::SweepTable;
use reports::tables::studies::swept_protocol_table::SweptProtocolTable;
use reports::verdicts::fitness_verdict::fitness_verdicts;
use reports::vocabulary::protocol::Protocol;

/// Writes tables and plots into `directory`, and returns the tables as they are printed.
pub fn write_sweep(directory: &RunDirectory, sweep: &SweepScores) -> Result<String, ArchiveError> {
    directory.write_file(SWEEP_CSV, &sweep.to_csv())?;
    if !sweep.times.is_empty() {
        directory.write_file(SWEEP_TIMES_CSV, &sweep.times_to_csv())?;
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
    let rates = SweepRates { sweep };
    let mut printed = format!("{}\n{}", terminal().text(&table), terminal().text(&rates));
    if !verdicts.is_empty() {
        let mut rows = CsvRowWriter::new(directory.begin_file("cell_fitness.csv")?)?;
        verdicts.iter().try_for_each(|it| rows.write(it))?;
        rows.finish()?;
        let table = FitnessTable { verdicts: &verdicts };
        write_table(directory, "cell_fitness", &table)?;
        if is_said(Verbosity::Verbose) {
            printed.push('\n');
            printed.push_str(&terminal().text(&table));
        } else {
            printed.push_str("\nWhat each reading of the cell fitness recommends: cell_fitness.md, or -v.\n");
        }
    }
    Ok(printed)
}

/// Makes the numbers of a sweep under its protocols and writes them into `directory` in all their forms. Returns the table
/// that is printed.
pub fn write_swept_protocols(
    directory: &RunDirectory,
    manifest: &Manifest,
    tally: &SweepTally<'_>,
) -> Result<String, ArchiveError> {
    let n_points = manifest.sweep.as_ref().map_or(0, |it| it.points.len());
    let bar = progress_over_results(n_points, 0, "protocols");
    let swept = tally.protocol_numbers(|| bar.inc(1));
    bar.finish_and_clear();
    if manifest.protocols.contains(&Protocol::Ground) {
        warn_of_no_ground(manifest, &swept);
    }
    directory.write_file(SWEEP_PROTOCOLS_CSV, &swept.to_csv())?;
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

/// Writes the recommendations of the sweep of `manifest` into `directory`, and returns them, one text after the other.
pub fn write_best(
    directory: &RunDirectory,
    manifest: &Manifest,
    drawn: &DrawnSweep<'_>,
    sweep: &SweepScores,
) -> Result<Vec<String>, Failure> {
    let mut texts = recommendations(sweep, &|it| drawn.difference(it), &|it| drawn.held_out(it));
    texts.extend(fitness_sentences(&fitness_verdicts(sweep)));
    let changes = changes_of_shipped(manifest)?;
    if !changes.is_empty() {
        texts.push(format!(
            "At every point, detectors also differ from the shipped ones: {}.",
            changes.join("; ")
        ));
    }
    directory.write_file(SWEEP_BEST_TXT, (texts.join("\n") + "\n").as_bytes())?;
    Ok(texts)
}

/// How the built-in detectors of `manifest` differ from the shipped ones, beside what is swept.
fn changes_of_shipped(manifest: &Manifest) -> Result<Vec<String>, Failure> {
    let shipped = RunConfig::load(None)?;
    let mut changes = Vec::new();
    for entry in manifest.detectors.iter().filter(|it| it.foreign.is_none()) {
        for listed in built_in_named(std::slice::from_ref(&entry.name), &shipped)? {
            let as_shipped = detector_entry(&ComparedDetector::of(listed, &shipped));
            changes.extend(detector_changes(&as_shipped, entry).iter().map(|it| shortened(it)));
        }
    }
    Ok(changes)
}

/// A density curve has dozens of numbers: a long text ends early.
fn shortened(text: &str) -> String {
    const MOST_CHARACTERS: usize = 100;
    let is_long = text.chars().count() > MOST_CHARACTERS;
    if is_long { text.chars().take(MOST_CHARACTERS).chain(['…']).collect() } else { text.to_owned() }
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
    directory.write_file(TIMES_OF_PROCESSORS_CSV, &sweep.times_of_processors_to_csv(unlike))
}

/// Refuses a sweep over scans in which there is nothing to find.
pub fn refuse_nothing(scores: &SweepScores) -> Result<(), NothingEvaluated> {
    if scores.scores.iter().any(|it| it.counts.no() > 0) {
        return Ok(());
    }
    Err(NothingEvaluated { reason: "no scan has an annotation that counts".to_owned() })
}
