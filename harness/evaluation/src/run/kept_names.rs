//! Names that come from outside, kept as long as the program runs.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

static KEPT: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// Most different names that are kept: an endless stream of new ones must not fill the memory.
const MOST_NAMES: usize = 10_000;
/// Stands for all further names.
const ONE_OF_MANY: &str = "other";

/// `name` with a static lifetime; "other" if too many names are kept. Names of built-in detectors, stages and products are
/// part of the program; names of foreign ones are kept here, each once.
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
