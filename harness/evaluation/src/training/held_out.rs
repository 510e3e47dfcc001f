//! Which drives are for training, and which are held out for judging.

use std::collections::BTreeSet;

use scans::dataset::Dataset;

/// The drives of several data sets, some of them held out.
///
/// Whole drives are held out, so that no object is on both sides: a track does not leave its drive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeldOut {
    /// Data set and sequence of each drive for training.
    pub trained: BTreeSet<(String, String)>,
    /// Data set and sequence of each drive for judging.
    pub held_out: BTreeSet<(String, String)>,
}

impl HeldOut {
    /// Holds out the last of every `every` drives of each data set; if no data set has so many, the last drive of all.
    /// `datasets` has the indices of the scans taken of each. `None` if there are fewer than two drives.
    pub fn every<'a>(
        every: usize,
        datasets: impl Iterator<Item = (&'a dyn Dataset, &'a [usize])>,
    ) -> Option<Self> {
        let mut parted = Self { trained: BTreeSet::new(), held_out: BTreeSet::new() };
        for taken in datasets {
            for (index, drive) in drives(std::iter::once(taken)).into_iter().enumerate() {
                let is_held_out = index % every == every - 1;
                let side = if is_held_out { &mut parted.held_out } else { &mut parted.trained };
                side.insert(drive);
            }
        }
        if parted.held_out.is_empty() {
            parted.held_out.extend(parted.trained.pop_last());
        }
        (!parted.trained.is_empty() && !parted.held_out.is_empty()).then_some(parted)
    }

    /// Trains on all drives of some data sets and holds out all drives of others. Each comes with the indices of the scans
    /// taken.
    ///
    /// # Errors
    ///
    /// A drive that is on both sides.
    pub fn apart<'a>(
        trained: impl Iterator<Item = (&'a dyn Dataset, &'a [usize])>,
        held_out: impl Iterator<Item = (&'a dyn Dataset, &'a [usize])>,
    ) -> Result<Self, (String, String)> {
        let parted = Self { trained: drives(trained), held_out: drives(held_out) };
        match parted.trained.intersection(&parted.held_out).next() {
            None => Ok(parted),
            Some(both) => Err(both.clone()),
        }
    }

    /// Whether a drive is held out.
    pub fn is_held_out(&self, dataset: &str, sequence: &str) -> bool {
        self.held_out.contains(&(dataset.to_owned(), sequence.to_owned()))
    }

    /// Number of `drives` of each data set, with the first and the last.
    pub fn summary(drives: &BTreeSet<(String, String)>) -> String {
        let drives: Vec<_> = drives.iter().collect();
        let of_dataset = drives.chunk_by(|a, b| a.0 == b.0).map(|drives| match drives {
            [(dataset, only)] => format!("{dataset}: {only}"),
            [(dataset, first), .., (_, last)] => {
                format!("{dataset}: {} from {first} to {last}", drives.len())
            }
            [] => String::new(),
        });
        of_dataset.collect::<Vec<_>>().join("; ")
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

/// Data set and sequence of every drive of which scans are taken.
fn drives<'a>(datasets: impl Iterator<Item = (&'a dyn Dataset, &'a [usize])>) -> BTreeSet<(String, String)> {
    let of_dataset = |(dataset, scan_indices): (&'a dyn Dataset, &'a [usize])| {
        let id = &dataset.description().id;
        scan_indices.iter().map(move |&it| (id.clone(), dataset.scan_ids()[it].sequence.clone()))
    };
    datasets.flat_map(of_dataset).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_are_counted_and_named_by_their_ends() {
        let drive = |dataset: &str, sequence: &str| (dataset.to_owned(), sequence.to_owned());
        let drives = [drive("b", "0007"), drive("a", "n-3"), drive("a", "n-1"), drive("a", "n-2")].into();
        assert_eq!(HeldOut::summary(&drives), "a: 3 from n-1 to n-3; b: 0007");
        assert_eq!(HeldOut::names(&drives), "a: n-1 n-2 n-3; b: 0007");
        assert_eq!(HeldOut::summary(&BTreeSet::new()), "");
    }
}
