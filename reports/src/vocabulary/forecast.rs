//! What is taken to become of detections until the next answer.

use crate::vocabulary::named::named;

named! {
    /// Where the boxes of an answer are taken to be while it is the newest.
    pub enum Forecast {
        /// They stay where they were relative to the car.
        Hold = "hold",
        /// They stay where they were on the ground: the car's own motion is known.
        CarMotion = "car-motion",
        /// They go on with the velocity that a tracker gives them.
        ConstantVelocity = "constant-velocity",
    }
}
