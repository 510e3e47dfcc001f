//! Objects that grow side by side: the cloud, how likely each class is, how far it is, and the bag.

use re_sdk_types::blueprint::archetypes::{EyeControls3D, LineGrid3D, PlotLegend, ScalarAxis};
use re_sdk_types::blueprint::components::PanelState;
use re_sdk_types::datatypes::Range1D;
use rerun::RecordingStream;
use rerun::blueprint::{
    BarChartView, Blueprint, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial3DView, Tabs,
    TimePanel, TimeSeriesView, Vertical,
};

use super::scene::{Property, add, plain_background};
use super::send;
use crate::entity_paths::{GrowthPart, growth};
use crate::error::StreamError;

/// A column of the tab: one object.
pub struct GrowthColumn {
    /// Its data set, which end it is seen from, and which object it is.
    pub of: [String; 3],
    /// Its title.
    pub title: String,
    /// Middle of the points that are seen in the end, in metres.
    pub middle_m: [f32; 3],
    /// Its largest extent, in metres.
    pub extent_m: f32,
}

/// A tab: everything that is seen from one end.
pub struct GrowthTab {
    /// Its name.
    pub name: String,
    /// Its objects.
    pub columns: Vec<GrowthColumn>,
}

/// Sends the blueprint of `tabs` along `stream`, whose timeline is `timeline` with so many steps a second.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn send_growth_blueprint(
    stream: &RecordingStream,
    application_id: &'static str,
    tabs: &[GrowthTab],
    (timeline, steps_per_s): (&str, f64),
) -> Result<(), StreamError> {
    let mut properties = Vec::new();
    let mut containers: Vec<ContainerLike> = Vec::new();
    for tab in tabs {
        let columns: Vec<ContainerLike> = tab.columns.iter().map(|it| column(it, &mut properties)).collect();
        containers.push(Horizontal::new(columns).with_name(tab.name.as_str()).into());
    }
    let panel =
        TimePanel::new().with_state(PanelState::Collapsed).with_timeline(timeline).with_fps(steps_per_s);
    let blueprint = Blueprint::new(Tabs::new(containers))
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
        .with_time_panel(panel);
    send(stream, application_id, &blueprint, &properties)
}

fn column(of: &GrowthColumn, properties: &mut Vec<Property>) -> ContainerLike {
    let origin = |part| growth(&of.of, part);
    let scene: ContainerLike =
        Spatial3DView::new(of.title.as_str()).with_origin(origin(GrowthPart::Scene)).into();
    let away_m = 1.15 * of.extent_m + 1.5;
    let [x, y, z] = of.middle_m;
    let eye = EyeControls3D::new()
        .with_position([x - 0.85 * away_m, y - 0.75 * away_m, z + 0.45 * away_m])
        .with_look_target(of.middle_m)
        .with_eye_up([0.0_f32, 0.0, 1.0]);
    add(properties, &scene, "EyeControls3D", eye);
    add(properties, &scene, "Background", plain_background());
    add(properties, &scene, "LineGrid3D", LineGrid3D::new().with_visible(true).with_spacing(1.0_f32));
    // The colours are those of the bars of each class.
    let without_legend = || PlotLegend::new().with_visible(false);
    let chances: ContainerLike =
        TimeSeriesView::new("chance of each class").with_origin(origin(GrowthPart::Chances)).into();
    // A chance of 0 or 1 is still seen as a line.
    add(properties, &chances, "ScalarAxis", ScalarAxis::new().with_range(Range1D([-0.04, 1.04])));
    let errors: ContainerLike =
        TimeSeriesView::new("distance to each class").with_origin(origin(GrowthPart::Errors)).into();
    let bag: ContainerLike = BarChartView::new("bag of patterns").with_origin(origin(GrowthPart::Bag)).into();
    for view in [&chances, &errors, &bag] {
        add(properties, view, "PlotLegend", without_legend());
    }
    Vertical::new([scene, chances, errors, bag]).with_row_shares(vec![5.0, 2.0, 2.0, 1.6]).into()
}
