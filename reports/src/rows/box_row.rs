//! The boxes that a detector found in one scan, one row each.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::rows::match_outcome::DetectionFacts;
use crate::vocabulary::class::DetectionClass;

row! {
    /// One detection with its box, in the sensor frame.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct BoxRow {
        id: u64,
        class: DetectionClass,
        score: Option<Fixed<6>>,
        center_m: [Fixed<4>; 3] = ["center_x_m", "center_y_m", "center_z_m"],
        length_width_height_m: [Fixed<4>; 3] = ["length_m", "width_m", "height_m"],
        yaw_rad: Fixed<4>,
        n_points: u64,
        box_score: Option<Fixed<6>>,
        seen_sides: Option<String>,
        front_sure: Option<bool>,
        unlikely: Option<bool>,
    }
}

/// Details of a box other than its place and size; all are empty for a box around the seen points alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BoxDetailFacts {
    /// How sure the detector is of it, higher is surer.
    pub score: Option<f32>,
    /// The seen sides, of `front`, `rear`, `left` and `right`; an empty list if none is seen.
    pub seen_sides: Option<Vec<&'static str>>,
    /// Whether it is sure which end is the front.
    pub front_sure: Option<bool>,
}

impl BoxRow {
    /// The row of a detection. Its id is the number of its cluster in files, from 1.
    pub fn new(detection: &DetectionFacts, details: &BoxDetailFacts) -> Self {
        let fixed = |value: f32| Fixed(value.into());
        let bounding_box = &detection.bounding_box;
        Self {
            id: detection.id + 1,
            class: detection.class,
            score: detection.score.map(|score| Fixed(score.into())),
            center_m: bounding_box.center_m.map(fixed),
            length_width_height_m: bounding_box.length_width_height_m.map(fixed),
            yaw_rad: fixed(bounding_box.yaw_rad),
            n_points: detection.n_points,
            box_score: details.score.map(|score| Fixed(score.into())),
            seen_sides: details
                .seen_sides
                .as_ref()
                .map(|it| if it.is_empty() { "none".to_owned() } else { it.join(" ") }),
            front_sure: details.front_sure,
            unlikely: None,
        }
    }

    /// Marks it as an unlikely vehicle: only protocols that rank boxes count it.
    pub fn unlikely(self) -> Self {
        Self { unlikely: Some(true), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::csv_text;
    use crate::rows::match_outcome::{BoxFacts, MotionFacts};

    #[test]
    fn a_row_has_units_and_an_empty_score_where_there_is_none() {
        let bounding_box = BoxFacts {
            center_m: [10.0, -0.00001, -0.85],
            length_width_height_m: [4.2, 1.8, 1.5],
            yaw_rad: 1.25,
        };
        let detection = |id, score| DetectionFacts {
            id,
            class: DetectionClass::Vehicle,
            score,
            n_points: 120,
            bounding_box,
            motion: MotionFacts::default(),
        };
        let sides = |it: &[&'static str]| BoxDetailFacts {
            score: Some(1.25),
            seen_sides: Some(it.to_vec()),
            front_sure: Some(true),
        };
        let rows = [
            BoxRow::new(&detection(0, None), &BoxDetailFacts::default()),
            BoxRow::new(&detection(1, Some(0.5)), &sides(&["rear", "left"])),
            BoxRow::new(&detection(2, Some(0.5)), &sides(&[])),
        ];
        insta::assert_snapshot!(csv_text(&rows), @r"
        id,class,score,center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad,n_points,box_score,seen_sides,front_sure,unlikely
        1,vehicle,,10.0000,0.0000,-0.8500,4.2000,1.8000,1.5000,1.2500,120,,,,
        2,vehicle,0.500000,10.0000,0.0000,-0.8500,4.2000,1.8000,1.5000,1.2500,120,1.250000,rear left,true,
        3,vehicle,0.500000,10.0000,0.0000,-0.8500,4.2000,1.8000,1.5000,1.2500,120,1.250000,none,true,
        ");
    }
}
