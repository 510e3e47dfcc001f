//! Which protocols there are.

use reports::vocabulary::protocol::Protocol;

use super::argoverse2::Argoverse2;
use super::kitti_object::protocol::KittiObjectProtocol;
use super::nuscenes::Nuscenes;
use super::official_protocol::OfficialProtocol;
use super::semantic_kitti::label_scores::scores_labels;

/// Every protocol that evaluates boxes, in the order of tables.
pub const PROTOCOLS: &[&dyn OfficialProtocol] = &[&KittiObjectProtocol, &Nuscenes, &Argoverse2];

/// Every protocol, in the order of tables.
pub fn known_protocols() -> impl Iterator<Item = Protocol> {
    Protocol::ALL.into_iter().filter(|it| official_protocol(*it).is_some() || scores_labels(*it))
}

/// What `protocol` does with a scan; `None` if it does not evaluate boxes.
pub fn official_protocol(protocol: Protocol) -> Option<&'static dyn OfficialProtocol> {
    PROTOCOLS.iter().copied().find(|it| it.protocol() == protocol)
}
