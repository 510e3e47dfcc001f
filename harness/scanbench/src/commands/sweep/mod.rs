//! `scanbench sweep`.

pub mod identity;
pub mod files;
pub mod protocol_files;
pub mod setup;
pub mod shard;

use std::path::{Path, PathBuf};

use evaluation::journal::{Journal, JournalError, JournalKind, OtherJournal};
use evaluation::sweep::protocol_numbers::SweptOfficially;
use evaluation::sweep::quality_pass::SweepError;
use evaluation::sweep::sweep_tally::SweepTally;
use jiff::Timestamp;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};

use crate::cli::SweepArgs;
use crate::commands::failure::Failure;
use crate::commands::interruption::{interruption_flag, set_last_words};
use crate::commands::open_datasets::{OpenedDataset, ids_of};
use crate::commands::provenance::compact_utc;
use crate::commands::recorder::record_sweep;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::sweep::files::{refuse_nothing, write_sweep, write_times_of_unlike};
use crate::commands::sweep::identity::sweep_identity;
use crate::commands::sweep::protocol_files::write_swept_protocols;
use crate::commands::sweep::setup::{Sweep, SweepResults, sweep_plan};
use crate::commands::sweep::shard::sweep_shard;

/// Runs detectors at every combination of parameter values on the same scans, writes tables and plots, and prints the best; or
/// makes a shard of that.
///
/// What is done is kept beside the directory until that is written, so that the sweep may be ended at any time and goes on
/// when it is asked for again.
pub fn sweep(arguments: &SweepArgs) -> Result<(), Failure> {
    if let Some(shard) = arguments.shard.shard {
        return sweep_shard(arguments, shard);
    }
    let started = Timestamp::now();
    let plan = sweep_plan(arguments)?;
    // Now, and not after the work: it may be that nothing can be written there.
    let named = claim_named(&arguments.output)?;
    let sweep = Sweep::open(arguments, plan)?;
    let unnamed = format!("{}-sweep-{}", compact_utc(started), ids_of(&sweep.datasets));
    let claimed = claim_unnamed(named, &unnamed, LatestPointer::Leave)?;
    let (journal, done) = open_journal(&sweep, claimed.target())?;
    let how_to_go_on = how_to_go_on(claimed.target());
    set_last_words(how_to_go_on.clone());
    let results = sweep.run(&journal, done, interruption_flag()).inspect_err(|error| {
        if matches!(error, SweepError::Interrupted { .. } | SweepError::InterruptedWhileTimed) {
            print_diagnostic(how_to_go_on);
        }
    })?;
    sweep.datasets.iter().for_each(OpenedDataset::warn_of_points_left_out);
    let manifest = sweep.manifest(started);
    let tally = tally(&manifest, results);
    let scores = tally.summary();
    refuse_nothing(&scores)?;
    let directory = RunDirectory::begin(claimed)?;
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    let mut printed = write_sweep(&directory, &scores)?;
    if let Some(protocols) = &sweep.protocols {
        let swept = SweptOfficially { plan: &sweep.plan, datasets: &sweep.swept_datasets(), protocols };
        printed.push_str(&write_swept_protocols(&directory, &swept, &scores)?);
    }
    write_times_of_unlike(&directory, &scores, &tally.times_of_processors())?;
    if !arguments.no_rrd {
        record_sweep(&directory, (&sweep.plan, &sweep.swept_datasets()[0]), &scores)?;
    }
    let finished = directory.finish()?;
    set_last_words(String::new());
    journal.remove()?;
    let printed = print_result(printed);
    // Also where nobody takes the tables: the files are there.
    print_diagnostic(format_args!("Sweep: {}", finished.display()));
    printed
}

fn tally(manifest: &Manifest, results: SweepResults) -> SweepTally<'_> {
    let mut tally = SweepTally::of(manifest).expect("it is that of a sweep");
    results.counted.iter().for_each(|it| tally.add(it));
    results.timed.into_iter().for_each(|it| tally.add_times(it));
    tally
}

fn open_journal(sweep: &Sweep<'_>, target: &Path) -> Result<(Journal, SweepResults), JournalError> {
    let mut path = target.as_os_str().to_owned();
    path.push(".unfinished");
    let path = PathBuf::from(path);
    let overwrites = sweep.arguments.output.overwrite;
    let other = if overwrites { OtherJournal::Discard } else { OtherJournal::Refuse };
    let identity = sweep_identity(sweep.arguments, &sweep.plan, &sweep.datasets);
    let mut done = SweepResults::default();
    let journal = Journal::open(&path, (JournalKind::Sweep, &identity), other, |it| done.add(it))?;
    if done.n() > 0 {
        print_diagnostic(format_args!("Continuing with {} results from {}", done.n(), path.display()));
    }
    Ok((journal, done))
}

fn how_to_go_on(target: &Path) -> String {
    format!("Results are kept: to continue, give the same command with -o {}", target.display())
}
