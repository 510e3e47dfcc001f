//! How a recording opens: one three-dimensional view per detector side by side, the series below.

use rerun::blueprint::{
    Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial2DView,
    Spatial3DView, Tabs, TimePanel, TimeSeriesView, Vertical,
};
use rerun::datatypes::{Range1D, Range2D};
use rerun::external::re_log_types::{BlueprintActivationCommand, LogMsg};
use rerun::external::re_sdk_types::Visualizer;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, EntityBehavior, EyeControls3D, LineGrid3D, PlotLegend, ScalarAxis, VisualBounds2D,
};
use rerun::external::re_sdk_types::blueprint::components::{
    BackgroundKind, Corner2D, PanelState, VisualizerComponentMapping,
};
use rerun::external::re_sdk_types::blueprint::datatypes;
use rerun::{
    AsComponents, ComponentIdentifier, EntityPath, Points3D, RecordingStream, RecordingStreamBuilder,
};

use super::entity_paths::ProductKind;
use super::error::StreamError;
use super::recording_axis::RecordingAxis;
use super::{entity_paths, legend, palette};
use crate::task::Task;

/// Where the eye is and what it looks at, in the sensor frame: above and behind the car, looking forward.
const EYE_M: [f32; 3] = [-15.5, 0.0, 13.5];
const LOOK_TARGET_M: [f32; 3] = [10.0, 0.0, -1.0];

/// A property of a view, or of an entity in it, that Rerun's typed builders do not know.
struct Property {
    path: EntityPath,
    value: Box<dyn AsComponents>,
}

/// Sends the blueprint for `detectors` along `stream`, over the time of `axis`; the outcomes of `shown_task` are visible, those of the other
/// tasks one click away.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn send_blueprint(
    stream: &RecordingStream,
    application_id: &'static str,
    detectors: &[String],
    shown_task: Task,
    axis: &RecordingAxis,
) -> Result<(), StreamError> {
    let mut properties = Vec::new();
    let scenes: Vec<ContainerLike> =
        detectors.iter().map(|detector| detector_tabs(detector, shown_task, &mut properties)).collect();
    let series = series_row(detectors, shown_task, axis, &mut properties);
    let layout = Vertical::new([Horizontal::new(scenes).into(), series]).with_row_shares(vec![3.2, 1.0]);
    let blueprint = Blueprint::new(layout)
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
        .with_time_panel(
            TimePanel::new()
                .with_state(PanelState::Collapsed)
                .with_timeline(axis.timeline.as_str())
                .with_fps(axis.steps_per_s),
        );
    let (messages, activation) = messages(application_id, &blueprint, &properties)
        .map_err(|reason| StreamError::Log { entity: "the blueprint".to_owned(), reason })?;
    stream.send_blueprint(messages, activation);
    Ok(())
}

/// The views of one detector as tabs: what it got right and wrong, its cells, its clusters.
fn detector_tabs(detector: &str, shown_task: Task, properties: &mut Vec<Property>) -> ContainerLike {
    let surfaces = entity_paths::surface_column(detector);
    let clusters = entity_paths::cluster_column(detector);
    let everything = [entity_paths::detector(detector)];
    let outcomes = scene(detector, &everything, Some(surfaces), properties);
    hide(properties, &outcomes, &entity_paths::ANNOTATIONS.into());
    for kind in ProductKind::ALL {
        hide(properties, &outcomes, &entity_paths::products(detector, kind));
    }
    for task in Task::ALL.into_iter().filter(|task| *task != shown_task) {
        hide(properties, &outcomes, &entity_paths::outcomes(detector, task));
    }
    let products = |kind| entity_paths::products(detector, kind);
    let below = [ProductKind::Cells, ProductKind::Segments].map(products);
    let around = [ProductKind::Contours, ProductKind::Boxes, ProductKind::Spheres].map(products);
    let cells = scene("cells", &below, None, properties);
    let clusters = scene("clusters", &around, Some(clusters), properties);
    Tabs::new([outcomes, cells, clusters]).into()
}

/// A view of `contents`, with the points of the scan coloured by `column`, or without them.
fn scene(
    name: &str,
    contents: &[EntityPath],
    column: Option<ComponentIdentifier>,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let mut queries: Vec<String> = contents.iter().map(|it| format!("+ {it}/**")).collect();
    queries.push(format!("+ /{}", entity_paths::SENSOR));
    let mut view = Spatial3DView::new(name).with_origin(entity_paths::WORLD);
    if let Some(column) = column {
        queries.push(format!("+ /{}/**", entity_paths::SCAN));
        view = view.with_override(entity_paths::POINTS, points_colored_by(column));
    }
    let view: ContainerLike = view.with_contents(queries).into();
    let eye = EyeControls3D::new()
        .with_position(EYE_M)
        .with_look_target(LOOK_TARGET_M)
        .with_eye_up([0.0_f32, 0.0, 1.0]);
    add(properties, &view, "EyeControls3D", eye);
    add(properties, &view, "Background", plain_background());
    add(properties, &view, "LineGrid3D", LineGrid3D::new().with_visible(false));
    view
}

