//! Views of the scene in three dimensions, and properties of views.

use re_sdk_types::Visualizer;
use re_sdk_types::archetypes::Points3D;
use re_sdk_types::blueprint::archetypes::{Background, EntityBehavior, EyeControls3D, LineGrid3D};
use re_sdk_types::blueprint::components::{BackgroundKind, VisualizerComponentMapping};
use re_sdk_types::blueprint::datatypes;
use rerun::blueprint::{ContainerLike, Spatial3DView};
use rerun::{AsComponents, ComponentIdentifier, EntityPath};

use crate::{entity_paths, legend, palette};

/// A property of a view, or of an entity in it, that Rerun's typed builders do not know.
pub struct Property {
    /// Its path in the blueprint.
    pub path: EntityPath,
    /// Its value.
    pub value: Box<dyn AsComponents>,
}

/// Where the eye of a view is, and what it looks at.
#[derive(Debug, Clone, Copy)]
pub struct Eye {
    position_m: [f32; 3],
    look_target_m: [f32; 3],
    /// The eye goes with the sensor.
    follows: bool,
}

impl Eye {
    /// Above and behind the car, looking forward.
    pub const BEHIND: Self =
        Self { position_m: [-15.5, 0.0, 13.5], look_target_m: [10.0, 0.0, -1.0], follows: false };
    /// So high that the whole neighbourhood is in sight, also behind the car.
    pub const OVER: Self =
        Self { position_m: [-30.0, 0.0, 36.0], look_target_m: [0.0, 0.0, -1.0], follows: false };
    /// Nearer, for small views.
    pub const NEAR: Self =
        Self { position_m: [-6.0, 0.0, 9.5], look_target_m: [9.0, 0.0, -1.5], follows: false };
    /// High above the car, and moves with it: only the direction counts, the rest follows from the range rings.
    pub const ALONG: Self =
        Self { position_m: [-32.0, 0.0, 34.0], look_target_m: [0.0, 0.0, -1.5], follows: true };
}

/// A view of the scene.
pub struct Scene<'a> {
    /// Its name.
    pub name: &'a str,
    /// The frame it is drawn in: [`entity_paths::SENSOR`] or [`entity_paths::WORLD`].
    pub frame: &'static str,
    /// The eye that sees it.
    pub eye: Eye,
    /// Entities that are drawn besides points and sensor, each with everything below it.
    pub contents: Vec<EntityPath>,
    /// Colours of the points of the scan, and whether there are any.
    pub points: ScenePoints,
}

/// The points of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScenePoints {
    /// None.
    None,
    /// In colours without meaning.
    Plain,
    /// Coloured by this column.
    By(ComponentIdentifier),
}

impl ScenePoints {
    /// By `column` if there is one.
    pub fn by(column: Option<ComponentIdentifier>) -> Self {
        column.map_or(Self::Plain, Self::By)
    }
}

impl Scene<'_> {
    /// The view. Appends the properties that it needs to `properties`.
    pub fn view(self, properties: &mut Vec<Property>) -> ContainerLike {
        let mut queries: Vec<String> = self.contents.iter().map(|it| format!("+ {it}/**")).collect();
        queries.push(format!("+ /{}", entity_paths::FORWARD));
        if self.frame == entity_paths::WORLD {
            queries.extend([entity_paths::DRIVE, entity_paths::RANGE_RINGS].map(|it| format!("+ /{it}")));
        }
        let mut view = Spatial3DView::new(self.name).with_origin(self.frame);
        if self.points != ScenePoints::None {
            queries.push(format!("+ /{}/**", entity_paths::SCAN));
        }
        if let ScenePoints::By(column) = self.points {
            view = view.with_override(entity_paths::POINTS, points_coloured_by(column));
        }
        let view: ContainerLike = view.with_contents(queries).into();
        let Eye { position_m, look_target_m, follows } = self.eye;
        let mut eye = EyeControls3D::new()
            .with_position(position_m)
            .with_look_target(look_target_m)
            .with_eye_up([0.0_f32, 0.0, 1.0]);
        if follows {
            eye = eye.with_tracking_entity(format!("/{}", entity_paths::RANGE_RINGS));
        }
        add(properties, &view, "EyeControls3D", eye);
        add(properties, &view, "Background", plain_background());
        add(properties, &view, "LineGrid3D", LineGrid3D::new().with_visible(false));
        view
    }
}

/// Draws the points of the scan in the colours of `column` instead of their own.
fn points_coloured_by(column: ComponentIdentifier) -> Visualizer {
    let to = Points3D::descriptor_colors();
    let mapping =
        datatypes::VisualizerComponentMapping::new_source_component(to.component.as_str(), column.as_str());
    Visualizer::new("Points3D").with_mappings([VisualizerComponentMapping::from(mapping)])
}

/// The background of all views that have one.
pub fn plain_background() -> Background {
    Background::new(BackgroundKind::SolidColor).with_color(legend::rgba(palette::BACKGROUND))
}

/// Hides `entity` and all below it in `view`; one click shows it.
pub fn hide(properties: &mut Vec<Property>, view: &ContainerLike, entity: &EntityPath) {
    let value = Box::new(EntityBehavior::new().with_visible(false));
    properties.push(Property { path: override_path(view, entity), value });
}

/// Sets the property `name` of `view`.
pub fn add(
    properties: &mut Vec<Property>,
    view: &ContainerLike,
    name: &'static str,
    value: impl AsComponents + 'static,
) {
    properties.push(Property { path: view_path(view).join(&name.into()), value: Box::new(value) });
}

/// Path of the properties that hold for `entity` in `view` alone.
fn override_path(view: &ContainerLike, entity: &EntityPath) -> EntityPath {
    view_path(view).join(&"ViewContents/overrides".into()).join(entity).join(&"visualizers".into())
}

fn view_path(view: &ContainerLike) -> EntityPath {
    match view {
        ContainerLike::View(view) => view.blueprint_path(),
        _ => unreachable!("properties are set on views alone"),
    }
}
