//! Blocks of scans, which are drawn together when the uncertainty of a number is estimated.
//!
//! Scans of one drive show the same street and, close together, the same objects. So whole drives are drawn where a data set
//! has enough of them, else seconds of its drives. Scans without known times are drawn one by one, and nothing may rest on
//! that: they may be neighbours.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::vocabulary::named::named;

/// Number of drives from which on the whole drives of a data set are drawn.
pub const FEWEST_DRIVES: usize = 10;
/// Number of blocks of one data set from which on a conclusion may rest on an interval.
pub const FEWEST_BLOCKS: u64 = 10;

/// Scans of one drive that were taken within one second; without known times a single scan or a named block.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveSecond {
    drive: String,
    part: DrivePart,
}

/// A part of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum DrivePart {
    /// A second of it.
    Second(i64),
    /// The scan with this number: it is unknown which others are near.
    Scan(u32),
    /// The whole drive: a block that was named.
    Whole,
}

impl DriveSecond {
    /// The second of `drive` that holds a scan taken `time_s` after the start of the drive.
    pub fn of(drive: &str, time_s: f64) -> Self {
        // Times are whole milliseconds, and the same before and after they were written with three decimals.
        let second = (time_s * 1000.0).round().div_euclid(1000.0) as i64;
        Self { drive: drive.to_owned(), part: DrivePart::Second(second) }
    }

    /// The second, named block or single scan to which scan number `scan` of `drive` belongs. `block` is its named block
    /// and `time_s` its time, where they are known.
    pub fn of_scan(drive: &str, scan: u32, block: Option<&str>, time_s: Option<f64>) -> Self {
        match (block, time_s) {
            (_, Some(time_s)) => Self::of(block.unwrap_or(drive), time_s),
            (Some(block), None) => Self { drive: block.to_owned(), part: DrivePart::Whole },
            (None, None) => Self { drive: drive.to_owned(), part: DrivePart::Scan(scan) },
        }
    }

    /// The drive.
    pub fn drive(&self) -> &str {
        &self.drive
    }
}

named! {
    /// What is drawn.
    pub enum BlockKind {
        /// Whole drives: an interval says how other drives of the kind would vary.
        Drives = "drives",
        /// Seconds of drives: an interval says how scans of these drives vary, not other drives.
        Seconds = "seconds",
        /// Drives of one data set and seconds of another.
        Both = "drives and seconds",
        /// Single objects, each in all scans that show it, where a number is of objects and drives are too few.
        Tracks = "tracks",
        /// Single objects, each with all parts of it that are seen.
        Objects = "objects",
        /// Blocks that the user has named.
        Named = "named blocks",
        /// Single scans of which nobody knows when they were taken: they may be neighbours, and nothing may rest on an
        /// interval.
        Scans = "scans without times",
    }
}

impl BlockKind {
    /// The kind of this and `other` blocks together.
    pub fn with(self, other: Self) -> Self {
        match (self, other) {
            _ if self == other => self,
            // The doubt stays with any other blocks.
            (Self::Scans, _) | (_, Self::Scans) => Self::Scans,
            _ => Self::Both,
        }
    }
}

/// Number and kind of the blocks that resamples were drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockCount {
    /// Number of blocks.
    pub n_blocks: u64,
    /// One less for each data set; 0 if one of them has a single block, which cannot show how blocks vary.
    pub degrees_of_freedom: u64,
    /// Kind of the blocks.
    pub kind: BlockKind,
}

impl BlockCount {
    /// The blocks of one data set.
    pub fn of_dataset(n_blocks: u64, kind: BlockKind) -> Self {
        Self { n_blocks, degrees_of_freedom: n_blocks.saturating_sub(1), kind }
    }

    /// The blocks of both, where each data set is drawn from by itself.
    pub fn with(self, other: Self) -> Self {
        let is_known = self.degrees_of_freedom > 0 && other.degrees_of_freedom > 0;
        let degrees_of_freedom = self.degrees_of_freedom + other.degrees_of_freedom;
        Self {
            n_blocks: self.n_blocks + other.n_blocks,
            degrees_of_freedom: if is_known { degrees_of_freedom } else { 0 },
            kind: self.kind.with(other.kind),
        }
    }

    /// Caveat of an interval over these blocks; `None` if there is none.
    pub fn caveat(self) -> Option<String> {
        if self.may_be_neighbours() {
            return Some("over scans that may be neighbours".to_owned());
        }
        self.are_too_few().then(|| format!("from only {}", self.counted()))
    }

    /// Caveat of an interval over these blocks, and why it allows no conclusions; `None` if there is none.
    pub fn caveat_of_conclusions(self) -> Option<String> {
        let end = if self.may_be_neighbours() { "no basis" } else { "too few" };
        self.caveat().map(|it| format!("{it}, {end} for conclusions"))
    }

    /// Why no verdict may rest on these, as the beginning of a sentence that ends "to show …"; `None` if one may.
    pub fn shortfall(self) -> Option<String> {
        if self.may_be_neighbours() {
            return Some("scans without known times, which may be neighbours, are not enough".to_owned());
        }
        let verb = if self.n_blocks == 1 { "is" } else { "are" };
        self.are_too_few().then(|| format!("{} {verb} too few", self.counted()))
    }

