//! `poses.csv`: where the sensor was at each scan, where the data set says so.

use serde::{Deserialize, Serialize, Serializer};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;

row! {
    /// Pose of the sensor at one scan, in a frame that rests.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct PoseRow {
        /// Id of the data set.
        pub dataset: String,
        /// The drive the scan belongs to.
        pub sequence: String,
        /// Number of the scan within the drive.
        pub scan: u32,
        /// Position of the sensor in the frame that rests.
        #[serde(serialize_with = "with_four_decimals")]
        pub x_m: f64,
        /// The same.
        #[serde(serialize_with = "with_four_decimals")]
        pub y_m: f64,
        /// The same.
        #[serde(serialize_with = "with_four_decimals")]
        pub z_m: f64,
        /// Turn from the sensor frame to the frame that rests, as a unit quaternion.
        #[serde(serialize_with = "with_nine_decimals")]
        pub qx: f64,
        /// The same.
        #[serde(serialize_with = "with_nine_decimals")]
        pub qy: f64,
        /// The same.
        #[serde(serialize_with = "with_nine_decimals")]
        pub qz: f64,
        /// The same.
        #[serde(serialize_with = "with_nine_decimals")]
        pub qw: f64,
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn with_four_decimals<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Fixed::<4>(*value).serialize(serializer)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn with_nine_decimals<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Fixed::<9>(*value).serialize(serializer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};

    #[test]
    fn rows_read_back_as_they_were() {
        let [dataset, sequence] = ["city", "0000"].map(str::to_owned);
        let (x_m, y_m, z_m) = (6_378_137.25, -0.5, 1.73);
        let row = PoseRow { dataset, sequence, scan: 7, x_m, y_m, z_m, qx: 0.0, qy: 0.0, qz: 0.6, qw: 0.8 };
        let text = csv_text(std::slice::from_ref(&row));
        insta::assert_snapshot!(text, @r"
        dataset,sequence,scan,x_m,y_m,z_m,qx,qy,qz,qw
        city,0000,7,6378137.2500,-0.5000,1.7300,0.000000000,0.000000000,0.600000000,0.800000000
        ");
        assert_eq!(rows_of::<PoseRow>(&text).unwrap(), [row]);
    }
}
