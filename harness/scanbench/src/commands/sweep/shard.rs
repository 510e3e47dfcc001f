//! `scanbench sweep --shard`: some scans of a sweep, at all its points.

use std::path::Path;

use evaluation::sweep::timed_scan::TimedScan;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{SWEPT_SCANS_JSONL, TIMED_SCANS_JSONL};
use reports::run_folder::shard_record::{ProcessorRows, ShardRecord};
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;

use crate::cli::SweepArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::interruption::interruption_flag;
use crate::commands::open_datasets::{OpenedDataset, ids_of};
use crate::commands::shards::checksummed_file::write_lines;
use crate::commands::shards::place::Place;
use crate::commands::shards::share_of_work::take_share;
use crate::commands::shards::unfinished_work::{UnfinishedWork, identity_of};
use crate::commands::sweep::identity::sweep_identity;
use crate::commands::sweep::setup::{Sweep, SweepResults, sweep_plan};

/// Looks at the scans of `shard` at all points, and leaves what was counted and timed in a directory of its own for `merge`.
pub fn sweep_shard(arguments: &SweepArgs, shard: Shard) -> Result<(), Failure> {
    if let Some(protocol) = arguments.protocol.protocols.first() {
        let problem =
            format!("shards of a sweep count without protocols: leave out --protocol {protocol}, or --shard");
        return Err(Usage(problem).into());
    }
    let points = sweep_plan(arguments)?;
    let place = Place::claim(Study::Sweep, Some(shard), &arguments.output)?;
    let mut sweep = Sweep::open(arguments, points)?;
    let share = take_share(&mut sweep.datasets, shard);
    let started = place.started;
    let manifest = Manifest { shard: Some(place.record(share)), ..sweep.manifest(started) };
    let n_scans: usize = sweep.datasets.iter().map(|it| it.part.len()).sum();
    let rules = sweep_identity(arguments, &sweep.plan, &sweep.datasets).into();
    let identity = identity_of(&manifest, rules);
    let mut done = SweepResults::default();
    let (ids, extent) = (ids_of(&sweep.datasets), format!("{n_scans} scans"));
    let unfinished = UnfinishedWork::open(place, &ids, (&identity, extent), |it| done.add(it))?;
    if done.n() > 0 {
        let n_results = n_scans * sweep.plan.points.len();
        unfinished.tell_of_continuing(done.counted.len(), &format!("{n_results} results"));
    }
    let results = sweep.run(&unfinished.journal, done, interruption_flag());
    let results = match results {
        Ok(results) => results,
        Err(error) => return Err(unfinished.ended_by(error.into())),
    };
    sweep.datasets.iter().for_each(OpenedDataset::warn_of_points_left_out);
    // Programs of others have introduced themselves by now.
    let mut manifest = Manifest { shard: manifest.shard, ..sweep.manifest(started) };
    unfinished.finish(|_, _, directory| {
        if let Some(record) = &mut manifest.shard {
            write_results(directory.folder(), &results, record)?;
        }
        Ok(manifest.to_json())
    })
}

fn write_results(folder: &Path, results: &SweepResults, record: &mut ShardRecord) -> Result<(), Failure> {
    record.files = vec![
        write_lines(folder, SWEPT_SCANS_JSONL, &results.counted)?,
        write_lines(folder, TIMED_SCANS_JSONL, &results.timed)?,
    ];
    for TimedScan { processor, .. } in &results.timed {
        if record.processors.last().is_none_or(|it| it.cpu_model != *processor) {
            record.processors.push(ProcessorRows { cpu_model: processor.clone(), n_scan_rows: 0 });
        }
        if let Some(last) = record.processors.last_mut() {
            last.n_scan_rows += 1;
        }
    }
    Ok(())
}
