//! Detectors side by side in real time: what each knows, and how old that is.

use re_sdk_types::blueprint::archetypes::{EyeControls3D, LineGrid3D, PlotLegend, ScalarAxis};
use re_sdk_types::blueprint::components::{Corner2D, PanelState};
use rerun::RecordingStream;
use rerun::blueprint::{
    Blueprint, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial3DView, TimePanel,
    TimeSeriesView, Vertical,
};

use super::scene::{Property, add, plain_background};
use super::send;
use crate::entity_paths;
use crate::error::StreamError;

/// Sends the blueprint of a stream with these detectors and titles along `stream`.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn send_stream_blueprint(
    stream: &RecordingStream,
    application_id: &'static str,
    detectors: &[(String, String)],
    timeline: &str,
) -> Result<(), StreamError> {
    let mut properties = Vec::new();
    let scenes: Vec<ContainerLike> =
        detectors.iter().map(|(name, title)| scene(name, title, &mut properties)).collect();
    let mut series = |title: &str, origin: &str| {
        let view: ContainerLike = TimeSeriesView::new(title).with_origin(origin).into();
        add(&mut properties, &view, "PlotLegend", PlotLegend::new().with_corner(Corner2D::LeftTop));
        view
    };
    let age = series("age of what is known (ms)", entity_paths::STREAM_AGE);
    let found = series("share of objects that are where the detector has them", entity_paths::STREAM_FOUND);
    add(&mut properties, &found, "ScalarAxis", ScalarAxis::new().with_range([0.0, 1.0]));
    let rows: [ContainerLike; 2] = [Horizontal::new(scenes).into(), Horizontal::new([age, found]).into()];
    let blueprint =
        Blueprint::new(Vertical::new(rows).with_row_shares(vec![3.0, 1.0]).with_name("in real time"))
            .with_auto_views(false)
            .with_auto_layout(false)
            .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
            .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
            .with_time_panel(TimePanel::new().with_state(PanelState::Collapsed).with_timeline(timeline));
    send(stream, application_id, &blueprint, &properties)
}

/// What a detector knows, with an eye that goes along with the car.
fn scene(name: &str, title: &str, properties: &mut Vec<Property>) -> ContainerLike {
    let contents = [
        format!("+ /{}/**", entity_paths::STREAM_SCAN),
        format!("+ /{}", entity_paths::STREAM_CAR),
        format!("+ /{}", entity_paths::STREAM_RINGS),
        format!("+ {}/**", entity_paths::known(name)),
    ];
    let view: ContainerLike =
        Spatial3DView::new(title).with_origin(entity_paths::STREAM).with_contents(contents).into();
    let eye = EyeControls3D::new()
        .with_position([-22.0_f32, -6.0, 20.0])
        .with_look_target([6.0_f32, 0.0, -1.5])
        .with_eye_up([0.0_f32, 0.0, 1.0])
        .with_tracking_entity(format!("/{}", entity_paths::STREAM_RINGS));
    add(properties, &view, "EyeControls3D", eye);
    add(properties, &view, "Background", plain_background());
    add(properties, &view, "LineGrid3D", LineGrid3D::new().with_visible(false));
    view
}