/// Draws the points of the scan with `column` in the place of their class ids.
fn points_colored_by(column: ComponentIdentifier) -> Visualizer {
    let class_ids = Points3D::descriptor_class_ids().component;
    let mapping =
        datatypes::VisualizerComponentMapping::new_source_component(class_ids.as_str(), column.as_str());
    Visualizer::new("Points3D").with_mappings([VisualizerComponentMapping::from(mapping)])
}

/// F-rate so far and latency, the stage times of each detector, and what the colours mean.
fn series_row(
    detectors: &[String],
    shown_task: Task,
    axis: &RecordingAxis,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let mut columns = vec![rates_and_latencies(shown_task, axis, properties)];
    for detector in detectors {
        let view: ContainerLike = TimeSeriesView::new(format!("{detector}: stage times in ms"))
            .with_origin(entity_paths::stage_times(detector))
            .into();
        add(properties, &view, "PlotLegend", PlotLegend::new().with_corner(Corner2D::LeftTop));
        columns.push(view);
    }
    columns.push(drawn_legend(properties));
    Horizontal::new(columns).into()
}

fn rates_and_latencies(
    shown_task: Task,
    axis: &RecordingAxis,
    properties: &mut Vec<Property>,
) -> ContainerLike {
    let mut f_rate_view = |task: Task| {
        let view: ContainerLike = TimeSeriesView::new(format!("{}: {}", axis.rates, task.name()))
            .with_origin(entity_paths::f_rates(task))
            .into();
        add(properties, &view, "ScalarAxis", ScalarAxis::new().with_range([0.0, 1.0]));
        add(properties, &view, "PlotLegend", PlotLegend::new().with_corner(Corner2D::LeftBottom));
        view
    };
    let mut tabs = vec![f_rate_view(shown_task)];
    tabs.extend(Task::ALL.into_iter().filter(|task| *task != shown_task).map(f_rate_view));
    tabs.push(TimeSeriesView::new("Latency in ms").with_origin(entity_paths::LATENCY).into());
    let further = axis.further_series.iter();
    tabs.extend(further.map(|it| TimeSeriesView::new(*it).with_origin(entity_paths::further(it)).into()));
    Tabs::new(tabs).into()
}

fn drawn_legend(properties: &mut Vec<Property>) -> ContainerLike {
    let view: ContainerLike = Spatial2DView::new("Scan and legend").with_origin(entity_paths::LEGEND).into();
    let bounds = Range2D { x_range: Range1D(legend::VISIBLE_X), y_range: Range1D(legend::VISIBLE_Y) };
    add(properties, &view, "VisualBounds2D", VisualBounds2D::new(bounds));
    add(properties, &view, "Background", plain_background());
    view
}

fn plain_background() -> Background {
    Background::new(BackgroundKind::SolidColor).with_color(legend::rgba(palette::BACKGROUND))
}

/// Hides `entity` and all below it in `view`; one click shows it.
fn hide(properties: &mut Vec<Property>, view: &ContainerLike, entity: &EntityPath) {
    let path =
        view_path(view).join(&"ViewContents/overrides".into()).join(entity).join(&"visualizers".into());
    properties.push(Property { path, value: Box::new(EntityBehavior::new().with_visible(false)) });
}

/// Sets the property `name` of `view`.
fn add(
    properties: &mut Vec<Property>,
    view: &ContainerLike,
    name: &'static str,
    value: impl AsComponents + 'static,
) {
    properties.push(Property { path: view_path(view).join(&name.into()), value: Box::new(value) });
}

fn view_path(view: &ContainerLike) -> EntityPath {
    match view {
        ContainerLike::View(view) => view.blueprint_path(),
        _ => unreachable!("properties are set on views alone"),
    }
}

/// The messages of the blueprint store: the layout by Rerun's builders, then the properties, logged into the same store.
fn messages(
    application_id: &'static str,
    blueprint: &Blueprint,
    properties: &[Property],
) -> Result<(Vec<LogMsg>, BlueprintActivationCommand), String> {
    let text = |error: rerun::RecordingStreamError| error.to_string();
    let (layout, storage) = RecordingStreamBuilder::new(application_id).memory().map_err(text)?;
    blueprint.send(&layout, BlueprintActivation::default()).map_err(text)?;
    let mut messages = storage.take();
    messages
        .retain(|it| it.store_id().is_blueprint() && !matches!(it, LogMsg::BlueprintActivationCommand(_)));
    let store_id =
        messages.first().map(|it| it.store_id().clone()).ok_or("Rerun made an empty blueprint".to_owned())?;

    let (rest, storage) =
        RecordingStreamBuilder::from_store_id(&store_id).blueprint().memory().map_err(text)?;
    rest.set_time_sequence("blueprint", 0);
    for Property { path, value } in properties {
        rest.log(path.clone(), value.as_ref()).map_err(text)?;
    }
    messages.extend(storage.take().into_iter().filter(|it| !matches!(it, LogMsg::SetStoreInfo(_))));
    let activation =
        BlueprintActivationCommand { blueprint_id: store_id, make_active: true, make_default: true };
    Ok((messages, activation))
}
