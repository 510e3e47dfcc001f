//! The files of `SUSTechPOINTS`, an annotation tool: lists of objects with position, scale and rotation.

use serde::{Deserialize, Serialize};

use super::label_cloud::Axes;
use super::listed_box::ListedBox;
use crate::dataset::python_json::number_or_none;

/// An object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SustechObject {
    /// Its number within the scene, as text; may be empty.
    #[serde(default, deserialize_with = "text_or_number")]
    pub obj_id: String,
    /// Its class.
    pub obj_type: String,
    /// Its box.
    pub psr: PositionScaleRotation,
    /// How sure the detector is that proposed it.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "number_or_none")]
    pub score: Option<f32>,
}

/// A box: centre, extent along its own axes, and turns about the axes in radians, of which the last is the heading.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "they are called as they are")]
pub struct PositionScaleRotation {
    pub position: Axes,
    pub scale: Axes,
    pub rotation: Axes,
}

impl SustechObject {
    /// The box in the form of `SUSTechPOINTS`.
    pub fn new(listed: &ListedBox, score: Option<f32>) -> Self {
        let axes = |[x, y, z]: [f64; 3]| Axes { x, y, z };
        Self {
            obj_id: listed.track.map(|it| it.to_string()).unwrap_or_default(),
            obj_type: listed.class.clone(),
            psr: PositionScaleRotation {
                position: axes(listed.center_m),
                scale: axes(listed.length_width_height_m.map(f64::from)),
                rotation: axes([0.0, 0.0, f64::from(listed.yaw_rad)]),
            },
            score,
        }
    }

    /// The box in our form, set upright.
    pub fn listed(&self) -> ListedBox {
        let PositionScaleRotation { position, scale, rotation } = self.psr;
        ListedBox {
            class: self.obj_type.clone(),
            center_m: [position.x, position.y, position.z],
            length_width_height_m: [scale.x, scale.y, scale.z].map(|it| it as f32),
            yaw_rad: rotation.z as f32,
            track: self.obj_id.parse().ok(),
        }
    }
}

/// Some versions of the tool write text, some numbers.
fn text_or_number<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    Ok(match serde_json::Value::deserialize(deserializer)? {
        serde_json::Value::String(text) => text,
        serde_json::Value::Number(number) => number.to_string(),
        _ => String::new(),
    })
}
