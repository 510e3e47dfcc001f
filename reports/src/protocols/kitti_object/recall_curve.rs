//! Values that are looked up at 41 recalls.

/// Number of recalls: 0, 1/40, …, 1.
pub const N_RECALLS: usize = 41;

/// Best values at each recall or beyond.
#[derive(Debug, Clone, PartialEq)]
pub struct RecallCurve {
    /// Precision; NaN where the makers divide zero by zero.
    pub precision: [f64; N_RECALLS],
    /// Similarity of headings; NaN likewise.
    pub similarity: [f64; N_RECALLS],
}

/// Largest value at each index or after it. NaN stays NaN, and is smaller than every other value.
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
