//! Numbers of a fixed number of decimals, so that the same run gives the same bytes.

use serde::{Deserialize, Serialize, Serializer};

/// `value` with `decimals` decimals; what rounds to zero has no sign.
pub(crate) fn fixed_decimals(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|it| matches!(it, b'0' | b'.')) => digits.to_owned(),
        _ => text,
    }
}

/// A number that is written with `DECIMALS` decimals, and refused if it is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(transparent)]
pub(crate) struct Fixed<const DECIMALS: usize>(pub(crate) f64);

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
}
