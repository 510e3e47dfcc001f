//! Scans without labels, and labels without a scan.

use std::fmt;
use std::path::Path;

use super::DatasetError;
use super::shown_name::shown;
use super::source::DamagePolicy;

/// This many are named; the others are counted.
const N_NAMED: usize = 5;

/// Files of scans and of labels, one for each scan, that lack their counterpart.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct UnpairedFiles {
    /// Scans without labels, in order.
    pub scans: Vec<String>,
    /// Labels without a scan, in order.
    pub labels: Vec<String>,
}

impl UnpairedFiles {
    /// The files to leave out of a data set: all of these if damage is skipped. `labels` is the folder of the labels.
    ///
    /// # Errors
    ///
    /// If there are any, and damage is not skipped; the error names them.
    pub fn left_out(self, labels: &Path, damage: DamagePolicy) -> Result<Vec<LeftOut>, DatasetError> {
        let are_any = !self.scans.is_empty() || !self.labels.is_empty();
        if are_any && damage == DamagePolicy::Refuse {
            return Err(DatasetError::damaged(
                labels,
                format!(
                    "does not go with the scans: {self}; a scan without objects has a label file without any, and \
                     --skip-damaged leaves out what has no counterpart"
                ),
            ));
        }
        let left_out = |names: Vec<String>, reason: &str| {
            names.into_iter().map(move |name| LeftOut { name, reason: reason.to_owned() }).collect::<Vec<_>>()
        };
        let labels = left_out(self.labels, "is the labels of a scan that is not there");
        Ok([left_out(self.scans, "is a scan without labels"), labels].concat())
    }
}

/// A part of a data set that was left out when it was opened: it is damaged, and damage is skipped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// The name of its file.
    pub name: String,
    /// The problem with it, as the rest of a sentence about it.
    pub reason: String,
}

impl fmt::Display for UnpairedFiles {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let have = |n: usize, kind: &str, lacks: &str| match n {
            1 => format!("1 {kind} has no {lacks}"),
            n => format!("{n} {kind}s have no {lacks}"),
        };
        let kinds = [(&self.scans, "scan", "labels"), (&self.labels, "label file", "scan")];
        let lines = kinds.into_iter().filter(|(names, ..)| !names.is_empty());
        let lines: Vec<String> = lines
            .map(|(names, kind, lacks)| format!("{}: {}", have(names.len(), kind, lacks), few_of(names)))
            .collect();
        formatter.write_str(&lines.join("; "))
    }
}

/// The first of `names`, and the number of the others.
pub fn few_of(names: &[String]) -> String {
    let named: Vec<_> = names.iter().take(N_NAMED).map(|it| shown(it)).collect();
    match names.len().saturating_sub(N_NAMED) {
        0 => named.join(", "),
        n_more => format!("{} and {n_more} more", named.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_are_named_and_all_are_counted() {
        let names = |n: u32| (0..n).map(|it| it.to_string()).collect::<Vec<_>>();
        let said = |scans, labels| UnpairedFiles { scans: names(scans), labels: names(labels) }.to_string();
        assert_eq!(said(1, 0), "1 scan has no labels: 0");
        assert_eq!(said(0, 2), "2 label files have no scan: 0, 1");
        assert_eq!(
            said(5, 7),
            "5 scans have no labels: 0, 1, 2, 3, 4; 7 label files have no scan: 0, 1, 2, 3, 4 and 2 more"
        );
        for damage in [DamagePolicy::Refuse, DamagePolicy::Skip] {
            assert_eq!(UnpairedFiles::default().left_out(Path::new("labels"), damage).unwrap(), []);
        }
        let unpaired = UnpairedFiles { scans: names(1), labels: names(2) };
        let skipped = unpaired.left_out(Path::new("labels"), DamagePolicy::Skip).unwrap();
        assert_eq!(skipped.iter().map(|it| it.name.as_str()).collect::<Vec<_>>(), ["0", "0", "1"]);
    }
}
