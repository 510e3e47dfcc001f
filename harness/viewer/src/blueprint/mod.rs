//! How a recording opens: tabs for figures and three tasks, of which one is in front.

use re_sdk_types::blueprint::components::{PanelState, PlayState};
use rerun::blueprint::{
    Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, SelectionPanel, Tabs, TimePanel,
};
use rerun::external::re_log_types::{BlueprintActivationCommand, LogMsg};
use rerun::{RecordingStream, RecordingStreamBuilder};

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

/// `content` with the time below it, and no other panels.
fn plain_blueprint(content: impl Into<ContainerLike>, layout: &RecordingLayout<'_>) -> Blueprint {
    Blueprint::new(content)
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
        .with_time_panel(time_panel(layout))
}

/// Sends `blueprint` with `properties` of its views along `stream`.
fn send(
    stream: &RecordingStream,
    application_id: &'static str,
    blueprint: &Blueprint,
    properties: &[Property],
) -> Result<(), StreamError> {
    let (messages, activation) = messages(application_id, blueprint, properties)
        .map_err(|reason| StreamError::Log { entity: "the blueprint".to_owned(), reason })?;
    stream.send_blueprint(messages, activation);
    Ok(())
}

fn time_panel(layout: &RecordingLayout<'_>) -> TimePanel {
    let panel = TimePanel::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(layout.axis.timeline.as_str())
        .with_fps(layout.axis.steps_per_s);
    // Left alone, a viewer follows the incoming data, and stays at the end.
    if layout.opening.at_the_start { panel.with_play_state(PlayState::Paused) } else { panel }
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
