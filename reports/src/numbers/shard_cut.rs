//! The scans of a run that a shard has.
//!
//! Scans stay in the order of the run, and every shard has consecutive ones; so the rows of all shards, one after the other,
//! are those of the run. A block of scans, whether a second or a whole drive, stays together.

use std::ops::Range;

use crate::numbers::blocks::{Blocks, DriveSecond};
use crate::vocabulary::shard::Shard;

/// A scan of the run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScanToCut {
    /// The second of its drive in which it was taken.
    pub second: DriveSecond,
    /// Work of the scan, in any unit that is the same for all scans of the run. 0 counts as 1.
    pub work: u64,
}

/// The scans of `shard`: of each data set of the run, in order, a range of positions among its scans.
///
/// The run is cut where the work before the cut is nearest to the share of the shards before it. A shard is empty where
/// there are fewer positions to cut than shards.
pub fn scans_of_shard(datasets: &[Vec<ScanToCut>], shard: Shard) -> Vec<Range<usize>> {
    let cuts = possible_cuts(datasets);
    let work = cuts.last().map_or(0, |it| it.work_before);
    let cut = |n_shards: u32| {
        let count = u128::from(shard.count());
        let wanted = work * u128::from(n_shards);
        let nearest = cuts.iter().min_by_key(|it| (it.work_before * count).abs_diff(wanted));
        nearest.map_or(0, |it| it.position)
    };
    let [first, end] = [shard.index() - 1, shard.index()].map(cut);
    let mut n_before = 0;
    let part = |scans: &Vec<ScanToCut>| {
        let within = |position: usize| position.clamp(n_before, n_before + scans.len()) - n_before;
        let part = within(first)..within(end);
        n_before += scans.len();
        part
    };
    datasets.iter().map(part).collect()
}

/// A position between two scans of the run, or at an end of it.
struct Cut {
    /// Scans before it.
    position: usize,
    /// Their work.
    work_before: u128,
}

/// All positions that cut no block of scans, in order.
fn possible_cuts(datasets: &[Vec<ScanToCut>]) -> Vec<Cut> {
    let mut cuts = vec![Cut { position: 0, work_before: 0 }];
    let (mut position, mut work_before) = (0, 0);
    for scans in datasets {
        let blocks = Blocks::of(scans.iter().map(|it| it.second.clone()));
        let blocks_of_scans: Vec<Option<usize>> =
            scans.iter().map(|it| blocks.index_of(&it.second)).collect();
        let mut last_scans = vec![0; blocks.len()];
        for (scan_idx, block_idx) in blocks_of_scans.iter().enumerate() {
            if let Some(block_idx) = block_idx {
                last_scans[*block_idx] = scan_idx;
            }
        }
        let mut reach = 0;
        for (scan_idx, (scan, block_idx)) in scans.iter().zip(&blocks_of_scans).enumerate() {
            reach = reach.max(block_idx.map_or(scan_idx, |it| last_scans[it]));
            position += 1;
            work_before += u128::from(scan.work.max(1));
            if reach == scan_idx {
                cuts.push(Cut { position, work_before });
            }
        }
    }
    cuts
}

#[cfg(test)]
mod tests {
    #![expect(clippy::single_range_in_vec_init, reason = "there is one data set")]

    use super::*;
    use proptest::prelude::*;

    /// Scans of these drives and seconds.
    fn scans(of: &[(&str, u32)]) -> Vec<ScanToCut> {
        let scan = |&(drive, second): &(&str, u32)| ScanToCut {
            second: DriveSecond::of(drive, f64::from(second)),
            work: 1,
        };
        of.iter().map(scan).collect()
    }

    fn parts(datasets: &[Vec<ScanToCut>], count: u32) -> Vec<Vec<Range<usize>>> {
        (1..=count).map(|it| scans_of_shard(datasets, Shard::new(it, count).unwrap())).collect()
    }

    #[test]
    fn six_scans_of_three_seconds_make_three_shards_of_two() {
        let drive = scans(&[("a", 0), ("a", 0), ("a", 1), ("a", 1), ("a", 2), ("a", 2)]);
        assert_eq!(parts(std::slice::from_ref(&drive), 3), [[0..2], [2..4], [4..6]]);
        // With more shards than seconds, some are empty.
        let n_scans: Vec<usize> = parts(&[drive], 7).iter().map(|it| it[0].len()).collect();
        assert_eq!((n_scans.iter().sum::<usize>(), n_scans.iter().filter(|it| **it == 0).count()), (6, 4));
    }

