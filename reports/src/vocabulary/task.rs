//! The tasks of detectors.

use crate::vocabulary::named::named;

named! {
    /// What is asked of a detector.
    pub enum Task {
        /// Find every free-standing object, whatever it is. Paper: HG section 5.
        Objects = "objects",
        /// Find the vehicles among everything else. Paper: VM section 6.
        Vehicles = "vehicles",
    }
}

impl Task {
    /// Whether its detections are ranked by score: a score says how sure a detector is of a vehicle, whatever is asked.
    pub fn ranks_detections(self) -> bool {
        self == Self::Vehicles
    }
}
