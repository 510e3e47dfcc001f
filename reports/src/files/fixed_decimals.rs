//! Numbers of a fixed number of decimals, so that the same run gives the same bytes.

use serde::{Deserialize, Serialize, Serializer};

/// `value` with `decimals` decimals; a value that rounds to zero has no sign.
pub fn fixed_decimals(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|it| matches!(it, b'0' | b'.')) => digits.to_owned(),
        _ => text,
    }
}

/// A share of 1 in percent with one decimal, such as `12.5`.
pub fn percent(share: f64) -> String {
    fixed_decimals(100.0 * share, 1)
}

/// `value` with `decimals` decimals; a dash where there is none.
pub fn decimals_or_dash(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |it| fixed_decimals(it, decimals))
}

/// A share in percent with one decimal; a dash where there is none.
pub fn percent_or_dash(share: Option<f64>) -> String {
    decimals_or_dash(share.map(|it| 100.0 * it), 1)
}

/// A share in percent with its sign, such as `+12.5`.
pub fn signed_percent(share: f64) -> String {
    format!("{}{}", if share > 0.0 { "+" } else { "" }, percent(share))
}

/// `value` with three significant digits, but with all digits before the decimal point.
pub(crate) fn three_digits(value: f64) -> String {
    let magnitude = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    // Rounding up to the next power of ten gives a digit too many, which is harmless.
    fixed_decimals(value, (2 - magnitude).max(0) as usize)
}

/// A number that is written with `DECIMALS` decimals, and refused if it is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(transparent)]
pub(crate) struct Fixed<const DECIMALS: usize>(pub(crate) f64);

impl<const DECIMALS: usize> Fixed<DECIMALS> {
    /// `value` as it reads back from a file.
    pub(crate) fn rounded(value: f64) -> Self {
        // A value that is no number is refused when it is written.
        Self(fixed_decimals(value, DECIMALS).parse().unwrap_or(value))
    }
}

impl<const DECIMALS: usize> Serialize for Fixed<DECIMALS> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !self.0.is_finite() {
            return Err(serde::ser::Error::custom(format!("{} is not a number that can be written", self.0)));
        }
        serializer.serialize_str(&fixed_decimals(self.0, DECIMALS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(value: f64, decimals: usize, expected: &str) {
        assert_eq!(fixed_decimals(value, decimals), expected);
    }

    #[test]
    fn decimals_are_filled_up() {
        check(3.5, 4, "3.5000");
    }

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        check(-0.0, 2, "0.00");
        check(-0.004, 2, "0.00");
        check(-0.006, 2, "-0.01");
        check(-0.4, 0, "0");
    }

    #[test]
    fn shares_are_percentages_with_a_sign_where_it_is_asked_for() {
        assert_eq!([0.125, -0.5].map(percent), ["12.5", "-50.0"]);
        assert_eq!([0.125, -0.5, 0.0].map(signed_percent), ["+12.5", "-50.0", "0.0"]);
    }

    #[test]
    fn rounding_twice_is_rounding_once() {
        for value in [0.0, -0.000_04, 1.0 / 3.0, 2.5e-5, 1e9 / 7.0, -12.345_678] {
            let once = Fixed::<4>::rounded(value);
            assert_eq!(Fixed::rounded(once.0), once);
            assert_eq!(fixed_decimals(once.0, 4), fixed_decimals(value, 4));
        }
        assert!(Fixed::<4>::rounded(f64::NAN).0.is_nan());
    }

    #[test]
    fn three_digits_count() {
        let values = [0.0, 0.001_234, 0.38, 7.0, 29.04, 121.3, 115_231.0];
        assert_eq!(values.map(three_digits), ["0.00", "0.00123", "0.380", "7.00", "29.0", "121", "115231"]);
    }
}