    /// Number with its noun, such as `7 blocks of scans`.
    pub fn counted(self) -> String {
        let what = match (self.kind, self.n_blocks) {
            (BlockKind::Tracks | BlockKind::Objects, 1) => "object",
            (BlockKind::Tracks | BlockKind::Objects, _) => "objects",
            (_, 1) => "block of scans",
            _ => "blocks of scans",
        };
        format!("{} {what}", self.n_blocks)
    }

    /// Whether no verdict may rest on them.
    pub fn decide_nothing(self) -> bool {
        self.are_too_few() || self.may_be_neighbours()
    }

    /// Whether it is unknown which of the scans are near others.
    pub fn may_be_neighbours(self) -> bool {
        self.kind == BlockKind::Scans
    }

    /// Whether these are too few for conclusions: fewer than [`FEWEST_BLOCKS`] of one data set, or as few degrees of
    /// freedom over several.
    pub fn are_too_few(self) -> bool {
        self.degrees_of_freedom + 1 < FEWEST_BLOCKS
    }
}

/// The blocks of an interval in a row of a file: empty columns where there is none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct BlockColumns {
    n_blocks: Option<u64>,
    kind: Option<BlockKind>,
    decide_nothing: Option<bool>,
}

impl From<Option<BlockCount>> for BlockColumns {
    fn from(blocks: Option<BlockCount>) -> Self {
        Self {
            n_blocks: blocks.map(|it| it.n_blocks),
            kind: blocks.map(|it| it.kind),
            decide_nothing: blocks.map(BlockCount::decide_nothing),
        }
    }
}

/// The 95 % interval of a number.
///
/// ```
/// use reports::numbers::blocks::{BlockCount, BlockKind, Interval};
///
/// let blocks = BlockCount::of_dataset(7, BlockKind::Drives);
/// let interval = Interval { ends: [0.61, 0.74], blocks };
/// assert_eq!(interval.caveat().as_deref(), Some("interval from only 7 blocks of scans"));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower and upper end of the 95 % interval.
    pub ends: [f64; 2],
    /// The blocks that it was estimated from. If these decide nothing, the interval allows no conclusion.
    pub blocks: BlockCount,
}

impl Interval {
    /// Caveat of the interval; `None` if there is none.
    pub fn caveat(&self) -> Option<String> {
        self.blocks.caveat().map(|of_blocks| format!("interval {of_blocks}"))
    }
}

/// The blocks of one data set.
#[derive(Debug, Clone, PartialEq)]
pub struct Blocks {
    index_of_second: BTreeMap<DriveSecond, usize>,
    count: BlockCount,
}

impl Blocks {
    /// The blocks of the scans of these seconds: drives if there are [`FEWEST_DRIVES`] or more, else the seconds.
    /// Blocks that the user has named count as drives here, however few they are.
    ///
    /// Blocks are in the order of drives and times, whatever the order of `seconds`.
    pub fn of(seconds: impl IntoIterator<Item = DriveSecond>) -> Self {
        let seconds: BTreeSet<DriveSecond> = seconds.into_iter().collect();
        let drives: BTreeSet<&str> = seconds.iter().map(|it| it.drive.as_str()).collect();
        let index_of_drive: BTreeMap<&str, usize> = drives.into_iter().zip(0..).collect();
        let n_drives = index_of_drive.len();
        let kind = |part: DrivePart| match part {
            DrivePart::Whole => BlockKind::Named,
            _ if n_drives >= FEWEST_DRIVES => BlockKind::Drives,
            DrivePart::Second(_) => BlockKind::Seconds,
            DrivePart::Scan(_) => BlockKind::Scans,
        };
        let kind =
            seconds.iter().map(|it| kind(it.part)).reduce(BlockKind::with).unwrap_or(BlockKind::Seconds);
        let (indices, n_blocks): (Vec<usize>, _) = if n_drives >= FEWEST_DRIVES {
            (seconds.iter().map(|it| index_of_drive[it.drive.as_str()]).collect(), n_drives)
        } else {
            ((0..seconds.len()).collect(), seconds.len())
        };
        let count = BlockCount::of_dataset(n_blocks as u64, kind);
        Self { index_of_second: seconds.into_iter().zip(indices).collect(), count }
    }

    /// The index from 0 of the block that holds the scans of `second`; `None` if the data set has no such scans.
    pub fn index_of(&self, second: &DriveSecond) -> Option<usize> {
        self.index_of_second.get(second).copied()
    }

    /// Number and kind of the blocks.
    pub fn count(&self) -> BlockCount {
        self.count
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.count.n_blocks as usize
    }

