//! The recalls at which precision is looked up, and how it is looked up between them.

/// Number of recalls: 0, 0.01, …, 1.
pub(super) const N_RECALLS: usize = 101;

/// The recall at `place`, to the bit as `NumPy`'s `linspace` has it: where a recall that was reached lies on it, the last bit decides
/// which precision is taken.
pub(super) fn recall_at(place: usize) -> f64 {
    if place + 1 == N_RECALLS { 1.0 } else { place as f64 * 0.01 }
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
    fn lines_are_straight() {
        assert_eq!(on_line(0.25, [0.0, 1.0], [0.5, 0.0]), 0.5);
        assert_eq!(on_line(0.5, [0.5, 0.3], [0.5, 0.1]), 0.3);
    }
}
