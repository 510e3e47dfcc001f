//! The eight values by which a vehicle is told from background.

use super::corner_spheres::{CornerSpheres, OrderedRadii};
use super::box_frame_points::BoxFramePoints;
use super::prototype_library::PrototypeLibrary;
use super::side_profile::{SideProfile, SideProfileParams};
use crate::oriented_box::OrientedBox;

/// What the classifier sees of an object.
///
/// Paper: VM section 5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleFeatures {
    /// Length of the box.
    pub length_m: f32,
    /// Width of the box.
    pub width_m: f32,
    /// Radii of the spheres at the upper corners.
    pub radii: OrderedRadii,
    /// Difference to the nearest prototype's side profile in 0 to 1; 1 if the object has no profile.
    pub profile_difference: f32,
}

impl VehicleFeatures {
    /// The names of [`Self::values`], as in files.
    pub const NAMES: [&'static str; 8] = [
        "length_m",
        "width_m",
        "front_near_radius_m",
        "front_far_radius_m",
        "back_near_radius_m",
        "back_far_radius_m",
        "radius_difference_m",
        "profile_difference",
    ];

    /// The values in the order of [`Self::NAMES`].
    pub fn values(&self) -> [f32; 8] {
        let OrderedRadii { front_m: [front_near, front_far], back_m: [back_near, back_far] } = self.radii;
        [
            self.length_m,
            self.width_m,
            front_near,
            front_far,
            back_near,
            back_far,
            self.radii.difference_m(),
            self.profile_difference,
        ]
    }
}

/// Buffers for describing one object after another, and the shapes of the latest.
#[derive(Debug, Clone)]
pub struct VehicleDescriber {
    library: PrototypeLibrary,
    points: BoxFramePoints,
    profile: SideProfile,
}

impl VehicleDescriber {
    /// Compares profiles with those of `library`.
    pub fn new(params: SideProfileParams, library: PrototypeLibrary) -> Self {
        Self { library, points: BoxFramePoints::default(), profile: SideProfile::new(params) }
    }

    /// The features of an object with these points, in the sensor frame. `None` without points.
    pub fn describe(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl Iterator<Item = [f32; 3]>,
    ) -> Option<VehicleFeatures> {
        self.points.fill(bounding_box, positions_m);
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        let spheres = CornerSpheres::around(&self.points, length_m, width_m)?;
        let nearest = self.library.nearest(self.profile.concave_contour(&self.points));
        Some(VehicleFeatures {
            length_m,
            width_m,
            radii: spheres.ordered(),
            profile_difference: nearest.map_or(1.0, |it| it.difference),
        })
    }
}
