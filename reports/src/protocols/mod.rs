//! Numbers that others publish, made of rows as their makers make them, and how sure they are.

pub mod protocol_number;
pub mod drawn_scans;
pub mod under_protocol;
mod scan_terms;
mod semantic_kitti;
mod ground;
mod ranked_classes;
mod recall_grid;
mod nuscenes_curves;
mod argoverse2_precisions;
pub mod nuscenes;
pub mod argoverse2;
pub mod kitti_object;
pub mod protocol_tally;
#[cfg(test)]
mod made_rows;
pub mod protocol_report;
mod short_forms;
pub mod given_classes;
pub mod swept_numbers;

use std::collections::BTreeMap;

use crate::rows::scan_name::ScanName;
use crate::vocabulary::protocol::Protocol;

/// Boxes of `rows` under `protocol`, on the scans named; `None` if it does not rank boxes.
fn under_ranked(
    protocol: Protocol,
    scans: &[ScanName],
    rows: &BTreeMap<ScanName, ranked_classes::RankedScan>,
) -> Option<Box<dyn under_protocol::UnderProtocol>> {
    match protocol {
        Protocol::Nuscenes | Protocol::NuscenesAgnostic => {
            Some(Box::new(nuscenes::Nuscenes::new(protocol, scans, rows)))
        }
        Protocol::Argoverse2 => Some(Box::new(argoverse2::Argoverse2::new(scans, rows))),
        Protocol::KittiObject | Protocol::SemanticKitti | Protocol::Ground => None,
    }
}
