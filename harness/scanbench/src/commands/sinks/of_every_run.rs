//! The sinks that every run has.

use evaluation::run::sink::Sinks;
use reports::numbers::tally::Tally;
use reports::run_folder::run_directory::RunDirectory;

use super::csv_files::CsvFiles;
use super::terminal::Terminal;
use super::worst_mistakes::WorstMistakes;
use crate::commands::failure::Failure;
use crate::commands::progress::RunProgress;

/// What is needed to make a directory of a run that is read like any other: sums in `tally`, files in `directory`.
pub fn sinks_of_every_run<'a>(
    directory: &'a RunDirectory,
    tally: &'a mut Tally,
    progress: &RunProgress,
) -> Result<Sinks<'a, Failure>, Failure> {
    Ok(vec![
        Box::new(tally),
        Box::new(CsvFiles::begin(directory)?),
        Box::new(WorstMistakes::new(directory)),
        Box::new(Terminal::new(progress)),
    ])
}
