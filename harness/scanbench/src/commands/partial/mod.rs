//! `scanbench partial`.

pub mod sets;
pub mod growths;
pub mod files;
pub mod experiment;
pub mod shard;

use evaluation::partial::experiment::{PartialResults, run};
use jiff::Timestamp;
use reports::run_folder::run_directory::PARTIAL_RRD;
use reports::run_folder::run_target::LatestPointer;

use crate::cli::PartialArgs;
use crate::commands::failure::{Failure, NothingEvaluated};
use crate::commands::partial::experiment::{peer_rows, with_experiment};
use crate::commands::partial::files::{end_partial, manifest};
use crate::commands::partial::growths::first_growths;
use crate::commands::partial::sets::{Compared, open_all};
use crate::commands::partial::shard::partial_shard;
use crate::commands::progress::progress_over_results;
use crate::commands::provenance::compact_utc;
use crate::commands::recorder::{record_growths, records_growths};
use crate::commands::run_directory::begin_run_directory;

/// Has methods tell what objects are of which a part has been seen, and writes rows, tables, figures, a page and a recording; or makes
/// a shard of that.
pub fn partial(arguments: &PartialArgs) -> Result<(), Failure> {
    if let Some(shard) = arguments.shard.shard {
        return partial_shard(arguments, shard);
    }
    let started = Timestamp::now();
    let unnamed = format!("{}-partial", compact_utc(started));
    let sets = open_all(arguments)?;
    let directory = begin_run_directory(&arguments.output, &unnamed, LatestPointer::Leave)?;
    let (mut rows, mut growths) = (Vec::new(), Vec::new());
    for set in &sets {
        let results = results(set, arguments)?;
        rows.extend(results.rows);
        if let Some(model) = results.model.filter(|_| records_growths(arguments)) {
            growths.extend(first_growths(arguments, set, &model)?);
        }
    }
    if rows.is_empty() {
        return Err(NothingEvaluated { reason: "no object is of a class that is judged".to_owned() }.into());
    }
    rows.extend(peer_rows(arguments, &rows)?);
    let manifest = manifest(arguments, &sets, started)?;
    if !growths.is_empty() {
        record_growths(&directory.path_of(PARTIAL_RRD), &manifest.title(), &growths)?;
    }
    end_partial(directory, &manifest, &rows)
}

fn results(set: &Compared, arguments: &PartialArgs) -> Result<PartialResults, Failure> {
    with_experiment(set, &set.judged_indices(), arguments, |experiment| {
        let progress = progress_over_results(experiment.n_answers(), 0, &set.judged.description().id);
        let results = run(experiment, || progress.inc(1));
        progress.finish_and_clear();
        Ok(results?)
    })
}
