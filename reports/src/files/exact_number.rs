//! Numbers with as many digits as it takes to read the same number back.

use serde::{Deserialize, Serialize, Serializer};

/// A number that reads back as it was written, and is refused if it is not finite. Zero has no sign.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Exact(pub(crate) f64);

impl Serialize for Exact {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !self.0.is_finite() {
            return Err(serde::ser::Error::custom(format!("{} is not a number that can be written", self.0)));
        }
        serializer.serialize_f64(self.0 + 0.0)
    }
}

impl TryFrom<f64> for Exact {
    type Error = String;

    fn try_from(number: f64) -> Result<Self, String> {
        if number.is_finite() { Ok(Self(number)) } else { Err(format!("{number} is not a finite number")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn written(number: f64) -> String {
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        writer.serialize((Exact(number),)).unwrap();
        String::from_utf8(writer.into_inner().unwrap()).unwrap().trim_end().to_owned()
    }

    #[test]
    fn zero_has_no_sign_and_what_is_not_finite_is_refused() {
        assert_eq!([-0.0, 0.1, -2.5].map(written), ["0.0", "0.1", "-2.5"]);
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        writer.serialize((Exact(f64::NAN),)).unwrap_err();
        assert!(Exact::try_from(f64::INFINITY).is_err());
    }

    proptest! {
        #[test]
        fn every_number_reads_back(number in prop::num::f64::NORMAL) {
            prop_assert_eq!(written(number).parse::<f64>().unwrap(), number);
        }
    }
}