    #[test]
    fn heavy_scans_are_a_shard_of_their_own() {
        let mut drive = scans(&[("a", 0), ("a", 1), ("a", 2), ("a", 3)]);
        drive[3].work = 3;
        assert_eq!(parts(&[drive], 2), [[0..3], [3..4]]);
    }

    #[test]
    fn ten_drives_are_never_cut_and_nine_are() {
        let drives: Vec<String> = (0..10).map(|it| format!("{it}")).collect();
        let of = |n: usize| {
            let seconds =
                drives[..n].iter().flat_map(|drive| (0..30).map(move |second| (drive.as_str(), second)));
            scans(&seconds.collect::<Vec<_>>())
        };
        let ends = |n: usize| parts(&[of(n)], 4).iter().map(|it| it[0].end).collect::<Vec<_>>();
        // 2.5 drives are as near to two as to three: the earlier cut is taken.
        assert_eq!(ends(10), [60, 150, 210, 300]);
        assert_eq!(ends(9), [67, 135, 202, 270]);
    }

    #[test]
    fn a_second_that_comes_again_is_not_torn() {
        // Time stamps that do not ascend: second 0 reaches across second 1.
        let drive = scans(&[("a", 0), ("a", 1), ("a", 0), ("a", 2)]);
        assert_eq!(parts(&[drive], 2), [[0..3], [3..4]]);
    }

    #[test]
    fn shards_go_on_from_one_data_set_to_the_next() {
        let long: Vec<(&str, u32)> = (0..6).map(|it| ("a", it)).collect();
        let datasets = [scans(&long), scans(&[("b", 0), ("b", 1)]), Vec::new()];
        assert_eq!(parts(&datasets, 2), [[0..4, 0..0, 0..0], [4..6, 0..2, 0..0]]);
        assert_eq!(parts(&[], 2), [[], []]);
    }

    proptest! {
        #[test]
        fn every_scan_is_in_one_shard_and_no_block_in_two(
            datasets in prop::collection::vec(prop::collection::vec((0_u8..12, 0_u32..9, 0_u64..50), 0..60), 1..4),
            count in 1_u32..20,
        ) {
            let scan = |&(drive, second, work): &(u8, u32, u64)| ScanToCut {
                second: DriveSecond::of(&drive.to_string(), f64::from(second)),
                work,
            };
            let datasets: Vec<Vec<ScanToCut>> =
                datasets.iter().map(|it| it.iter().map(scan).collect()).collect();
            let parts = parts(&datasets, count);
            for (dataset_idx, scans) in datasets.iter().enumerate() {
                let blocks = Blocks::of(scans.iter().map(|it| it.second.clone()));
                let mut shard_of_block = vec![None; blocks.len()];
                let mut n_before = 0;
                for (shard_idx, part) in parts.iter().enumerate() {
                    let part = part[dataset_idx].clone();
                    prop_assert!(part.is_empty() || part.start == n_before);
                    n_before += part.len();
                    for scan in &scans[part] {
                        let block_idx = blocks.index_of(&scan.second).unwrap();
                        prop_assert_eq!(*shard_of_block[block_idx].get_or_insert(shard_idx), shard_idx);
                    }
                }
                prop_assert_eq!(n_before, scans.len());
            }
        }

        #[test]
        fn no_shard_has_more_than_its_share_and_a_block(
            works in prop::collection::vec(1_u64..100, 1..80),
            count in 1_u32..20,
        ) {
            let scan = |(second, work): (u32, &u64)| ScanToCut {
                second: DriveSecond::of("a", f64::from(second)),
                work: *work,
            };
            let drive: Vec<ScanToCut> = (0..).zip(&works).map(scan).collect();
            let total: u64 = works.iter().sum();
            let largest = works.iter().max().copied().unwrap_or(0);
            for part in parts(std::slice::from_ref(&drive), count) {
                let work: u64 = drive[part[0].clone()].iter().map(|it| it.work).sum();
                prop_assert!(work <= total / u64::from(count) + 1 + largest, "{} of {}", work, total);
            }
        }
    }
}
