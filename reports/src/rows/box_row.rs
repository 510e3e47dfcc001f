//! The boxes that a detector found in one scan, one row each.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::CsvRow;
use crate::files::fixed_decimals::Fixed;
use crate::rows::match_outcome::DetectionFacts;
use crate::vocabulary::class::DetectionClass;

/// One detection with its box, in the sensor frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoxRow {
    id: u64,
    class: DetectionClass,
    score: Option<Fixed<6>>,
    center_x_m: Fixed<4>,
    center_y_m: Fixed<4>,
    center_z_m: Fixed<4>,
    length_m: Fixed<4>,
    width_m: Fixed<4>,
    height_m: Fixed<4>,
    yaw_rad: Fixed<4>,
    n_points: u64,
}

impl CsvRow for BoxRow {
    const COLUMNS: &'static [&'static str] = &[
        "id",
        "class",
        "score",
        "center_x_m",
        "center_y_m",
        "center_z_m",
        "length_m",
        "width_m",
        "height_m",
        "yaw_rad",
        "n_points",
    ];
}

impl BoxRow {
    /// The row of a detection. Its id is the number of its cluster in files, from 1.
    pub fn new(detection: &DetectionFacts) -> Self {
        let fixed = |value: f32| Fixed(value.into());
        let bounding_box = &detection.bounding_box;
        let [center_x_m, center_y_m, center_z_m] = bounding_box.center_m.map(fixed);
        let [length_m, width_m, height_m] = bounding_box.length_width_height_m.map(fixed);
        Self {
            id: detection.id + 1,
            class: detection.class,
            score: detection.score.map(|score| Fixed(score.into())),
            center_x_m,
            center_y_m,
            center_z_m,
            length_m,
            width_m,
            height_m,
            yaw_rad: fixed(bounding_box.yaw_rad),
            n_points: detection.n_points,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::to_csv_bytes;
    use crate::rows::match_outcome::BoxFacts;

    #[test]
    fn a_row_has_units_and_an_empty_score_where_there_is_none() {
        let bounding_box = BoxFacts {
            center_m: [10.0, -0.00001, -0.85],
            length_width_height_m: [4.2, 1.8, 1.5],
            yaw_rad: 1.25,
        };
        let detection = |id, score| {
            BoxRow::new(&DetectionFacts {
                id,
                class: DetectionClass::Vehicle,
                score,
                n_points: 120,
                bounding_box,
            })
        };
        let bytes = to_csv_bytes(&[detection(0, None), detection(1, Some(0.5))]).unwrap();
        insta::assert_snapshot!(String::from_utf8(bytes).unwrap(), @r"
        id,class,score,center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad,n_points
        1,vehicle,,10.0000,0.0000,-0.8500,4.2000,1.8000,1.5000,1.2500,120
        2,vehicle,0.500000,10.0000,0.0000,-0.8500,4.2000,1.8000,1.5000,1.2500,120
        ");
    }
}
