//! What is looked up at 41 recalls.

/// Number of recalls: 0, 1/40, …, 1.
pub const N_RECALLS: usize = 41;

/// The best values at each recall or beyond.
#[derive(Debug, Clone, PartialEq)]
pub struct RecallCurve {
    /// Precision; NaN where the makers divide zero by zero.
    pub precision: [f64; N_RECALLS],
    /// The same of the similarity of headings.
    pub similarity: [f64; N_RECALLS],
}

/// The largest value at each index or after it. What is no number stays none, and is smaller than every other.
pub fn best_from_here(values: &[f64; N_RECALLS]) -> [f64; N_RECALLS] {
    let (mut best, mut largest) = (*values, f64::NEG_INFINITY);
    for value in best.iter_mut().rev() {
        largest = largest.max(*value);
        if !value.is_nan() {
            *value = largest;
        }
    }
    best
}
