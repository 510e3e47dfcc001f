//! Scans and labels that do not go together.

use std::fmt;
use std::path::Path;

use super::DatasetError;
use super::shown_name::shown;

/// So many are named; the others are counted.
const N_NAMED: usize = 5;

/// Files of scans and of labels, one for each scan, where one lacks the other.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct UnpairedFiles {
    /// Scans without labels, in order.
    pub scans: Vec<String>,
    /// Labels without a scan, in order.
    pub labels: Vec<String>,
}

impl UnpairedFiles {
    /// Nothing if there are none, else the error that names them; `labels` is the folder of the labels.
    pub fn refuse(&self, labels: &Path) -> Result<(), DatasetError> {
        if self.scans.is_empty() && self.labels.is_empty() {
            return Ok(());
        }
        Err(DatasetError::damaged(
            labels,
            format!(
                "does not go with the scans: {self}; a scan without objects has a label file without any"
            ),
        ))
    }
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

/// The first of `names`, and how many more there are.
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
        assert!(UnpairedFiles::default().refuse(Path::new("labels")).is_ok());
    }
}
