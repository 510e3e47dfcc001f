//! A box of a label file, in the coordinates of its scan's file.

use detector::OrientedBox;
use reports::vocabulary::class::AnnotationClass;
use serde::{Deserialize, Serialize};

use crate::annotation::Annotation;
use crate::dataset::python_json::{number, numbers};

/// All sides are shorter, in metres.
const LONGEST_SIDE_M: f32 = 1e4;
/// All positions on a map, in metres, and all headings are smaller.
const FARTHEST: f64 = 1e9;

/// A box in a file; a list of these in JSON is our own format.
///
/// ```json
/// [{"class": "car", "center_m": [10.2, -3.1, -0.9], "length_width_height_m": [4.1, 1.8, 1.5], "yaw_rad": 0.1, "track": 7}]
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListedBox {
    /// The name of its class.
    pub class: String,
    /// Its centre in metres; on a map, with more digits than single precision holds.
    #[serde(deserialize_with = "numbers")]
    pub center_m: [f64; 3],
    /// Its sides in metres.
    #[serde(deserialize_with = "numbers")]
    pub length_width_height_m: [f32; 3],
    /// Its heading in radians, counter-clockwise from x.
    #[serde(deserialize_with = "number")]
    pub yaw_rad: f32,
    /// Number of the object within its drive.
    #[serde(default)]
    pub track: Option<u32>,
}

impl ListedBox {
    /// The box as an annotation of `class` without points, relative to `origin_m`. Errors are the rest of a sentence about
    /// the object.
    pub fn annotation(&self, class: AnnotationClass, origin_m: [f64; 3]) -> Result<Annotation, String> {
        for (name, side_m) in ["length", "width", "height"].into_iter().zip(self.length_width_height_m) {
            if !(side_m > 0.0 && side_m < LONGEST_SIDE_M) {
                return Err(format!(
                    "whose {name} is {side_m} m: it must be above 0 and below {LONGEST_SIDE_M}"
                ));
            }
        }
        let numbers = ["x", "y", "z"].into_iter().zip(self.center_m);
        for (name, value) in numbers.chain([("yaw", f64::from(self.yaw_rad))]) {
            if value.is_nan() || value.abs() >= FARTHEST {
                return Err(format!(
                    "whose {name} is {value}: it must be between -{FARTHEST:e} and {FARTHEST:e}"
                ));
            }
        }
        let center_m = std::array::from_fn(|axis| (self.center_m[axis] - origin_m[axis]) as f32);
        Ok(Annotation {
            bounding_box: Some(OrientedBox {
                center_m,
                length_width_height_m: self.length_width_height_m,
                yaw_rad: self.yaw_rad,
            }),
            track: self.track,
            ..Annotation::of(class)
        })
    }
}
