//! Folders that must not hold files of others.

use std::io::ErrorKind;
use std::path::Path;

use crate::plumbing::failure::{Failure, Usage};

/// Refuses a folder that exists and is not empty.
pub fn refuse_occupied(folder: &Path) -> Result<(), Failure> {
    let occupied = match std::fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_some(),
        Err(error) if error.kind() == ErrorKind::NotFound => false,
        Err(error) => return Err(Failure::usage(format!("cannot write {folder:?}"), error)),
    };
    if occupied {
        return Err(Usage(format!("{folder:?} is not empty; name a new folder")).into());
    }
    Ok(())
}
