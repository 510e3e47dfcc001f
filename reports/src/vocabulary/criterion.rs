//! Criteria by which detections are matched with annotations.

use crate::vocabulary::named::named;

named! {
    /// What a detection and an annotation are compared by, however alike they have to be.
    pub enum CriterionKind {
        /// Their points: what the sensor saw.
        Points = "points",
        /// Their boxes on the ground plan.
        BevIou = "bev-iou",
        /// Their boxes in space.
        Iou3d = "iou-3d",
        /// The distance of their centres on the ground plan.
        Centre = "centre",
    }
}
