//! Classes of protocols that at least one detector gives.

use std::collections::BTreeSet;

use crate::rows::kitti_object_row::{KittiFact, KittiObjectRow};
use crate::rows::ranked_box_row::{BoxKind, RankedBoxRow};
use crate::vocabulary::protocol::Protocol;

/// Classes that at least one detection has. All others can only be missed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GivenClasses(BTreeSet<(Protocol, &'static str)>);

impl GivenClasses {
    /// Adds the class of a detection; an annotation changes nothing.
    pub fn add_ranked_box(&mut self, row: &RankedBoxRow) {
        if let BoxKind::Detection { .. } = row.ranked_box.kind {
            self.0.insert((row.protocol, row.ranked_box.class));
        }
    }

    /// Adds the class of a KITTI detection; an annotation changes nothing.
    pub fn add_kitti_object(&mut self, row: &KittiObjectRow) {
        if let KittiFact::Detection { object, .. } = row.fact {
            self.0.insert((Protocol::KittiObject, object.class.name()));
        }
    }

    /// Whether any detection has `class`, as `protocol` calls it.
    pub fn has(&self, protocol: Protocol, class: &str) -> bool {
        self.0.contains(&(protocol, class))
    }
}
