//! Names that files give to data sets, drives and sensors: fit to be printed, and none twice.
//!
//! They stand in terminals, tables, paths and pages, so control characters in them are damage. What comes from a file and is only
//! quoted in an error is escaped there.

use std::collections::BTreeSet;
use std::path::Path;

use super::{Dataset, DatasetError};

/// Makes sure that every scan of `dataset` has a name of its own, and that no name holds control characters.
///
/// # Errors
///
/// [`DatasetError::Damaged`] with the first name that is not so.
pub fn check_names(dataset: &dyn Dataset) -> Result<(), DatasetError> {
    let description = dataset.description();
    let path = description.root.clone().unwrap_or_else(|| Path::new(&description.id).to_path_buf());
    let damaged = |problem: String| DatasetError::Damaged { path: path.clone(), problem };
    let names = [("a name", &description.id), ("a sensor", &description.sensor)];
    let licence = description.licence.iter().map(|it| ("a licence", it));
    for (what, name) in names.into_iter().chain(licence) {
        check_printable(what, name).map_err(damaged)?;
    }
    let (mut drives, mut scans) = (BTreeSet::new(), BTreeSet::new());
    for id in dataset.scan_ids() {
        if drives.insert(&id.sequence) {
            check_printable("a drive", &id.sequence).map_err(damaged)?;
        }
        if !scans.insert(id) {
            return Err(damaged(format!("has two scans of the name {id}")));
        }
    }
    Ok(())
}

fn check_printable(what: &str, name: &str) -> Result<(), String> {
    if name.chars().any(char::is_control) {
        return Err(format!("has {what} with control characters: {name:?}"));
    }
    Ok(())
}
