//! What models are trained on, and judged by.

use evaluation::training::held_out::HeldOut;
use scans::dataset::Dataset;
use simulator::simulated_street::StreetDrive;

use crate::cli::{DatasetArgs, SourceArgs, TrainArgs};
use crate::commands::failure::{Failure, NothingEvaluated, Usage};
use crate::commands::open_datasets::OpenedDataset;

/// How the data sets to judge by are opened, if there are any. What is said of the simulator is for those trained on.
pub fn held_out_arguments(arguments: &TrainArgs) -> Option<DatasetArgs> {
    (!arguments.held_out.is_empty()).then(|| DatasetArgs {
        datasets: arguments.held_out.clone(),
        scans: arguments.held_out_scans.clone(),
        source: SourceArgs {
            topic: None,
            annotation_topic: None,
            classes: arguments.data.source.classes.clone(),
            format: arguments.held_out_format.clone(),
            seed: None,
            simulated_scans: None,
            sensor: None,
            sensor_height: None,
            transform: None,
            catalogue: arguments.data.source.catalogue.clone(),
        },
    })
}

/// Which drives are trained on and which are judged by.
///
/// # Errors
///
/// If no two drives are left to part, or one is on both sides.
pub fn parted(
    arguments: &TrainArgs,
    trained: &[OpenedDataset],
    held_out: &[OpenedDataset],
) -> Result<HeldOut, Failure> {
    fn drives(opened: &[OpenedDataset]) -> impl Iterator<Item = (&dyn Dataset, &[usize])> {
        opened.iter().map(|it| (&*it.dataset, it.scan_indices.as_slice()))
    }
    if held_out.is_empty() {
        let every = arguments.hold_out_every as usize;
        return HeldOut::every(every, drives(trained)).ok_or_else(|| {
            let problem = "all scans are of one drive; training and testing need at least two";
            Usage(problem.to_owned()).into()
        });
    }
    HeldOut::apart(drives(trained), drives(held_out)).map_err(|(dataset, sequence)| {
        Usage(format!("the drive {sequence} of {dataset} is both in the training data and in --held-out"))
            .into()
    })
}

/// What a data set is called in files that were made of it.
pub fn name_with_seed(opened: &OpenedDataset) -> String {
    let description = opened.dataset.description();
    match StreetDrive::of(description) {
        Some(drive) => format!("{} (simulated, seeds from {})", description.id, drive.seed),
        None => description.id.clone(),
    }
}

/// There is nothing to train on, for this reason.
pub fn nothing(reason: &dyn std::fmt::Display) -> NothingEvaluated {
    NothingEvaluated { reason: reason.to_string() }
}