    /// Whether there are no blocks.
    pub fn is_empty(&self) -> bool {
        self.count.n_blocks == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The blocks of scans of `n_drives` drives, `n_scans` each, a tenth of a second apart.
    fn blocks(n_drives: usize, n_scans: u32) -> Blocks {
        let scans = (0..n_drives).flat_map(|drive| (0..n_scans).map(move |scan| (drive, scan)));
        Blocks::of(scans.map(|(drive, scan)| DriveSecond::of(&format!("{drive:02}"), 0.1 * f64::from(scan))))
    }

    #[track_caller]
    fn check(blocks: &Blocks, n_blocks: u64, kind: BlockKind) {
        assert_eq!((blocks.count().n_blocks, blocks.count().kind), (n_blocks, kind));
    }

    #[test]
    fn ten_drives_are_drawn_whole_and_nine_by_the_second() {
        check(&blocks(10, 2), 10, BlockKind::Drives);
        check(&blocks(9, 2), 9, BlockKind::Seconds);
        check(&blocks(9, 11), 18, BlockKind::Seconds);
        check(&blocks(40, 100), 40, BlockKind::Drives);
        check(&blocks(0, 0), 0, BlockKind::Seconds);
    }

    #[test]
    fn seconds_go_by_time_and_not_by_the_number_of_scans() {
        let at = |times_s: &[f64]| Blocks::of(times_s.iter().map(|it| DriveSecond::of("drive", *it)));
        // Two scans a second, and twenty.
        check(&at(&[0.0, 0.5, 1.0, 1.5, 2.0]), 3, BlockKind::Seconds);
        check(&at(&(0..40).map(|it| 0.05 * f64::from(it)).collect::<Vec<_>>()), 2, BlockKind::Seconds);
        // 0.29 × 1000 is less than 290 in binary, 0.999 is less than a second, and times may be before the start.
        check(&at(&[0.29, 0.999]), 1, BlockKind::Seconds);
        check(&at(&[0.999, 1.0]), 2, BlockKind::Seconds);
        check(&at(&[-0.001, 0.0]), 2, BlockKind::Seconds);
    }

    #[test]
    fn blocks_of_several_data_sets_add_up_and_a_single_one_shows_nothing() {
        let of = |n| BlockCount::of_dataset(n, BlockKind::Drives);
        let three = of(10).with(of(10)).with(of(10));
        assert_eq!((three.n_blocks, three.degrees_of_freedom, three.are_too_few()), (30, 27, false));
        let alone = three.with(of(1));
        assert_eq!((alone.n_blocks, alone.degrees_of_freedom, alone.are_too_few()), (31, 0, true));
        assert_eq!(alone.with(of(30)).degrees_of_freedom, 0);
        assert_eq!(of(10).with(BlockCount::of_dataset(4, BlockKind::Seconds)).kind, BlockKind::Both);
        assert_eq!([9, 10].map(|n| of(n).are_too_few()), [true, false]);
        // Ten blocks of five data sets leave five degrees of freedom.
        let five = (1..5).fold(of(2), |sum, _| sum.with(of(2)));
        assert!(five.n_blocks == 10 && five.are_too_few());
    }

    #[test]
    fn scans_without_times_stand_alone_and_decide_nothing() {
        let alone = |n: u32| (0..n).map(|scan| DriveSecond::of_scan("training", scan, None, None));
        let many = Blocks::of(alone(30));
        check(&many, 30, BlockKind::Scans);
        assert!(many.count().decide_nothing() && !many.count().are_too_few());
        assert_eq!(many.count().caveat().as_deref(), Some("over scans that may be neighbours"));
        // They decide nothing with other blocks whose times are known, either.
        assert!(many.count().with(BlockCount::of_dataset(40, BlockKind::Drives)).decide_nothing());
    }

    #[test]
    fn named_blocks_are_drawn_whole_however_few_they_are() {
        let named = |n: u32, n_blocks: u32| {
            let block = move |scan: u32| format!("block {}", scan % n_blocks);
            Blocks::of(
                (0..n).map(move |scan| DriveSecond::of_scan("training", scan, Some(&block(scan)), None)),
            )
        };
        check(&named(30, 4), 4, BlockKind::Named);
        check(&named(30, 12), 12, BlockKind::Named);
        assert_eq!([4, 12].map(|it| named(30, it).count().decide_nothing()), [true, false]);
        // A named block with times is a drive, as that of a raw scan.
        let raw =
            |scan: u32| DriveSecond::of_scan("training", scan, Some("0005"), Some(f64::from(scan) / 10.0));
        check(&Blocks::of((0..25).map(raw)), 3, BlockKind::Seconds);
    }

    proptest! {
        #[test]
        fn every_scan_has_a_block_and_every_block_a_scan(
            scans in prop::collection::vec((0_u8..14, 0_u32..50_000), 1..60),
        ) {
            let second =
                |&(drive, ms): &(u8, u32)| DriveSecond::of(&drive.to_string(), f64::from(ms) / 1000.0);
            let blocks = Blocks::of(scans.iter().map(second));
            let indices: BTreeSet<usize> =
                scans.iter().map(|it| blocks.index_of(&second(it)).unwrap()).collect();
            prop_assert_eq!(indices, (0..blocks.len()).collect::<BTreeSet<_>>());
            // Another order of the scans gives the same blocks.
            prop_assert_eq!(&Blocks::of(scans.iter().rev().map(second)), &blocks);
        }
    }
}
