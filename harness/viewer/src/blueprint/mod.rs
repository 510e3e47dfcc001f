//! How a recording opens: tabs for figures and three tasks, of which one is in front.

use re_sdk_types::blueprint::components::{PanelState, PlayState};
use rerun::blueprint::{
    Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, SelectionPanel, Tabs, TimePanel,
};
use rerun::external::re_log_types::{BlueprintActivationCommand, LogMsg};
use rerun::{RecordingStream, RecordingStreamBuilder, StoreId, StoreKind};

use self::compare::{changes, compare, drive};
use self::scene::Property;
use self::stages::{figures, stages};
use super::error::StreamError;
use super::product_views::DetectorViews;
use super::recording_axis::RecordingAxis;
use super::stream_options::{FirstTab, Opening};

mod scene;
mod compare;
mod stages;
pub mod growth;
pub mod streams;

/// Content of a recording that the blueprint lays out.
pub struct RecordingLayout<'a> {
    /// The detectors, in the order in which they are shown.
    pub detectors: &'a [DetectorViews],
    /// The time axis.
    pub axis: &'a RecordingAxis,
    /// How the recording opens.
    pub opening: Opening,
    /// Whether the time follows the newest scan, and does not stay at the first.
    pub is_live: bool,
    /// Whether the scans have labels.
    pub is_labelled: bool,
}

/// Sends the blueprint of `layout` along `stream`.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn send_blueprint(
    stream: &RecordingStream,
    application_id: &'static str,
    layout: &RecordingLayout<'_>,
) -> Result<(), StreamError> {
    let mut properties = Vec::new();
    if layout.opening.first_tab == FirstTab::Changes {
        let changes = changes(layout, &mut properties);
        return send(stream, application_id, &plain_blueprint(changes, layout), &properties);
    }
    let mut tabs: Vec<_> = figures(layout, &mut properties).into_iter().collect();
    let n_figures = tabs.len();
    tabs.push(compare(layout, &mut properties));
    tabs.extend(layout.detectors.iter().map(|detector| stages(layout, detector, &mut properties)));
    if layout.opening.has_poses {
        tabs.push(drive(layout, &mut properties));
    }
    let front = match layout.opening.first_tab {
        FirstTab::Stages if !layout.detectors.is_empty() => n_figures + 1,
        FirstTab::Drive if layout.opening.has_poses => tabs.len() - 1,
        FirstTab::Compare | FirstTab::Changes | FirstTab::Stages | FirstTab::Drive => 0,
    };
    tabs.rotate_left(front);
    send(stream, application_id, &plain_blueprint(Tabs::new(tabs), layout), &properties)
}

/// Sends the beginning of the blueprint along `stream`: the time, and no view. A viewer reads all layers of a recording at once;
/// without this in each of them it would be at a late scan before it has the layout.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn send_time(
    stream: &RecordingStream,
    application_id: &'static str,
    axis: &RecordingAxis,
    is_live: bool,
) -> Result<(), StreamError> {
    let nothing = Tabs::new(Vec::<ContainerLike>::new());
    send(stream, application_id, &with_time(nothing, axis, is_live), &[])
}

fn plain_blueprint(content: impl Into<ContainerLike>, layout: &RecordingLayout<'_>) -> Blueprint {
    with_time(content, layout.axis, layout.is_live)
}

/// `content` with the time below it, and no other panels.
fn with_time(content: impl Into<ContainerLike>, axis: &RecordingAxis, is_live: bool) -> Blueprint {
    Blueprint::new(content)
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
        .with_time_panel(time_panel(axis, is_live))
}

/// Sends `blueprint` with `properties` of its views along `stream`.
fn send(
    stream: &RecordingStream,
    application_id: &'static str,
    blueprint: &Blueprint,
    properties: &[Property],
) -> Result<(), StreamError> {
    let (mut messages, mut activation) = messages(application_id, blueprint, properties)
        .map_err(|reason| StreamError::Log { entity: "the blueprint".to_owned(), reason })?;
    if let Some(recording) = stream.store_info().map(|it| it.store_id) {
        // One blueprint for a recording: what comes later replaces what came before.
        let id = StoreId::new(StoreKind::Blueprint, application_id, recording.recording_id().as_str());
        for it in &mut messages {
            it.set_store_id(id.clone());
        }
        activation.blueprint_id = id;
    }
    stream.send_blueprint(messages, activation);
    Ok(())
}

fn time_panel(axis: &RecordingAxis, is_live: bool) -> TimePanel {
    // A viewer holds the scene where its user stops the time, and goes on with it by its button *follow*.
    let state = if is_live { PlayState::Following } else { PlayState::Paused };
    TimePanel::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(axis.timeline.as_str())
        .with_fps(axis.steps_per_s)
        .with_play_state(state)
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
