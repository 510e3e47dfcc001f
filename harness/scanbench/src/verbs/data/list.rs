//! `scanbench data list`.

use reports::files::causes::with_causes;
use scans::dataset::class_table::whatever_classes;
use simulator::open::{OpenOptions, open_dataset};

use crate::cli::CatalogueArgs;
use crate::plumbing::config::classes_of_project;
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::open_catalogue;
use crate::plumbing::standard_streams::{print_result, result_width};

/// Prints every data set of the catalogue, and for each whether it is there and how many scans it has.
pub fn data_list(arguments: &CatalogueArgs) -> Result<(), Failure> {
    // A catalogue may name classes of the user.
    classes_of_project()?;
    let catalogue = open_catalogue(arguments.catalogue.as_deref())?;
    let names = catalogue.groups.keys().chain(catalogue.ids());
    let width = names.map(String::len).max().unwrap_or(0);
    for (group, members) in &catalogue.groups {
        print_entry(group, width, &format!("all of {}", members.join(", ")))?;
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
                print_entry(id, width, &format!("{n_scans} scans, {}{simulated}", description.format))?;
            }
            Err(error) => {
                print_entry(id, width, &format!("not available: {}", with_causes(&error)))?;
            }
        }
    }
    Ok(())
}

/// Prints `text` about `name`, folded beside the column of names, which is `width` wide.
fn print_entry(name: &str, width: usize, text: &str) -> Result<(), Failure> {
    let room = result_width().saturating_sub(width + 2).max(20);
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().expect("there is a first line");
        if last.is_empty() {
            last.push_str(word);
        } else if last.chars().count() + 1 + word.chars().count() <= room {
            last.push(' ');
            last.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    let indent = format!("\n{:1$}", "", width + 2);
    print_result(format_args!("{name:<width$}  {}", lines.join(&indent)))
}
