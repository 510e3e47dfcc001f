//! The protocols that others publish numbers under.

use crate::vocabulary::named::named;

named! {
    /// A protocol: what counts, what matches what, and which numbers are made of it, as its makers have it.
    pub enum Protocol {
        /// KITTI's object benchmark: average precision of boxes in the image, from above and in space.
        KittiObject = "kitti-object",
        /// nuScenes' detection task: NDS.
        Nuscenes = "nuscenes",
        /// Argoverse 2's detection challenge: CDS.
        Argoverse2 = "argoverse2",
        /// Instances of SemanticKITTI, whatever their class.
        SemanticKitti = "semantic-kitti",
        /// Points of the ground.
        Ground = "ground",
    }
}
