//! The values that a support vector machine sees of an object.

use crate::oriented_box::OrientedBox;

/// Computes the `D` values of a vehicle model for one object after another.
pub trait ObjectDescriber<const D: usize> {
    /// The names of the values, as in files.
    const NAMES: [&'static str; D];

    /// The values of an object with these points, in the sensor frame. `None` without points.
    fn describe(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; D]>;
}
