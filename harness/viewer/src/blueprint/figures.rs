//! Stages of several detectors, as figures show them.

use rerun::blueprint::{ContainerLike, Grid};

use super::RecordingLayout;
use super::scene::Property;
use super::stages::stage_view;

/// A view for each figure whose detector and stage there are; `None` without any.
pub fn figures(layout: &RecordingLayout<'_>, properties: &mut Vec<Property>) -> Option<ContainerLike> {
    let mut views: Vec<ContainerLike> = Vec::new();
    for figure in layout.opening.figures {
        let detector = layout.detectors.iter().find(|it| it.detector == figure.detector);
        let stage = detector.and_then(|it| it.stages.iter().find(|it| it.stage == figure.stage));
        views.extend(stage.map(|it| stage_view(figure.title, it, properties)));
    }
    let n_columns = views.len().div_ceil(2) as u32;
    (!views.is_empty())
        .then(|| Grid::new(views).with_grid_columns(n_columns).with_name("figures of the papers").into())
}
