//! Boxes in CSV with the words of their detector, as `serve results` reads them.

use serde::{Deserialize, Serialize};

/// A row of a file of boxes.
#[derive(Debug, Serialize, Deserialize)]
pub struct NamedBox {
    /// Word for its class.
    pub class: String,
    /// Its centre.
    pub center_x_m: f32,
    /// Its centre.
    pub center_y_m: f32,
    /// Its centre.
    pub center_z_m: f32,
    /// Along the heading.
    pub length_m: f32,
    /// Across it.
    pub width_m: f32,
    /// Upwards.
    pub height_m: f32,
    /// Its heading.
    pub yaw_rad: f32,
}

impl NamedBox {
    /// Its columns.
    pub const COLUMNS: [&str; 8] =
        ["class", "center_x_m", "center_y_m", "center_z_m", "length_m", "width_m", "height_m", "yaw_rad"];
}
