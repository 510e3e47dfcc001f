//! `scanbench data check`.

use std::sync::atomic::Ordering;

use evaluation::run::side_by_side::RunError;
use rayon::prelude::*;
use scans::data_check::check_report::{CheckReport, CheckedScan};
use scans::data_check::scan_facts::ScanFacts;
use scans::dataset::source::DamagePolicy;
use scans::dataset::{DatasetError, Nearness};

use crate::cli::CheckArgs;
use crate::plumbing::config::classes_of_project;
use crate::plumbing::failure::Failure;
use crate::plumbing::first_look::check_first_scans;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets_past_damage};
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::standard_streams::print_result;

/// Scans that are read at once: enough for all cores, and few enough to stay small.
const N_AT_ONCE: usize = 16;

/// Reads all scans and prints what they are like and what may be wrong with them.
pub fn data_check(arguments: &CheckArgs) -> Result<(), Failure> {
    let interrupted = interruption_flag();
    let mut first_damage = None;
    for (index, opened) in
        open_datasets_past_damage(&arguments.data, arguments.damage.policy(), &classes_of_project()?)?
            .iter()
            .enumerate()
    {
        if index > 0 {
            print_result("")?;
        }
        let is_interrupted = || interrupted.load(Ordering::Relaxed);
        let (scans, damage) = check(opened, is_interrupted)?;
        let look = check_first_scans(opened);
        let mut description = opened.dataset.description().clone();
        description.sensor = look.sensor.unwrap_or(description.sensor);
        let mut report = CheckReport::of(&description, &scans, &look.suspicions);
        match opened.dataset.columns() {
            Ok(columns) => report.add_columns(columns),
            Err(error) => first_damage = first_damage.or(Some(error)),
        }
        if let Some(labels) = look.labels {
            report.add_label_look(&labels);
        }
        // If only some of the scans are chosen, nothing else is looked at.
        let is_whole = damage.is_none() && opened.scan_indices.len() == opened.dataset.scan_ids().len();
        if is_whole {
            match opened.dataset.oddities() {
                Ok(oddities) => report.add_oddities(oddities),
                Err(error) => first_damage = first_damage.or(Some(error)),
            }
        }
        print_result(report)?;
        first_damage = first_damage.or(damage);
    }
    match first_damage {
        // Unknown names are no damage: they are reported, not skipped.
        Some(error) if arguments.damage.policy() == DamagePolicy::Refuse || error.is_usage_error() => {
            Err(error.into())
        }
        _ => Ok(()),
    }
}

fn check(
    opened: &OpenedDataset,
    is_interrupted: impl Fn() -> bool,
) -> Result<(Vec<CheckedScan>, Option<DatasetError>), Failure> {
    let dataset = &*opened.dataset;
    let n_scans = opened.scan_indices.len();
    let progress = progress_over_scans(n_scans, &dataset.description().id);
    let (mut scans, mut first_damage) = (Vec::with_capacity(n_scans), None);
    for batch in opened.scan_indices.chunks(N_AT_ONCE) {
        if is_interrupted() {
            return Err(RunError::Interrupted { n_done: scans.len(), n_scans }.into());
        }
        let facts: Vec<_> = batch
            .par_iter()
            .map(|&scan_idx| dataset.read_scan(scan_idx).map(|it| ScanFacts::of(&it)))
            .collect();
        for (&scan_idx, facts) in batch.iter().zip(facts) {
            let id = dataset.scan_ids()[scan_idx].clone();
            let picked_from = dataset.scan_block(scan_idx);
            // Scans that were picked out of a drive do not follow one another.
            let time_ns = if picked_from.is_some() { None } else { dataset.scan_time_ns(scan_idx) };
            let is_known = dataset.nearness() != Nearness::Unknown;
            let drive = is_known.then(|| picked_from.unwrap_or(&id.sequence).to_owned());
            let facts = facts.map_err(|error| {
                let why = error.to_string();
                first_damage.get_or_insert(error);
                why
            });
            scans.push(CheckedScan { id, drive, time_ns, facts });
        }
        progress.inc(batch.len() as u64);
    }
    progress.finish_and_clear();
    Ok((scans, first_damage))
}
