//! Recalls at which precision is looked up, and interpolation between them.

/// Number of recalls: 0, 0.01, …, 1.
pub(super) const N_RECALLS: usize = 101;

/// Recall at `index`, to the bit as `NumPy`'s `linspace` has it: where a reached recall lies on it, the last bit decides
/// which precision is taken.
pub(super) fn recall_at(index: usize) -> f64 {
    if index + 1 == N_RECALLS { 1.0 } else { index as f64 * 0.01 }
}

/// Number of `n_annotations` to be found for a recall beyond that at `index`; infinity where there is no such index.
/// Quotients decide, so that the result is the same as from comparing recalls.
pub(super) fn n_to_pass(index: usize, n_annotations: f64) -> f64 {
    if index == N_RECALLS {
        return f64::INFINITY;
    }
    let recall = recall_at(index);
    let mut n_found = ((recall * n_annotations).floor() - 1.0).max(0.0);
    while n_found == 0.0 || n_found / n_annotations <= recall {
        n_found += 1.0;
    }
    n_found
}

/// The value at `x` on the straight line from one point to another, as `NumPy`'s `interp` has it.
pub(super) fn on_line(x: f64, [from_x, from_y]: [f64; 2], [to_x, to_y]: [f64; 2]) -> f64 {
    if x == from_x { from_y } else { (to_y - from_y) / (to_x - from_x) * (x - from_x) + from_y }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recalls_are_products_and_end_at_one() {
        assert_eq!([0, 35, 100].map(recall_at), [0.0, 0.350_000_000_000_000_03, 1.0]);
    }

    #[test]
    fn a_recall_is_passed_by_the_least_number_beyond_it() {
        for n_annotations in [1.0, 3.0, 100.0, 200.0, 31_415.0] {
            for index in 0..N_RECALLS {
                let n_found = n_to_pass(index, n_annotations);
                assert!(n_found / n_annotations > recall_at(index), "{index} of {n_annotations}");
                assert!((n_found - 1.0) / n_annotations <= recall_at(index), "{index} of {n_annotations}");
            }
        }
        assert_eq!(n_to_pass(N_RECALLS, 7.0), f64::INFINITY);
    }

    #[test]
    fn lines_are_straight() {
        assert_eq!(on_line(0.25, [0.0, 1.0], [0.5, 0.0]), 0.5);
        assert_eq!(on_line(0.5, [0.5, 0.3], [0.5, 0.1]), 0.3);
    }
}
