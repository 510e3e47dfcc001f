//! Names that come from outside, as long as the program lives.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

static KEPT: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// Different names that are kept at most: an endless stream of new ones must not fill the memory.
const MOST_NAMES: usize = 10_000;
/// What the names beyond are called.
const ONE_OF_MANY: &str = "other";

/// The same name. Detectors, stages and products have names that are part of the program; those of others are kept here,
/// each once.
pub fn kept(name: &str) -> &'static str {
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = kept.get(name) {
        return known;
    }
    if kept.len() >= MOST_NAMES {
        return ONE_OF_MANY;
    }
    let leaked: &'static str = Box::leak(name.to_owned().into_boxed_str());
    kept.insert(leaked);
    leaked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_kept_once() {
        assert!(std::ptr::eq(kept("dbscan"), kept(&["db", "scan"].concat())));
        assert_eq!(kept("hdbscan"), "hdbscan");
    }
}
