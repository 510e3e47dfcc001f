//! `scanbench data list`.

use reports::files::causes::with_causes;
use scans::dataset::class_table::whatever_classes;
use simulator::open::{OpenOptions, open_dataset};

use crate::cli::CatalogueArgs;
use crate::commands::failure::Failure;
use crate::commands::open_datasets::open_catalogue;
use crate::commands::standard_streams::print_result;

/// Prints every data set of the catalogue, and for each whether it is there and how many scans it has.
///
/// # Errors
///
/// If the catalogue cannot be read, or stdout takes nothing.
pub fn data_list(arguments: &CatalogueArgs) -> Result<(), Failure> {
    let catalogue = open_catalogue(arguments.catalogue.as_deref())?;
    let names = catalogue.groups.keys().chain(catalogue.ids());
    let width = names.map(String::len).max().unwrap_or(0);
    for (group, members) in &catalogue.groups {
        print_result(format_args!("{group:<width$}  all of {}", members.join(", ")))?;
    }
    for id in catalogue.ids() {
        match open_dataset(
            id,
            &OpenOptions { classes: whatever_classes(), ..OpenOptions::default() },
            &catalogue,
        ) {
            Ok(dataset) => {
                let description = dataset.description();
                let n_scans = dataset.scan_ids().len();
                let simulated = if description.is_simulated() { ", simulated" } else { "" };
                print_result(format_args!(
                    "{id:<width$}  {n_scans} scans  {}{simulated}",
                    description.format
                ))?;
            }
            Err(error) => {
                let reason = with_causes(&error);
                print_result(format_args!("{id:<width$}  not available: {reason}"))?;
            }
        }
    }
    Ok(())
}
