//! The streets that `scanbench run` judges by, of which nothing else may learn: see `docs/decisions/seeds.md`.

use scans::dataset::DatasetDescription;
use simulator::catalogue::{DEFAULT_DATASETS, built_in_catalogue};
use simulator::simulated_street::StreetDrive;

use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::open_datasets::OpenedDataset;
use crate::plumbing::standard_streams::print_diagnostic;

/// The first data set that starts at the seed of the default run, and the seed.
fn judged(opened: &[OpenedDataset]) -> Result<Option<(&DatasetDescription, u64)>, Failure> {
    let catalogue = built_in_catalogue()?;
    let default = DEFAULT_DATASETS.to_owned();
    let judged = catalogue.members(&default).iter().filter_map(|it| catalogue.simulated.get(it));
    let judged: Vec<u64> = judged.map(|it| it.seed).collect();
    let mut seeds = opened.iter().filter_map(|it| {
        let description = it.dataset.description();
        Some((description, StreetDrive::of(description)?.seed))
    });
    Ok(seeds.find(|(_, seed)| judged.contains(seed)))
}

/// Refuses these streets for training: a model that learned from them could not be judged by them.
pub fn refuse_judged(opened: &[OpenedDataset]) -> Result<(), Failure> {
    let Some((DatasetDescription { id, .. }, seed)) = judged(opened)? else { return Ok(()) };
    let problem = format!(
        "{id} starts at seed {seed}, which is only for judging: nothing may learn from it. Take training-streets, or another --seed"
    );
    Err(Usage(problem).into())
}

/// Notes that these streets are only for judging, in studies by which parameters are chosen.
pub fn advise_on_judged(opened: &[OpenedDataset]) -> Result<(), Failure> {
    if let Some((DatasetDescription { id, .. }, seed)) = judged(opened)? {
        print_diagnostic(format_args!(
            "note: {id} starts at seed {seed}, which is only for judging. To choose a parameter, take --seed 9001"
        ));
    }
    Ok(())
}
