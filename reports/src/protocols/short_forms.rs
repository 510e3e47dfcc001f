//! Which numbers of a protocol stand in short tables, and which are drawn.

use super::kitti_object::measures::{PRINCIPAL, SHORT_FORM};
use super::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolNumber};
use crate::vocabulary::protocol::Protocol;

impl ProtocolNumber {
    /// Whether it stands in the short form of a table: numbers of all classes together; of KITTI, which has none, AP of each class on the
    /// plan and in space over 40 recalls; of ground, all.
    pub fn is_in_short_form(&self) -> bool {
        match self.protocol {
            Protocol::KittiObject => SHORT_FORM.contains(&self.metric.id.as_str()),
            Protocol::Nuscenes | Protocol::Argoverse2 | Protocol::SemanticKitti => {
                [ALL_CLASSES, PRESENT_CLASSES].contains(&self.metric.class.as_str())
            }
            Protocol::Ground => true,
        }
    }

    /// Whether it is one of the few that a protocol is known by, which sweeps show.
    pub fn is_principal(&self) -> bool {
        let (class, id) = (self.metric.class.as_str(), self.metric.id.as_str());
        match self.protocol {
            Protocol::KittiObject => PRINCIPAL.contains(&id),
            Protocol::Nuscenes => class == PRESENT_CLASSES && ["ap", "nds"].contains(&id),
            Protocol::Argoverse2 => class == PRESENT_CLASSES && ["ap", "cds"].contains(&id),
            Protocol::SemanticKitti => {
                class == ALL_CLASSES && ["s_assoc", "s_assoc_over_50_points", "unknown_quality"].contains(&id)
            }
            Protocol::Ground => id == "f1",
        }
    }
}
