//! Dimensions of cars of one body style.

use std::ops::Range;

use serde::Deserialize;

use super::vehicle_parts::range;

/// Dimensions of cars of one body style. Positions along the length are shares of it from the front.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyStyle {
    /// How many of a hundred cars are like this.
    pub percent: u32,
    /// Lengths over all.
    #[serde(deserialize_with = "range")]
    pub length_m: Range<f32>,
    /// Heights over the road.
    #[serde(deserialize_with = "range")]
    pub height_m: Range<f32>,
    /// Widths without mirrors.
    #[serde(deserialize_with = "range")]
    pub width_m: Range<f32>,
    /// Height of the waist over the height.
    #[serde(deserialize_with = "range")]
    pub waist: Range<f32>,
    /// Where the windscreen begins.
    pub windscreen_foot: f32,
    /// Where it ends.
    pub roof_front: f32,
    /// Where the rear window begins.
    pub roof_rear: f32,
    /// Where it ends.
    pub rear_window_foot: f32,
    /// Height of the tail over the height of the waist.
    pub tail: f32,
    /// Height of the bonnet's front edge over the height of the waist.
    pub bonnet: f32,
    /// By how much the corners of the ground plan are cut off, in metres.
    pub rounding_m: f32,
    /// Whether there is a load bed behind the cabin.
    pub has_bed: bool,
    /// Radii of the wheels.
    #[serde(deserialize_with = "range")]
    pub wheel_radius_m: Range<f32>,
}

impl Default for BodyStyle {
    /// A small car, whose values stand for those that other styles leave out.
    fn default() -> Self {
        Self {
            percent: 100,
            length_m: 3.5..4.0,
            height_m: 1.42..1.55,
            width_m: 1.58..1.68,
            waist: 0.60..0.66,
            windscreen_foot: 0.25,
            roof_front: 0.43,
            roof_rear: 0.89,
            rear_window_foot: 0.99,
            tail: 0.98,
            bonnet: 0.79,
            rounding_m: 0.0,
            has_bed: false,
            wheel_radius_m: 0.28..0.33,
        }
    }
}
