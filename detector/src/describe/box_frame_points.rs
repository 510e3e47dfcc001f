//! The points of one object in the frame of its box.

use crate::oriented_box::OrientedBox;

/// Columns of coordinates in metres relative to the centre of a box: along its length, across to the left, and up.
#[derive(Debug, Clone, Default)]
pub struct BoxFramePoints {
    // Invariant: the columns have the same length.
    along_m: Vec<f32>,
    across_m: Vec<f32>,
    up_m: Vec<f32>,
}

impl BoxFramePoints {
    /// Takes `positions_m` of the sensor frame over into the frame of `bounding_box`.
    pub fn fill(&mut self, bounding_box: &OrientedBox, positions_m: impl Iterator<Item = [f32; 3]>) {
        let (sin, cos) = bounding_box.yaw_rad.sin_cos();
        let [center_x, center_y, center_z] = bounding_box.center_m;
        self.along_m.clear();
        self.across_m.clear();
        self.up_m.clear();
        for [x, y, z] in positions_m {
            let (dx, dy) = (x - center_x, y - center_y);
            self.along_m.push(cos * dx + sin * dy);
            self.across_m.push(cos * dy - sin * dx);
            self.up_m.push(z - center_z);
        }
    }

    /// Coordinates along the length.
    pub fn along_m(&self) -> &[f32] {
        &self.along_m
    }

    /// Coordinates across, to the left.
    pub fn across_m(&self) -> &[f32] {
        &self.across_m
    }

    /// Coordinates upward.
    pub fn up_m(&self) -> &[f32] {
        &self.up_m
    }
}
