//! Over- and under-segmentation of objects, as TRAVEL and `continuous_clustering` measure it.
//!
//! Unlike the entropies of other tables, these have a term for points of no segment and of no object, use the objects of
//! [`same_label_clusters`](super::same_label_clusters), and are summed over a scan. Sources: Oh et al., *TRAVEL*,
//! 2022, equations for OSE and USE; `evaluateClusters` of `continuous_clustering`.

use reports::rows::label_score_row::SegmentationEntropies;

use super::segment_overlaps::{SegmentOverlaps, SharedPoints, sum_in_order};

/// Entropies of a scan: `objects` has the object of every point and `found` its segment, 0 for none.
pub fn segmentation_entropies(objects: &[u32], found: &[u32]) -> SegmentationEntropies {
    let points = || objects.iter().zip(found);
    let by_object = SegmentOverlaps::of(points().map(|(&object, &segment)| [object, segment]));
    let by_segment = SegmentOverlaps::of(points().map(|(&object, &segment)| [segment, object]));
    let of_objects: Vec<f64> = by_object.by_first().filter(|it| it[0].first != 0).map(entropy_nats).collect();
    let holds_an_object = |it: &&[SharedPoints]| it[0].first != 0 && it.iter().any(|it| it.second != 0);
    let of_segments: Vec<f64> = by_segment.by_first().filter(holds_an_object).map(entropy_nats).collect();
    SegmentationEntropies {
        n_objects: of_objects.len() as u64,
        over_nats: sum_in_order(of_objects),
        n_segments: of_segments.len() as u64,
        under_nats: sum_in_order(of_segments),
    }
}

/// −Σ p ln p of the shares p of `parts` in all their points.
fn entropy_nats(parts: &[SharedPoints]) -> f64 {
    let n_all: u64 = parts.iter().map(|it| it.n_points).sum();
    // Not minus the product: a share of 1 would give a negative zero.
    let term =
        |it: &SharedPoints| it.n_points as f64 / n_all as f64 * (n_all as f64 / it.n_points as f64).ln();
    sum_in_order(parts.iter().map(term).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Letters are objects and segments, dots are none.
    fn entropies(objects: &str, found: &str) -> SegmentationEntropies {
        assert_eq!(objects.len(), found.len());
        let numbers = |drawing: &str| -> Vec<u32> {
            drawing.chars().map(|it| if it == '.' { 0 } else { u32::from(it) }).collect()
        };
        segmentation_entropies(&numbers(objects), &numbers(found))
    }

    /// Compares numbers of objects and segments, and entropies as multiples of ln 2.
    #[track_caller]
    fn check(objects: &str, found: &str, counts: [u64; 2], bits: [f64; 2]) {
        let it = entropies(objects, found);
        assert_eq!([it.n_objects, it.n_segments], counts, "{objects}\n{found}");
        let found_bits = [it.over_nats, it.under_nats].map(|nats| nats / std::f64::consts::LN_2);
        assert!(
            found_bits.iter().zip(bits).all(|(a, b)| (a - b).abs() < 1e-12),
            "{found_bits:?}\n{objects}\n{found}"
        );
    }

    #[test]
    fn what_is_found_whole_has_none() {
        check("aabb..", "xxyy..", [2, 2], [0.0, 0.0]);
        check("", "", [0, 0], [0.0, 0.0]);
    }

    #[test]
    fn points_of_no_segment_and_of_no_object_are_a_share_of_their_own() {
        check("aaaa", "xx..", [1, 1], [1.0, 0.0]);
        check("aa..", "xxxx", [1, 1], [0.0, 1.0]);
    }

    #[test]
    fn what_nobody_found_and_what_holds_no_object_say_nothing() {
        check("aa..", "..xx", [1, 0], [0.0, 0.0]);
    }

    #[test]
    fn four_quarters_are_two_bits() {
        check("aaaabb", "wxyzvv", [2, 5], [2.0, 0.0]);
        check("abcdee", "xxxxyy", [5, 2], [0.0, 2.0]);
    }

    proptest! {
        #[test]
        fn neither_order_nor_numbers_count(
            points in prop::collection::vec((0_u32..5, 0_u32..5), 0..60),
            numbers in Just((1_u32..5).collect::<Vec<_>>()).prop_shuffle(),
        ) {
            let (objects, found): (Vec<u32>, Vec<u32>) = points.iter().copied().unzip();
            let renumbered = |it: u32| if it == 0 { 0 } else { 7 * numbers[it as usize - 1] };
            let (others, refound): (Vec<u32>, Vec<u32>) =
                points.iter().rev().map(|&(a, b)| (renumbered(a), renumbered(b))).unzip();
            prop_assert_eq!(segmentation_entropies(&others, &refound), segmentation_entropies(&objects, &found));
            let fed_back = segmentation_entropies(&objects, &objects);
            prop_assert_eq!([fed_back.over_nats, fed_back.under_nats], [0.0, 0.0]);
        }
    }
}
