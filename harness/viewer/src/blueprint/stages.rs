//! One detector, stage by stage.

use re_sdk_types::blueprint::archetypes::PlotLegend;
use rerun::EntityPath;
use rerun::blueprint::{ContainerLike, Grid, Horizontal, TimeSeriesView, Vertical};

use super::RecordingLayout;
use super::compare::{drawn_legend, mistakes};
use super::scene::{Eye, Property, Scene, ScenePoints, add, hide};
use crate::entity_paths;
use crate::product_views::{DetectorViews, StageView};

/// View of the products of `stage`.
pub fn stage_view(title: &str, stage: &StageView, properties: &mut Vec<Property>) -> ContainerLike {
    let points = if stage.is_of_cells { ScenePoints::None } else { ScenePoints::by(stage.labels) };
    scene(title, stage.entities.clone(), points, properties)
}

fn scene(
    name: &str,
    contents: Vec<EntityPath>,
    points: ScenePoints,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let view = Scene { name, frame: entity_paths::SENSOR, eye: Eye::NEAR, contents, points }.view(properties);
    hide(properties, &view, &entity_paths::ANNOTATIONS.into());
    view
}

/// A view for each stage of `detector`, then one of its scores and one of its outcomes.
pub fn stages(
    layout: &RecordingLayout<'_>,
    detector: &DetectorViews,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let name = &detector.detector;
    let mut views = Vec::new();
    for (number, stage) in (1..).zip(&detector.stages) {
        let title = format!("{number} {}", stage.stage.replace('_', " "));
        views.push(stage_view(&title, stage, properties));
    }
    let n_stages = detector.stages.len();
    let scores = format!("{} score: vehicle or not", n_stages + 1);
    views.push(scene(
        &scores,
        vec![entity_paths::scores(name)],
        ScenePoints::by(detector.clusters),
        properties,
    ));
    let judged = if layout.is_labelled { "right and wrong" } else { "who agrees" };
    let outcomes = format!("{} {}: {judged}", n_stages + 2, layout.opening.shown_task.name());
    let judged = vec![entity_paths::outcomes(name, layout.opening.shown_task)];
    views.push(scene(&outcomes, judged, ScenePoints::by(detector.surfaces), properties));
    let n_columns = views.len().div_ceil(2) as u32;
    let grid = Grid::new(views).with_grid_columns(n_columns);
    let times: ContainerLike =
        TimeSeriesView::new("stage times in ms").with_origin(entity_paths::stage_times(name)).into();
    // It would cover the plot; where detectors are compared, the same plot is wide enough for it.
    add(properties, &times, "PlotLegend", PlotLegend::new().with_visible(false));
    let legends = [entity_paths::LEGEND_STAGES, entity_paths::LEGEND_OUTCOMES]
        .map(|origin| drawn_legend(layout, origin, properties));
    let below = [mistakes(layout, name, properties), times].into_iter().chain(legends);
    Vertical::new([grid.into(), Horizontal::new(below).into()])
        .with_row_shares(vec![3.5, 1.0])
        .with_name(format!("stages of {name}"))
        .into()
}

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
