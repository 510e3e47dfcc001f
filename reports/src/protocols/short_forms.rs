//! Which numbers of a protocol stand in short tables, and which are drawn.

use super::kitti_object::measures::{PRINCIPAL, SHORT_FORM};
use super::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolNumber};
use crate::vocabulary::protocol::ProtocolFamily;
use crate::vocabulary::ranked_protocol::RankedProtocol;

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
        let (class, id) = (self.metric.class.as_str(), self.metric.id.as_str());
        match self.protocol.family() {
            ProtocolFamily::KittiObjects => PRINCIPAL.contains(&id),
            ProtocolFamily::RankedBoxes => {
                let metrics =
                    RankedProtocol::of(self.protocol).map_or(&[][..], RankedProtocol::principal_metrics);
                class == PRESENT_CLASSES && metrics.contains(&id)
            }
            ProtocolFamily::Instances => {
                class == ALL_CLASSES && ["s_assoc", "s_assoc_over_50_points", "unknown_quality"].contains(&id)
            }
            ProtocolFamily::Ground => id == "f1",
        }
    }
}
