//! Numbers of a protocol that stand in short tables, and those that are drawn.

use super::kitti_object::measures::SHORT_FORM;
use super::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolNumber};
use crate::vocabulary::protocol::ProtocolFamily;

impl ProtocolNumber {
    /// Whether it stands in the short form of a table: numbers of all classes together; of KITTI, which has none, AP of each
    /// class on the plan and in space over 40 recalls; of ground, all.
    pub fn is_in_short_form(&self) -> bool {
        match self.protocol.family() {
            ProtocolFamily::KittiObjects => SHORT_FORM.contains(&self.metric.id.as_str()),
            ProtocolFamily::RankedBoxes | ProtocolFamily::Instances => {
                [ALL_CLASSES, PRESENT_CLASSES].contains(&self.metric.class.as_str())
            }
            ProtocolFamily::Ground => true,
        }
    }

    /// Whether it is one of the few that a protocol is known by, which sweeps show.
    pub fn is_principal(&self) -> bool {
        let class = self.metric.class.as_str();
        let is_of_class = match self.protocol.family() {
            ProtocolFamily::RankedBoxes => class == PRESENT_CLASSES,
            ProtocolFamily::Instances => class == ALL_CLASSES,
            ProtocolFamily::KittiObjects | ProtocolFamily::Ground => true,
        };
        is_of_class && self.protocol.principal_metrics().contains(&self.metric.id.as_str())
    }
}
