//! What every trained model of vehicles can do.

use crate::oriented_box::OrientedBox;

/// Tells vehicles by a trained model.
pub trait ObjectClassifier {
    /// How surely an object with these points, in the sensor frame, above ground of elevation `ground_m` is a vehicle:
    /// above 0 it is one. `None` without points.
    fn decision(
        &mut self,
        bounding_box: &OrientedBox,
        ground_m: f32,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<f32>;
}
