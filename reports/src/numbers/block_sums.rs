//! Sums by blocks of scans, in as little memory as possible.
//!
//! Whether whole drives or seconds are drawn is known only after all scans. Until a data set has enough drives, sums of
//! seconds serve for both; from then on sums of drives do, however long the drives are.

use std::collections::BTreeMap;

use crate::numbers::blocks::{Blocks, DriveSecond};
use crate::numbers::sums::Sums;

/// The sums of each block.
#[derive(Debug, Clone)]
pub(crate) enum BlockSums {
    /// Sums of seconds.
    OfSeconds(BTreeMap<DriveSecond, Sums>),
    /// Sums of drives, by their names.
    OfDrives(BTreeMap<String, DriveSums>),
}

/// Sums of a drive. Each second is summed first, as in [`BlockSums::OfSeconds`], so that the total has the same digits.
#[derive(Debug, Clone)]
pub(crate) struct DriveSums {
    of_earlier: Sums,
    second: DriveSecond,
    of_second: Sums,
}

impl DriveSums {
    fn begin(second: DriveSecond) -> Self {
        Self { of_earlier: Sums::default(), second, of_second: Sums::default() }
    }

    fn of(&mut self, second: &DriveSecond) -> &mut Sums {
        if self.second != *second {
            self.of_earlier.add_times(&self.of_second, 1.0);
            self.of_second = Sums::default();
            self.second.clone_from(second);
        }
        &mut self.of_second
    }

    fn total(&self) -> Sums {
        let mut total = self.of_earlier;
        total.add_times(&self.of_second, 1.0);
        total
    }
}

impl BlockSums {
    /// No sums yet.
    pub(crate) fn new(has_enough_drives: bool) -> Self {
        if has_enough_drives { Self::OfDrives(BTreeMap::new()) } else { Self::OfSeconds(BTreeMap::new()) }
    }

    /// The sums of the block of `second`, to be added to. Seconds of a drive should come one after the other.
    pub(crate) fn of(&mut self, second: &DriveSecond) -> &mut Sums {
        match self {
            Self::OfSeconds(sums) => {
                if !sums.contains_key(second) {
                    sums.insert(second.clone(), Sums::default());
                }
                sums.get_mut(second).expect("it is there now")
            }
            Self::OfDrives(sums) => {
                if !sums.contains_key(second.drive()) {
                    sums.insert(second.drive().to_owned(), DriveSums::begin(second.clone()));
                }
                sums.get_mut(second.drive()).expect("it is there now").of(second)
            }
        }
    }

    /// Keeps sums of whole drives only, from now on.
    pub(crate) fn forget_seconds(&mut self) {
        let Self::OfSeconds(of_seconds) = self else { return };
        let mut of_drives = Self::new(true);
        for (second, sums) in std::mem::take(of_seconds) {
            *of_drives.of(&second) = sums;
        }
        *self = of_drives;
    }

    /// The sums with the indices of their blocks, in order; blocks without sums are left out.
    pub(crate) fn placed(&self, blocks: &Blocks) -> Vec<(usize, Sums)> {
        let mut placed: BTreeMap<usize, Sums> = BTreeMap::new();
        let mut add = |second: &DriveSecond, sums: &Sums| {
            if let Some(index) = blocks.index_of(second) {
                placed.entry(index).or_default().add_times(sums, 1.0);
            }
        };
        match self {
            Self::OfSeconds(sums) => sums.iter().for_each(|(second, sums)| add(second, sums)),
            Self::OfDrives(sums) => sums.values().for_each(|it| add(&it.second, &it.total())),
        }
        placed.into_iter().collect()
    }

    /// The sums of all blocks together.
    pub(crate) fn total(&self) -> Sums {
        let mut total = Sums::default();
        match self {
            Self::OfSeconds(sums) => sums.values().for_each(|it| total.add_times(it, 1.0)),
            Self::OfDrives(sums) => sums.values().for_each(|it| total.add_times(&it.total(), 1.0)),
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::formula::Term;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn drives_have_the_same_digits_whenever_their_seconds_are_forgotten(
            values in prop::collection::vec(prop::collection::vec((0_u32..4, 0.0_f64..1.0), 1..12), 10..14),
            forgotten_after in 0_usize..200,
        ) {
            let scans = values.iter().enumerate().flat_map(|(drive, values)| {
                let mut seconds: Vec<u32> = values.iter().map(|it| it.0).collect();
                seconds.sort_unstable();
                let of_scan = move |(second, value)| (DriveSecond::of(&format!("{drive:02}"), f64::from(second)), value);
                seconds.into_iter().zip(values.iter().map(|it| it.1)).map(of_scan).collect::<Vec<_>>()
            });
            let scans: Vec<(DriveSecond, f64)> = scans.collect();
            let blocks = Blocks::of(scans.iter().map(|it| it.0.clone()));
            let (mut kept, mut forgotten) = (BlockSums::new(false), BlockSums::new(false));
            for (scan_idx, (second, value)) in scans.iter().enumerate() {
                if scan_idx == forgotten_after {
                    forgotten.forget_seconds();
                }
                for sums in [&mut kept, &mut forgotten] {
                    sums.of(second).add(Term::OverEntropy, *value);
                }
            }
            forgotten.forget_seconds();
            prop_assert_eq!(kept.placed(&blocks), forgotten.placed(&blocks));
            prop_assert_eq!(forgotten.placed(&blocks).len(), blocks.len());
        }
    }
}
