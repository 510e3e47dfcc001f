//! Which drives are trained on, and which are kept to judge by.

use std::collections::BTreeSet;

use crate::dataset::Dataset;

/// The drives of several data sets, some of them held out.
///
/// Whole drives are, so that no object is on both sides: a track does not leave its drive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeldOut {
    /// Data set and sequence of each, those trained on first.
    pub trained: BTreeSet<(String, String)>,
    /// Those kept to judge by.
    pub held_out: BTreeSet<(String, String)>,
}

impl HeldOut {
    /// Holds out the last of every `every` drives of each data set, as `datasets` gives them with the scans taken; the last
    /// of all if there are fewer. `None` if no two drives are left to part.
    pub fn every<'a>(
        every: usize,
        datasets: impl Iterator<Item = (&'a dyn Dataset, &'a [usize])>,
    ) -> Option<Self> {
        let mut parted = Self { trained: BTreeSet::new(), held_out: BTreeSet::new() };
        for (dataset, scan_indices) in datasets {
            let id = &dataset.description().id;
            let sequences: BTreeSet<&String> =
                scan_indices.iter().map(|&it| &dataset.scan_ids()[it].sequence).collect();
            for (place, sequence) in sequences.iter().enumerate() {
                let is_held_out = place % every == every - 1;
                let side = if is_held_out { &mut parted.held_out } else { &mut parted.trained };
                side.insert((id.clone(), (*sequence).clone()));
            }
        }
        if parted.held_out.is_empty() {
            parted.held_out.extend(parted.trained.pop_last());
        }
        (!parted.trained.is_empty() && !parted.held_out.is_empty()).then_some(parted)
    }

    /// Whether a drive is held out.
    pub fn is_held_out(&self, dataset: &str, sequence: &str) -> bool {
        self.held_out.contains(&(dataset.to_owned(), sequence.to_owned()))
    }

    /// The names of `drives`, data set by data set.
    pub fn names(drives: &BTreeSet<(String, String)>) -> String {
        let mut names: Vec<String> = Vec::new();
        let mut latest = None;
        for (dataset, sequence) in drives {
            match names.last_mut() {
                Some(name) if latest == Some(dataset) => {
                    name.push(' ');
                    name.push_str(sequence);
                }
                _ => names.push(format!("{dataset}: {sequence}")),
            }
            latest = Some(dataset);
        }
        names.join("; ")
    }
}
