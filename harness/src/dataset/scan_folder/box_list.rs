//! Boxes in JSON: a list of objects, in the sensor frame.
//!
//! ```json
//! [{"class": "car", "center_m": [10.2, -3.1, -0.9], "length_width_height_m": [4.1, 1.8, 1.5], "yaw_rad": 0.1, "track": 7}]
//! ```

use std::path::Path;

use detector::OrientedBox;
use serde::{Deserialize, Serialize};

use crate::annotation::Annotation;
use crate::dataset::DatasetError;
use crate::dataset::class_name::class_named;
use crate::dataset::text_file::read_text_file;

/// A box in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListedBox {
    /// What it is.
    pub class: String,
    /// Its centre in metres.
    pub center_m: [f32; 3],
    /// Its sides in metres.
    pub length_width_height_m: [f32; 3],
    /// Its heading in radians, counter-clockwise from x.
    pub yaw_rad: f32,
    /// Number of the object within its drive.
    #[serde(default)]
    pub track: Option<u32>,
}

/// Reads the boxes at `path` as annotations without points.
///
/// # Errors
///
/// [`DatasetError::Io`], [`DatasetError::NotText`], or [`DatasetError::Damaged`] if they are not such boxes.
pub fn read_box_list(path: &Path) -> Result<Vec<Annotation>, DatasetError> {
    let damaged = |problem: String| DatasetError::Damaged { path: path.to_path_buf(), problem };
    let listed: Vec<ListedBox> = serde_json::from_str(&read_text_file(path)?)
        .map_err(|error| damaged(format!("is no list of boxes: {error}")))?;
    listed
        .into_iter()
        .map(|it| {
            let is_sensible = it.length_width_height_m.iter().all(|side_m| *side_m > 0.0 && *side_m < 1e4)
                && it.center_m.iter().chain([&it.yaw_rad]).all(|value| value.abs() < 1e9);
            if !is_sensible {
                return Err(damaged(format!("has the box {it:?}")));
            }
            Ok(Annotation {
                class: class_named(&it.class),
                bounding_box: Some(OrientedBox {
                    center_m: it.center_m,
                    length_width_height_m: it.length_width_height_m,
                    yaw_rad: it.yaw_rad,
                }),
                point_indices: Vec::new(),
                track: it.track,
                occlusion: None,
                truncation: None,
            })
        })
        .collect()
}
