//! How well each labelled instance was found, whatever its class.
//!
//! The association of an instance g is Σ |p ∩ g| · IoU(p, g) / |g| over all found segments p; the mean over all instances
//! is `S_assoc`. Sources: Nunes et al., *Unsupervised Class-Agnostic Instance Segmentation of 3D LiDAR Data for
//! Autonomous Vehicles*, 2022; Aygün et al., *4D Panoptic LiDAR Segmentation*, 2021; the program of Sautier et al., *UNIT*,
//! 2025.

use reports::rows::label_score_row::InstanceScore;

use super::label_numbers::{class_number, instance_number, is_left_out};
use super::segment_overlaps::{SegmentOverlaps, SharedPoints, sum_in_order};

/// Scores of all instances in `labels`, by label. `found` has the segment of every point, 0 for none.
///
/// Points of left-out classes are in no segment. Points of other classes, ground and walls among them, count as part of the
/// segments that hold them.
pub fn instance_scores(labels: &[u32], found: &[u32]) -> Vec<InstanceScore> {
    let points = labels.iter().zip(found).filter(|(label, _)| !is_left_out(class_number(**label)));
    let overlaps = SegmentOverlaps::of(points.map(|(&label, &segment)| [instance_of(label), segment]));
    overlaps.by_first().filter(|it| it[0].first != NO_INSTANCE).map(|it| score_of(&overlaps, it)).collect()
}

/// The label of points of no instance.
const NO_INSTANCE: u32 = 0;

/// An overlap beyond this is a match: at most one segment overlaps so much with an instance.
const LEAST_IOU: f64 = 0.5;

fn instance_of(label: u32) -> u32 {
    if instance_number(label) == 0 { NO_INSTANCE } else { label }
}

/// Score of the instance that is the first segment of all `pairs`.
fn score_of(overlaps: &SegmentOverlaps, pairs: &[SharedPoints]) -> InstanceScore {
    let label = pairs[0].first;
    let n_points = overlaps.n_of_first[&label];
    let found = || pairs.iter().filter(|it| it.second != 0);
    let terms = found().map(|it| it.n_points as f64 * overlaps.iou(it));
    InstanceScore {
        label,
        n_points,
        association: sum_in_order(terms.collect()) / n_points as f64,
        matched_iou: found().map(|it| overlaps.iou(it)).find(|iou| *iou > LEAST_IOU),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Letters of `labels` are instances of cars, `-` is road, `~` is unlabelled; letters of `found` are segments, `-` is
    /// none.
    fn scores(labels: &str, found: &str) -> Vec<InstanceScore> {
        assert_eq!(labels.len(), found.len());
        let label = |letter: char| match letter {
            '-' => 40,
            '~' => 0,
            letter => 10 + (u32::from(letter) << 16),
        };
        let segment = |letter: char| if letter == '-' { 0 } else { u32::from(letter) };
        let labels: Vec<u32> = labels.chars().map(label).collect();
        instance_scores(&labels, &found.chars().map(segment).collect::<Vec<_>>())
    }

    #[track_caller]
    fn check(labels: &str, found: &str, expected: &[(u64, f64, Option<f64>)]) {
        let scores: Vec<_> =
            scores(labels, found).iter().map(|it| (it.n_points, it.association, it.matched_iou)).collect();
        assert_eq!(scores, expected, "{labels}\n{found}");
    }

    #[test]
    fn what_is_found_whole_has_an_association_of_1() {
        check("aaaa-bb", "xxxx-yy", &[(4, 1.0, Some(1.0)), (2, 1.0, Some(1.0))]);
    }

    #[test]
    fn two_halves_have_an_association_of_a_half_and_are_no_match() {
        check("aaaa", "xxyy", &[(4, 0.5, None)]);
    }

    #[test]
    fn road_in_a_segment_counts_and_unlabelled_points_do_not() {
        check("aaa-", "xxxx", &[(3, 0.75, Some(0.75))]);
        check("aaa~", "xxxx", &[(3, 1.0, Some(1.0))]);
    }

    #[test]
    fn a_segment_that_joins_two_instances_finds_the_larger() {
        check("aaab", "xxxx", &[(3, 0.75, Some(0.75)), (1, 0.25, None)]);
    }

    #[test]
    fn without_instances_or_segments_there_is_nothing_to_find_or_nothing_found() {
        check("--~~", "xxxx", &[]);
        check("", "", &[]);
        check("a", "-", &[(1, 0.0, None)]);
        check("a", "x", &[(1, 1.0, Some(1.0))]);
    }

    #[test]
    fn the_same_number_in_another_class_is_another_instance() {
        let scores = instance_scores(&[10 + (1 << 16), 252 + (1 << 16)], &[5, 5]);
        assert_eq!(scores.iter().map(|it| it.label).collect::<Vec<_>>(), [0x1_000a, 0x1_00fc]);
        assert_eq!(scores.iter().map(|it| it.association).collect::<Vec<_>>(), [0.5, 0.5]);
    }

    fn points() -> impl Strategy<Value = Vec<(u32, u32)>> {
        let class = prop::sample::select(vec![0_u32, 1, 10, 30, 40, 52, 70, 99, 252]);
        let label = (class, 0_u32..4).prop_map(|(class, instance)| class | instance << 16);
        prop::collection::vec((label, 0_u32..6), 0..80)
    }

    proptest! {
        #[test]
        fn neither_the_order_of_points_nor_the_numbers_of_segments_count(
            points in points(),
            seed in any::<u64>(),
            numbers in Just((1_u32..6).collect::<Vec<_>>()).prop_shuffle(),
        ) {
            let split = |points: &[(u32, u32)]| -> (Vec<u32>, Vec<u32>) { points.iter().copied().unzip() };
            let (labels, found) = split(&points);
            let expected = instance_scores(&labels, &found);
            let mut shuffled = points.clone();
            shuffled.sort_by_key(|(label, segment)| (u64::from(*label) << 32 | u64::from(*segment)) ^ seed);
            for point in &mut shuffled {
                point.1 = if point.1 == 0 { 0 } else { 1000 * numbers[point.1 as usize - 1] };
            }
            let (labels, found) = split(&shuffled);
            prop_assert_eq!(instance_scores(&labels, &found), expected);
        }

        #[test]
        fn truth_fed_back_has_the_greatest_score(points in points()) {
            let labels: Vec<u32> = points.into_iter().map(|(label, _)| label).collect();
            let scores = instance_scores(&labels, &labels);
            prop_assert!(scores.iter().all(|it| it.association == 1.0 && it.matched_iou == Some(1.0)));
        }

        #[test]
        fn scores_lie_between_0_and_1(points in points()) {
            let (labels, found): (Vec<u32>, Vec<u32>) = points.into_iter().unzip();
            for it in instance_scores(&labels, &found) {
                prop_assert!((0.0..=1.0 + 1e-12).contains(&it.association), "{it:?}");
            }
        }
    }
}
