//! `scanbench sweep`.

pub mod files;
pub mod setup;
pub mod whole_sweep;
pub mod shared_sweep;

use std::path::Path;

use reports::vocabulary::study::Study;

use crate::cli::SweepArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::recorder::record_sweep;
use crate::plumbing::shards::executor::execute;
use crate::plumbing::shards::work_output::WorkOutput;
use crate::plumbing::standard_streams::print_result_in;
use crate::verbs::sweep::setup::{Sweep, sweep_plan};
use crate::verbs::sweep::whole_sweep::WholeSweep;

/// Runs detectors at every combination of parameter values on the same scans, writes tables and plots, and prints the best;
/// or makes a shard of that.
pub fn sweep(arguments: &SweepArgs) -> Result<(), Failure> {
    let plan = sweep_plan(arguments)?;
    // Now, and not after the work: it may be that nothing can be written there.
    let output = WorkOutput::claim(Study::Sweep, arguments.shard.shard, &arguments.output)?;
    let mut sweep = Sweep::open(arguments, plan, output.started)?;
    let Some(made) = execute(&mut sweep, output)? else { return Ok(()) };
    if !arguments.no_rrd {
        record_sweep(&made.directory, &sweep.plan, &sweep.swept_datasets()[0], &made.whole.scores)?;
    }
    let (finished, whole) = made.finish()?;
    print_sweep(whole, &finished)
}

/// Prints the tables of the sweep in `finished`.
pub fn print_sweep(sweep: WholeSweep, finished: &Path) -> Result<(), Failure> {
    print_result_in("Sweep", finished, sweep.printed)
}
