//! `scanbench partial`.

pub mod sets;
pub mod growths;
pub mod files;
pub mod experiment;
pub mod object_event;
pub mod whole_partial;
pub mod shared_objects;

use std::path::Path;

use reports::vocabulary::study::Study;

use crate::cli::PartialArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::shards::executor::execute;
use crate::plumbing::shards::work_output::WorkOutput;
use crate::plumbing::standard_streams::print_result_in;
use crate::verbs::partial::shared_objects::SharedObjects;
use crate::verbs::partial::whole_partial::WholePartial;

/// Has methods classify objects of which a part has been seen, and writes rows, tables, figures, a page and a recording; or
/// makes a shard of that.
pub fn partial(arguments: &PartialArgs) -> Result<(), Failure> {
    let output = WorkOutput::claim(Study::Partial, arguments.shard.shard, &arguments.output)?;
    let mut objects = SharedObjects::open(arguments, &output)?;
    let Some(made) = execute(&mut objects, output)? else { return Ok(()) };
    let (finished, whole) = made.finish()?;
    print_partial(whole, &finished)
}

/// Prints the table of the result in `finished`.
pub fn print_partial(whole: WholePartial, finished: &Path) -> Result<(), Failure> {
    print_result_in("Partial", finished, whole.printed)
}
