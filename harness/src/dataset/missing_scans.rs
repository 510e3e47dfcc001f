//! Labels of scans that are not there.

use std::collections::BTreeSet;

use crate::annotation::ScanId;

/// What [`Dataset::labels_without_scans`](super::Dataset::labels_without_scans) says of labels of the scans called `missing`.
pub fn labels_of_missing(mut missing: impl Iterator<Item = String>) -> Option<String> {
    let first = missing.next()?;
    let n = 1 + missing.count();
    let scans = if n == 1 { "scan that is" } else { "scans that are" };
    Some(format!("labels of {n} {scans} not there, such as {first:?}"))
}

/// The same for labels by drive and number: those without a scan among `scan_ids`.
pub fn labels_beside<'a>(
    scan_ids: &[ScanId],
    labeled: impl Iterator<Item = (&'a String, &'a u32)>,
) -> Option<String> {
    let scans: BTreeSet<&ScanId> = scan_ids.iter().collect();
    let labeled = labeled.map(|(name, index)| ScanId { sequence: name.clone(), index: *index });
    labels_of_missing(labeled.filter(|it| !scans.contains(it)).map(|it| it.to_string()))
}
