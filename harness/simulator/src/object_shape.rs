//! The form of a free-standing object: solids of several materials in one frame.

use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose;
use reports::vocabulary::class::AnnotationClass;

use super::material::Material;
use super::solid::Solid;

/// The form of an object in its own frame: x forward, y left, z up, the origin on the ground below its middle.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectShape {
    /// Its class.
    pub class: AnnotationClass,
    /// Its solids.
    pub parts: Vec<Part>,
}

/// One solid of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its form.
    pub solid: Solid,
    /// Its material.
    pub material: Material,
    /// Whether labels leave it out of the box, as they do mirrors.
    pub is_outside_box: bool,
}

impl ObjectShape {
    /// An object of `class` made of these solids.
    pub fn new(class: AnnotationClass, parts: impl IntoIterator<Item = (Solid, Material)>) -> Self {
        let part = |(solid, material)| Part { solid, material, is_outside_box: false };
        let parts = parts.into_iter().map(part).collect();
        Self { class, parts }
    }

    /// The box of labels, in the object's frame.
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::new_invalid();
        for part in self.parts.iter().filter(|it| !it.is_outside_box) {
            bounds.merge(&part.solid.placed(&Pose::IDENTITY).bounds());
        }
        bounds
    }

    /// Length along x in metres.
    pub fn length_m(&self) -> f32 {
        self.bounds().extents().x
    }
}
