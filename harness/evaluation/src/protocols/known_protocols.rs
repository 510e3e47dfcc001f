//! Which protocols there are.

use reports::vocabulary::protocol::Protocol;

use super::argoverse2::Argoverse2;
use super::kitti_object::protocol::KittiObjectProtocol;
use super::nuscenes::Nuscenes;
use super::official_protocol::OfficialProtocol;

/// Every protocol, in the order of tables.
pub const PROTOCOLS: &[&dyn OfficialProtocol] = &[&KittiObjectProtocol, &Nuscenes, &Argoverse2];

/// What `protocol` does with a scan; `None` if it is not here.
pub fn official_protocol(protocol: Protocol) -> Option<&'static dyn OfficialProtocol> {
    PROTOCOLS.iter().copied().find(|it| it.protocol() == protocol)
}
