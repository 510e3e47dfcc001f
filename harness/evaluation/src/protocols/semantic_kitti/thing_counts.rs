//! Panoptic quality of things: segments with classes.
//!
//! Kirillov et al., *Panoptic Segmentation*, 2019, as `PanopticEval` of semantic-kitti-api counts it: every label is a
//! segment, also with instance 0, and segments with few points are neither missed nor false.

use reports::rows::label_score_row::ThingCounts;
use reports::vocabulary::thing_class::ThingClass;

use super::label_numbers::{class_number, is_left_out, thing_class};
use super::segment_overlaps::{SegmentOverlaps, sum_in_order};

/// Fewest points of a missed or false segment: the value of the benchmark.
pub const LEAST_POINTS: u64 = 50;

/// An overlap beyond this is a match: at most one segment overlaps so much with another.
const LEAST_IOU: f64 = 0.5;

/// Stands for points of other classes. No thing has this label.
const OTHER: u32 = 0;

/// Counts for each of [`ThingClass::ALL`]. `labels` and `found` have the label of every point; points whose true class is
/// left out are in no segment.
pub fn thing_counts(labels: &[u32], found: &[u32]) -> [ThingCounts; ThingClass::ALL.len()] {
    ThingClass::ALL.map(|class| {
        let of_class =
            |label: u32| if thing_class(class_number(label)) == Some(class) { label } else { OTHER };
        let points = labels.iter().zip(found).filter(|(label, _)| !is_left_out(class_number(**label)));
        let segments = points.map(|(&label, &found)| [of_class(label), of_class(found)]);
        counts_of(&SegmentOverlaps::of(segments.filter(|it| *it != [OTHER; 2])))
    })
}

fn counts_of(overlaps: &SegmentOverlaps) -> ThingCounts {
    let pairs = overlaps.by_first().flatten().filter(|it| it.first != OTHER && it.second != OTHER);
    let matched: Vec<_> = pairs.filter(|it| overlaps.iou(it) > LEAST_IOU).collect();
    let n_large = |sizes: &std::collections::BTreeMap<u32, u64>, is_matched: &dyn Fn(u32) -> bool| {
        let unmatched = sizes.iter().filter(|(segment, _)| **segment != OTHER && !is_matched(**segment));
        unmatched.filter(|(_, n_points)| **n_points >= LEAST_POINTS).count() as u64
    };
    ThingCounts {
        n_matched: matched.len() as u64,
        n_missed: n_large(&overlaps.n_of_first, &|label| matched.iter().any(|it| it.first == label)),
        n_false: n_large(&overlaps.n_of_second, &|label| matched.iter().any(|it| it.second == label)),
        iou_sum: sum_in_order(matched.iter().map(|it| overlaps.iou(it)).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CAR: u32 = 10;
    const MOVING_CAR: u32 = 252;
    const PERSON: u32 = 30;
    const ROAD: u32 = 40;

    /// Runs of points: how many, their true label, and the one that was found.
    fn counts(runs: &[(usize, u32, u32)]) -> [ThingCounts; 8] {
        let points = runs.iter().flat_map(|&(n, label, found)| std::iter::repeat_n((label, found), n));
        let (labels, found): (Vec<u32>, Vec<u32>) = points.unzip();
        thing_counts(&labels, &found)
    }

    fn instance(class: u32, instance: u32) -> u32 {
        class | instance << 16
    }

    #[track_caller]
    fn check(runs: &[(usize, u32, u32)], class: ThingClass, expected: (u64, u64, u64, f64)) {
        let ThingCounts { n_matched, n_missed, n_false, iou_sum } = counts(runs)[class as usize];
        assert_eq!((n_matched, n_missed, n_false, iou_sum), expected, "{runs:?}");
    }

    #[test]
    fn more_than_half_is_a_match_and_half_is_none() {
        let (car, found) = (instance(CAR, 1), instance(CAR, 7));
        check(&[(60, car, found), (20, ROAD, found)], ThingClass::Car, (1, 0, 0, 0.75));
        check(&[(60, car, found), (60, ROAD, found)], ThingClass::Car, (0, 1, 1, 0.0));
    }

    #[test]
    fn few_points_are_neither_missed_nor_false_but_may_match() {
        let (car, found) = (instance(CAR, 1), instance(CAR, 7));
        check(&[(49, car, ROAD), (49, ROAD, found)], ThingClass::Car, (0, 0, 0, 0.0));
        check(&[(50, car, ROAD), (50, ROAD, found)], ThingClass::Car, (0, 1, 1, 0.0));
        check(&[(1, car, found)], ThingClass::Car, (1, 0, 0, 1.0));
    }

    #[test]
    fn a_thing_of_another_class_is_missed_there_and_false_here() {
        let runs = [(80, instance(PERSON, 1), instance(CAR, 1))];
        check(&runs, ThingClass::Person, (0, 1, 0, 0.0));
        check(&runs, ThingClass::Car, (0, 0, 1, 0.0));
    }

    #[test]
    fn what_moves_is_of_the_same_class_and_its_label_another_segment() {
        let runs = [
            (80, instance(MOVING_CAR, 1), instance(CAR, 2)),
            (70, instance(CAR, 1), instance(CAR, 3)),
            (60, CAR, instance(CAR, 4)),
        ];
        check(&runs, ThingClass::Car, (3, 0, 0, 3.0));
    }

    #[test]
    fn unlabelled_points_are_in_no_segment() {
        check(
            &[(60, instance(CAR, 1), instance(CAR, 2)), (999, 0, instance(CAR, 2))],
            ThingClass::Car,
            (1, 0, 0, 1.0),
        );
    }

    proptest! {
        #[test]
        fn truth_fed_back_is_matched_whole(
            runs in prop::collection::vec((1_usize..70, prop::sample::select(vec![0_u32, 10, 30, 40, 252]), 0_u32..3), 0..9),
        ) {
            let same: Vec<(usize, u32, u32)> =
                runs.iter().map(|&(n, class, it)| (n, instance(class, it), instance(class, it))).collect();
            for it in counts(&same) {
                prop_assert_eq!((it.n_missed, it.n_false, it.iou_sum), (0, 0, it.n_matched as f64));
            }
        }
    }
}
