//! `objects.csv` and `importance.csv`: rows that a trained model was judged by.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;

/// Place and kind of an object of [`JudgedObjects`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JudgedObjectFacts<'a> {
    /// Data set.
    pub data: &'a str,
    /// Drive.
    pub sequence: &'a str,
    /// Its kind.
    pub kind: &'a str,
    /// Whether it is a vehicle.
    pub is_vehicle: bool,
    /// Number of its points.
    pub n_points: usize,
    /// Distance of the middle of its box from the sensor on the ground plan, in metres.
    pub range_m: f64,
}

/// The rows of held-out objects: place, decision value, and the values that it was made of.
#[derive(Debug)]
pub struct JudgedObjects {
    writer: csv::Writer<Vec<u8>>,
}

/// The columns before those of the values of a model.
const OBJECT_COLUMNS: [&str; 7] =
    ["data", "sequence", "kind", "is_vehicle", "n_points", "range_m", "decision"];

impl JudgedObjects {
    /// Begins without rows; the values have columns of these names.
    ///
    /// # Errors
    ///
    /// None, since the rows are written to memory.
    pub fn new(features: &[&str]) -> Result<Self, csv::Error> {
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        writer.write_record(OBJECT_COLUMNS.iter().chain(features))?;
        Ok(Self { writer })
    }

    /// Appends the object of `facts` with its decision value and the values behind it, in the order of the columns.
    ///
    /// # Errors
    ///
    /// If a number is not finite, or there are more or fewer values than columns.
    pub fn write(
        &mut self,
        facts: JudgedObjectFacts<'_>,
        decision: f32,
        features: &[f32],
    ) -> Result<(), csv::Error> {
        let JudgedObjectFacts { data, sequence, kind, is_vehicle, n_points, range_m } = facts;
        let values: Vec<Fixed<4>> = features.iter().map(|&it| Fixed(it.into())).collect();
        let decision = Fixed::<5>(decision.into());
        self.writer.serialize((
            data,
            sequence,
            kind,
            is_vehicle,
            n_points,
            Fixed::<2>(range_m),
            decision,
            values,
        ))
    }

    /// The content of `objects.csv`.
    pub fn into_csv(self) -> Vec<u8> {
        self.writer.into_inner().expect("memory takes all that is written")
    }
}

row! {
    /// What one value is worth to a model.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct ImportanceRow {
        feature: String,
        roc_area_loss: Option<Fixed<5>>,
        n_objects: usize,
    }
}

impl ImportanceRow {
    /// The row of a value: mixed up between `n_objects`, it lowers the area under the receiver operating characteristic by
    /// `roc_area_loss`.
    pub fn new(feature: &str, roc_area_loss: Option<f64>, n_objects: usize) -> Self {
        Self { feature: feature.to_owned(), roc_area_loss: roc_area_loss.map(Fixed), n_objects }
    }
}

row! {
    /// Whether what a forest expects comes about: a row of `calibration.csv`, for held-out groups of which much the same was
    /// expected.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct CalibrationRow {
        what: String,
        expected: Fixed<4>,
        observed: Fixed<4>,
        n_groups: usize,
    }
}

impl CalibrationRow {
    /// The row of `n_groups` groups, with the means of their expected and their observed value. `what` is `iou`, the
    /// intersection over union with an object, or `vehicle`, the probability of one.
    pub fn new(what: &str, [expected, observed]: [f64; 2], n_groups: usize) -> Self {
        Self { what: what.to_owned(), expected: Fixed(expected), observed: Fixed(observed), n_groups }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_columns_of_their_model() {
        let facts = JudgedObjectFacts {
            data: "street",
            sequence: "narrow-1",
            kind: "car",
            is_vehicle: true,
            n_points: 25,
            range_m: 12.345,
        };
        let mut rows = JudgedObjects::new(&["a", "b"]).unwrap();
        rows.write(facts, -0.5, &[1.0, 2.25]).unwrap();
        assert!(rows.write(facts, 0.0, &[1.0]).is_err() && rows.write(facts, 0.0, &[1.0, f32::NAN]).is_err());
        let mut rows = JudgedObjects::new(&["a", "b"]).unwrap();
        rows.write(facts, -0.5, &[1.0, 2.25]).unwrap();
        let expected = "data,sequence,kind,is_vehicle,n_points,range_m,decision,a,b\nstreet,narrow-1,car,true,25,12.35,-0.50000,1.0000,2.2500\n";
        assert_eq!(String::from_utf8(rows.into_csv()).unwrap(), expected);
    }
}
