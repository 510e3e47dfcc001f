//! Text at the end of a run, made in one piece or put together.

use std::path::Path;

use reports::tables::formats::format::Format as _;
use reports::tables::run_in_short::RunInShort;
use reports::tables::times_table::TimesTable;

use crate::plumbing::failure::Failure;
use crate::plumbing::shards::whole_run::WholeRun;
use crate::plumbing::standard_streams::{Verbosity, is_said, print_result, print_result_in, terminal};

/// Prints the result of `run`, which has been written to `finished`; with `--verbose` all its tables before that.
pub fn print_ending(run: &WholeRun, finished: &Path) -> Result<(), Failure> {
    let (facts, short) = (&run.facts, run.facts.in_short());
    let mut printed = Ok(());
    if is_said(Verbosity::Verbose) {
        let times = TimesTable::new(&facts.report, &facts.manifest);
        let tables = short.tables.iter().map(|it| terminal().text(it));
        let texts = tables.chain(run.more.iter().cloned()).chain([terminal().text(&times)]);
        printed = { texts }.try_for_each(print_result);
    }
    print_result_in("Run directory", finished, in_short(&short)).and(printed)
}

/// Tables, and the verdict last.
pub fn in_short(short: &RunInShort) -> String {
    let verdict = terminal().sentences(short.verdict.iter().cloned());
    format!("{}\n{}", terminal().text(short), verdict.trim_end())
}
