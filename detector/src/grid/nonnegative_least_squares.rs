//! Least squares whose unknowns must not be negative.

use nalgebra::{DMatrix, DVector};

/// The x ≥ 0 with the least ‖a x − b‖, by the active-set method of Lawson and Hanson (1974, chapter 23).
///
/// `a` has at least as many rows as columns, and `b` as many entries as `a` has rows. Columns that do not help, and
/// those that depend on others, get 0.
pub fn nonnegative_least_squares(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let n = a.ncols();
    let (gram, projected) = (a.tr_mul(a), a.tr_mul(b));
    let tolerance = 1e-11 * projected.amax().max(f64::MIN_POSITIVE);
    let mut x = DVector::zeros(n);
    let mut free: Vec<usize> = Vec::new();
    // Columns that were tried and depend on the free ones.
    let mut dependent = vec![false; n];
    // Each round lowers the residual, so that no set of free columns comes twice; rounding alone could break this.
    for _ in 0..10 * n {
        let descent = &projected - &gram * &x;
        let candidates = (0..n).filter(|column| !free.contains(column) && !dependent[*column]);
        let steepest = candidates.max_by(|&p, &q| descent[p].total_cmp(&descent[q]).then(q.cmp(&p)));
        let Some(column) = steepest.filter(|&column| descent[column] > tolerance) else { break };
        free.push(column);
        let Some(mut solved) = solve_free(&gram, &projected, &free) else {
            free.pop();
            dependent[column] = true;
            continue;
        };
        while solved.iter().any(|&it| it <= 0.0) {
            // As far towards the solution as all unknowns stay at or above 0.
            let steps = free.iter().zip(solved.iter()).filter(|(_, it)| **it <= 0.0);
            let share = steps.map(|(&column, &it)| x[column] / (x[column] - it)).fold(1.0, f64::min);
            for (&column, &it) in free.iter().zip(solved.iter()) {
                x[column] += share * (it - x[column]);
            }
            let least = free.iter().copied().min_by(|&p, &q| x[p].total_cmp(&x[q]));
            free.retain(|&column| Some(column) != least && x[column] > 0.0);
            (0..n).filter(|column| !free.contains(column)).for_each(|column| x[column] = 0.0);
            let Some(again) = solve_free(&gram, &projected, &free) else { return x };
            solved = again;
        }
        for (&column, &it) in free.iter().zip(solved.iter()) {
            x[column] = it;
        }
    }
    x
}

/// The unconstrained solution with the `free` columns alone; `None` if they depend on each other.
fn solve_free(gram: &DMatrix<f64>, projected: &DVector<f64>, free: &[usize]) -> Option<DVector<f64>> {
    let gram = gram.select_rows(free).select_columns(free);
    let factored = gram.cholesky()?;
    // Cholesky of a singular matrix may get through on rounding errors.
    let pivots = factored.l_dirty().diagonal();
    (pivots.is_empty() || pivots.min() > 1e-7 * pivots.max())
        .then(|| factored.solve(&projected.select_rows(free)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn check(rows: &[[f64; 2]], b: &[f64], expected: [f64; 2]) {
        let a = DMatrix::from_row_iterator(rows.len(), 2, rows.iter().flatten().copied());
        let x = nonnegative_least_squares(&a, &DVector::from_row_slice(b));
        assert!((x[0] - expected[0]).abs() < 1e-12 && (x[1] - expected[1]).abs() < 1e-12, "{x}");
    }

    #[test]
    fn what_is_positive_anyway_is_the_plain_solution() {
        check(&[[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]], &[3.0, 4.0, 5.0], [3.0, 2.0]);
    }

    #[test]
    fn what_would_be_negative_is_zero_and_the_other_makes_the_best_of_it() {
        // Without the constraint (2, -1); with it the first column alone: 3 / 2... its mean over both rows.
        check(&[[1.0, 0.0], [1.0, 1.0]], &[2.0, 1.0], [1.5, 0.0]);
        check(&[[1.0, 0.0], [0.0, 1.0]], &[-1.0, -2.0], [0.0, 0.0]);
    }

    #[test]
    fn of_equal_columns_one_does_the_work() {
        check(&[[1.0, 1.0], [2.0, 2.0]], &[1.0, 2.0], [1.0, 0.0]);
    }

    proptest! {
        /// Karush-Kuhn-Tucker: at 0 going up does not help, above 0 neither direction does.
        #[test]
        fn no_small_change_makes_it_better(entries in prop::collection::vec(-3.0..3.0_f64, 36), b in prop::collection::vec(-3.0..3.0_f64, 9)) {
            let a = DMatrix::from_row_slice(9, 4, &entries);
            let b = DVector::from_vec(b);
            let x = nonnegative_least_squares(&a, &b);
            let descent = a.tr_mul(&(&b - &a * &x));
            for column in 0..4 {
                prop_assert!(x[column] >= 0.0);
                prop_assert!(descent[column] < 1e-6);
                prop_assert!(x[column] == 0.0 || descent[column] > -1e-6);
            }
        }
    }
}
