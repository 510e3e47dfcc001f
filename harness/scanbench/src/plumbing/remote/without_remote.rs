//! Stand-ins for fetching in a program that was built without the feature `remote`: they only fail.

use std::path::{Path, PathBuf};

use super::{GetPlan, Got};
use crate::plumbing::failure::{Failure, Usage};

/// Nothing is fetched.
pub fn fetched(address: &str, _: &Path) -> Result<PathBuf, Failure> {
    Err(refused(&format!("{:?} cannot be fetched", address.split('?').next().unwrap_or_default())))
}

/// Nothing is fetched.
pub fn get(plan: &GetPlan<'_>) -> Result<Got, Failure> {
    Err(refused(&format!("{:?} cannot be fetched into {:?}", plan.id, plan.into)))
}

fn refused(problem: &str) -> Failure {
    Usage(format!(
        "{problem}: this program was built without the feature remote, which cargo build --release --features remote \
         builds in"
    ))
    .into()
}
