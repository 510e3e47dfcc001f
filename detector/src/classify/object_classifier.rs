//! What every trained model of vehicles can do.

use crate::describe::surroundings::Surroundings;
use crate::oriented_box::OrientedBox;

/// The decision on what need not be looked at: on the margin of the background.
pub const NO_VEHICLE: f32 = -1.0;

/// Tells vehicles by a trained model.
pub trait ObjectClassifier {
    /// How surely an object with these points, in the sensor frame, and these surroundings is a vehicle: above 0 it is one.
    fn decision(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> f32;
}
