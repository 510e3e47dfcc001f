//! What is said at the end of a run, made in one piece or put together.

use std::path::Path;

use reports::run_folder::manifest::DatasetEntry;
use reports::tables::formats::format::Format as _;
use reports::verdicts::standing::{Speeds, Standing, speeds, standings};

use crate::commands::failure::Failure;
use crate::commands::shards::whole_run::WholeRun;
use crate::commands::standard_streams::{print_diagnostic, print_result, terminal};

/// Prints tables and verdicts of `run`, which has been written to `finished`.
pub fn print_ending(run: &WholeRun, finished: &Path) -> Result<(), Failure> {
    let WholeRun { manifest, tally, numbers, more, agreement } = run;
    let is_compared = |it: &DatasetEntry| agreement.iter().any(|row| row.dataset == it.id);
    let is_scored = !manifest.datasets.iter().all(is_compared);
    let standings = standings(tally, manifest, &numbers.report);
    let has_labels = |it: &&Standing| {
        let is_compared = |id: &String| agreement.iter().any(|row| row.dataset == *id);
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
    let texts = tables.chain(more.iter().cloned()).chain(last);
    let printed = texts.into_iter().try_for_each(print_result);
    // Also where nobody takes the tables: the run is there.
    print_diagnostic(format_args!("Run directory: {}", finished.display()));
    printed
}
