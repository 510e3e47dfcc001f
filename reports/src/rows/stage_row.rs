//! `stages.csv`: one row for every scan, detector and stage of it.

use serde::{Deserialize, Serialize, Serializer};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;

row! {
    /// How long one stage of a detector took on one scan.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct StageRow {
        /// Id of the data set.
        pub dataset: String,
        /// The drive the scan belongs to.
        pub sequence: String,
        /// Number of the scan within the drive.
        pub scan: u32,
        /// Name of the detector.
        pub detector: String,
        /// Name of the stage.
        pub stage: String,
        /// Its time in milliseconds, of the first repetition.
        #[serde(serialize_with = "with_four_decimals")]
        pub time_ms: f64,
    }
}

impl StageRow {
    /// The row as it is read back from its file: with as many decimals as it is written with.
    pub fn as_written(self) -> Self {
        Self { time_ms: Fixed::<4>::rounded(self.time_ms).0, ..self }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn with_four_decimals<S: Serializer>(time_ms: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Fixed::<4>(*time_ms).serialize(serializer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};
    use crate::files::csv_rows::to_csv_bytes;

    fn row(time_ms: f64) -> StageRow {
        let [dataset, sequence, detector, stage] = ["street", "0000", "pca", "grid"].map(str::to_owned);
        StageRow { dataset, sequence, scan: 7, detector, stage, time_ms }
    }

    #[test]
    fn rows_read_back_as_they_were() {
        let text = csv_text(&[row(0.25), row(12.5)]);
        insta::assert_snapshot!(text, @r"
        dataset,sequence,scan,detector,stage,time_ms
        street,0000,7,pca,grid,0.2500
        street,0000,7,pca,grid,12.5000
        ");
        assert_eq!(rows_of::<StageRow>(&text).unwrap(), [row(0.25), row(12.5)]);
    }

    #[test]
    fn a_time_that_is_not_a_number_is_not_written() {
        to_csv_bytes(&[row(f64::NAN)]).unwrap_err();
    }
}
