//! The drive in a frame that rests.

use rerun::blueprint::{ContainerLike, Horizontal};

use super::RecordingLayout;
use super::compare::outcomes;
use super::scene::{Eye, Property};
use crate::entity_paths;

/// What each detector got right and wrong, with the eye going along.
pub fn drive(layout: &RecordingLayout<'_>, properties: &mut Vec<Property>) -> ContainerLike {
    let view = |detector| outcomes(layout, detector, entity_paths::WORLD, Eye::ALONG, properties);
    let views: Vec<ContainerLike> = layout.detectors.iter().map(view).collect();
    Horizontal::new(views).with_name("follow the drive").into()
}
