//! `scanbench run`.

pub mod setup;
pub mod ending;
mod counted;
mod made;
mod added;

use crate::cli::RunArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::recorder::serve_until_interrupted;
use crate::verbs::run::added::add_to;
use crate::verbs::run::counted::under_valgrind;
use crate::verbs::run::ending::print_ending;
use crate::verbs::run::made::made_run;

/// Runs detectors on labelled scans, writes the run directory and prints the tables; or makes a shard of that.
pub fn run(arguments: &RunArgs) -> Result<(), Failure> {
    under_valgrind(arguments)?;
    if let Some(base) = &arguments.add_to {
        return add_to(base, arguments);
    }
    let Some((finished, run, served)) = made_run(arguments)? else { return Ok(()) };
    print_ending(&run, &finished)?;
    if let Some(served) = served {
        serve_until_interrupted(&*served, interruption_flag());
    }
    Ok(())
}
