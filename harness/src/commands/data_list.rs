//! `scanbench data list`.

use std::io::Write as _;

use crate::cli::CatalogueArgs;
use crate::commands::open_datasets::open_catalogue;
use crate::dataset::open::{OpenOptions, open_dataset};

/// Prints every data set of the catalogue, and for each whether it is there and how many scans it has.
///
/// # Errors
///
/// If the catalogue cannot be read, or stdout takes nothing.
pub fn data_list(arguments: &CatalogueArgs) -> anyhow::Result<()> {
    let catalogue = open_catalogue(arguments.catalogue.as_deref())?;
    let mut stdout = std::io::stdout().lock();
    for id in catalogue.ids() {
        match open_dataset(id, &OpenOptions::default(), &catalogue) {
            Ok(dataset) => {
                let description = dataset.description();
                let n_scans = dataset.scan_ids().len();
                let simulated = if description.simulated { ", simulated" } else { "" };
                writeln!(stdout, "{id:<22} {n_scans:>6} scans  {}{simulated}", description.format)?;
            }
            Err(reason) => writeln!(stdout, "{id:<22} not available: {reason}")?,
        }
    }
    Ok(())
}
