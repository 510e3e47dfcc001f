//! The files of labelCloud, an annotation tool, in its format *`centroid_rel`*: angles in radians from -π to π.

use std::f32::consts::PI;

use serde::{Deserialize, Serialize};

use super::listed_box::ListedBox;
use crate::dataset::python_json::{number, number_or_none};

/// A file: the tool's entries about the scan, and the boxes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LabelCloudFile {
    /// The name of the folder of the scan.
    #[serde(default)]
    pub folder: String,
    /// The name of its file.
    #[serde(default)]
    pub filename: String,
    /// Folder and file as one path.
    #[serde(default)]
    pub path: String,
    /// The boxes.
    pub objects: Vec<LabelCloudObject>,
}

/// A box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LabelCloudObject {
    /// The class.
    pub name: String,
    /// Its centre in metres.
    pub centroid: Axes,
    /// Its sides in metres.
    pub dimensions: Dimensions,
    /// Turns about the axes in radians, counter-clockwise; the last is the heading.
    pub rotations: Axes,
    /// How sure the detector is that proposed it; the tool does not keep this.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "number_or_none")]
    pub score: Option<f32>,
}

/// Three numbers. The order counts: the tool takes them by index.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "they are called as they are")]
pub struct Axes {
    #[serde(deserialize_with = "number")]
    pub x: f64,
    #[serde(deserialize_with = "number")]
    pub y: f64,
    #[serde(deserialize_with = "number")]
    pub z: f64,
}

/// Three sides. The order counts here too.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "they are called as they are")]
pub struct Dimensions {
    #[serde(deserialize_with = "number")]
    pub length: f64,
    #[serde(deserialize_with = "number")]
    pub width: f64,
    #[serde(deserialize_with = "number")]
    pub height: f64,
}

impl LabelCloudObject {
    /// The box in labelCloud's form.
    pub fn new(listed: &ListedBox, score: Option<f32>) -> Self {
        let [x, y, z] = listed.center_m;
        let [length, width, height] = listed.length_width_height_m.map(f64::from);
        let yaw_rad = f64::from(wrapped(listed.yaw_rad));
        Self {
            name: listed.class.clone(),
            centroid: Axes { x, y, z },
            dimensions: Dimensions { length, width, height },
            rotations: Axes { x: 0.0, y: 0.0, z: yaw_rad },
            score,
        }
    }

    /// The box in our form, set upright. Errors are the rest of a sentence about the file.
    ///
    /// # Errors
    ///
    /// If the heading is not within -π to π, as in the tool's other formats, which are in degrees.
    pub fn listed(&self) -> Result<ListedBox, String> {
        let Self { name, centroid, dimensions, rotations, .. } = self;
        if rotations.z.abs() > f64::from(PI) + 1e-3 {
            let problem =
                format!("has a rotation of {}: export as centroid_rel from labelCloud", rotations.z);
            return Err(problem);
        }
        Ok(ListedBox {
            class: name.clone(),
            center_m: [centroid.x, centroid.y, centroid.z],
            length_width_height_m: [dimensions.length, dimensions.width, dimensions.height]
                .map(|it| it as f32),
            yaw_rad: rotations.z as f32,
            track: None,
        })
    }
}

/// The angle in -π to π.
pub fn wrapped(angle_rad: f32) -> f32 {
    if angle_rad.abs() <= PI { angle_rad } else { (angle_rad + PI).rem_euclid(2.0 * PI) - PI }
}
