//! Numbers for the objects of a drive, where a format has no more than 16 bits for them.

use std::collections::{BTreeMap, BTreeSet};

use reports::vocabulary::class::AnnotationClass;

/// The most objects that a drive can have.
pub const MAX_INSTANCES: u32 = u16::MAX as u32;

/// Numbers from 1 for the objects of one drive, in the order in which they are met.
#[derive(Debug, Clone, Default)]
pub struct InstanceNumbers {
    of_track: BTreeMap<(AnnotationClass, u32), u16>,
    n_given: u32,
    in_scan: BTreeSet<u16>,
}

impl InstanceNumbers {
    /// Begins the next scan of the drive.
    pub fn begin_scan(&mut self) {
        self.in_scan.clear();
    }

    /// The number of an object of the scan: that of its class and track in earlier scans, else one that no other object has.
    /// An object without a track gets a new number in each scan, and so does the second object of one track in a scan.
    ///
    /// # Errors
    ///
    /// The number of objects so far, if it exceeds [`MAX_INSTANCES`].
    pub fn number_of(&mut self, class: AnnotationClass, track: Option<u32>) -> Result<u16, u32> {
        let known = track.and_then(|track| self.of_track.get(&(class, track)).copied());
        if let Some(number) = known
            && self.in_scan.insert(number)
        {
            return Ok(number);
        }
        self.n_given = self.n_given.saturating_add(1);
        let number = u16::try_from(self.n_given).map_err(|_| self.n_given)?;
        self.in_scan.insert(number);
        if let (Some(track), None) = (track, known) {
            self.of_track.insert((class, track), number);
        }
        Ok(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_track_keeps_its_number_and_nothing_else_gets_it() {
        let mut numbers = InstanceNumbers::default();
        let (car, van) = (AnnotationClass::Car, AnnotationClass::Van);
        numbers.begin_scan();
        let first = [(car, Some(7)), (van, Some(7)), (car, None), (car, Some(7)), (car, Some(7 | 1 << 16))];
        assert_eq!(first.map(|(class, track)| numbers.number_of(class, track).unwrap()), [1, 2, 3, 4, 5]);
        numbers.begin_scan();
        let second = [(car, None), (car, Some(7 | 1 << 16)), (van, Some(7)), (car, Some(7))];
        assert_eq!(second.map(|(class, track)| numbers.number_of(class, track).unwrap()), [6, 5, 2, 1]);
    }

    #[test]
    fn more_than_16_bits_hold_are_refused_with_their_number() {
        let mut numbers = InstanceNumbers::default();
        for expected in 1..=u16::MAX {
            assert_eq!(numbers.number_of(AnnotationClass::Car, None), Ok(expected));
        }
        assert_eq!(numbers.number_of(AnnotationClass::Car, None), Err(65_536));
    }

    proptest! {
        #[test]
        fn two_objects_never_share_a_number(
            scans in prop::collection::vec(
                prop::collection::vec((0_usize..3, prop::option::of(0_u32..4)), 0..8), 0..6),
        ) {
            let mut numbers = InstanceNumbers::default();
            let mut owner: BTreeMap<u16, (AnnotationClass, Option<u32>)> = BTreeMap::new();
            for scan in scans {
                numbers.begin_scan();
                let mut in_scan = BTreeSet::new();
                for (class, track) in scan {
                    let class = AnnotationClass::ALL[class];
                    let number = numbers.number_of(class, track).unwrap();
                    prop_assert!(in_scan.insert(number), "twice in one scan");
                    let owned_by = *owner.entry(number).or_insert((class, track));
                    prop_assert_eq!(owned_by, (class, track));
                }
            }
        }
    }
}
