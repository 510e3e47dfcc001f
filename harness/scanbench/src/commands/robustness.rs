//! `scanbench robustness`.

use evaluation::run::robustness::{CONDITIONS, Robustness};
use reports::condition_row::ConditionRow;
use reports::condition_scores::ConditionScores;
use reports::csv_rows::CsvRowWriter;
use reports::run_directory::{MANIFEST_JSON, RunDirectory};
use reports::table::robustness_table::{robustness_to_markdown, robustness_to_terminal};
use simulator::StreetKind;

use crate::cli::RobustnessArgs;
use crate::commands::experiment::Experiment;
use crate::commands::failure::Failure;
use crate::commands::interruption::interruption_flag;
use crate::commands::progress::progress_over_scans;
use crate::commands::standard_streams::{print_diagnostic, print_result};

/// All there are, the method first.
const DETECTORS: [&str; 4] = ["hierarchical", "kd-tree", "pca", "simple-grid"];

/// Runs detectors on simulated streets under one condition after another, and writes and prints the table.
///
/// # Errors
///
/// If anything asked for is not there, or the output cannot be written; nothing is left behind then.
pub fn robustness(arguments: &RobustnessArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let asked = Experiment::begin(&arguments.detectors, &DETECTORS)?;
    let directory = asked.begin_directory(&arguments.output, "robustness")?;
    let robustness = Robustness {
        detectors: &asked.detectors,
        config: &asked.config,
        n_scans: arguments.scans,
        seed: asked.seed,
    };
    let progress = progress_over_scans(CONDITIONS.len() * robustness.n_scans_per_condition(), "");
    let mut conditions = Vec::new();
    for condition in CONDITIONS {
        progress.set_message(format!("{}: {}", condition.group, condition.name));
        conditions.push(robustness.run(condition, interrupted, || progress.inc(1))?);
    }
    progress.finish_and_clear();
    let drives = CONDITIONS.iter().map(|it| {
        let drives = StreetKind::ALL.map(|street| it.drive(street, asked.seed, arguments.scans));
        serde_json::json!({ "group": it.group, "condition": it.name, "drives": drives })
    });
    let details: Vec<_> = drives.collect();
    directory.write_file(MANIFEST_JSON, asked.manifest(details.into()).to_json().as_bytes())?;
    let notes = notes(arguments, &robustness);
    write_tables(&directory, &conditions, &notes)?;
    let finished = directory.finish()?;
    let printed = print_result(robustness_to_terminal(&conditions, &notes));
    // Also where nobody takes the table: it is there.
    print_diagnostic(format_args!("Tables: {}", finished.display()));
    printed
}

fn notes(arguments: &RobustnessArgs, robustness: &Robustness<'_>) -> Vec<String> {
    vec![
        format!(
            "NO: annotations that count. obj, veh: tasks objects and vehicles. {} scans per condition, {} of each kind of \
             street, the same streets under all conditions (seeds from {}).",
            robustness.n_scans_per_condition(),
            arguments.scans,
            robustness.seed
        ),
        "Each condition changes one thing of the standard. Road gradients are random, except under road. Detectors know the sensor and \
         its height; nothing else is adapted."
            .to_owned(),
    ]
}

fn write_tables(
    directory: &RunDirectory,
    conditions: &[ConditionScores],
    notes: &[String],
) -> Result<(), Failure> {
    let mut rows = CsvRowWriter::new(directory.begin_file("robustness.csv")?)?;
    for row in conditions.iter().flat_map(ConditionRow::simulated) {
        rows.write(&row)?;
    }
    rows.finish()?;
    directory.write_file("robustness.md", robustness_to_markdown(conditions, notes).as_bytes())?;
    Ok(())
}
