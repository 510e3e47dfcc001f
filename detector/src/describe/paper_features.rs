//! The eight values of the paper, and nothing else.

use super::box_frame_points::BoxFramePoints;
use super::corner_spheres::{CornerSpheres, OrderedRadii};
use super::prototype_library::PrototypeLibrary;
use super::side_profile::SideProfile;
use crate::oriented_box::OrientedBox;
use crate::vector_instructions::{HotLoop, vectorised};

/// What the classifier of the paper sees of an object: three components, eight values.
///
/// Paper: VM section 5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperFeatures {
    /// Length of the box.
    pub length_m: f32,
    /// Width of the box.
    pub width_m: f32,
    /// Radii of the spheres at the upper corners.
    pub radii: OrderedRadii,
    /// Difference to the nearest prototype's side profile in 0 to 1; 1 if the object has no profile.
    pub profile_difference: f32,
}

/// Number of values.
pub const N_PAPER_FEATURES: usize = PaperFeatures::NAMES.len();

impl PaperFeatures {
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
    pub fn values(&self) -> [f32; N_PAPER_FEATURES] {
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

/// Buffers for describing one object after another.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperDescriber {
    library: PrototypeLibrary,
    points: BoxFramePoints,
    profile: SideProfile,
}

impl PaperDescriber {
    /// Compares profiles with those of `library`, in the same columns.
    pub fn new(library: PrototypeLibrary) -> Self {
        let profile = SideProfile::new(library.column_m());
        Self { library, points: BoxFramePoints::default(), profile }
    }

    /// What profiles are compared with.
    pub fn library(&self) -> &PrototypeLibrary {
        &self.library
    }

    /// The features of an object with these points, in the sensor frame. `None` without points.
    ///
    /// Paper: VM section 4.
    pub fn describe(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<PaperFeatures> {
        vectorised(Description { describer: self, bounding_box, positions_m })
    }
}

/// One object to be described.
struct Description<'a, P> {
    describer: &'a mut PaperDescriber,
    bounding_box: &'a OrientedBox,
    positions_m: P,
}

impl<P: ExactSizeIterator<Item = [f32; 3]>> HotLoop for Description<'_, P> {
    type Output = Option<PaperFeatures>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let PaperDescriber { library, points, profile } = self.describer;
        points.fill(self.bounding_box, self.positions_m);
        let [length_m, width_m, _] = self.bounding_box.length_width_height_m;
        let spheres = CornerSpheres::around(points, length_m, width_m)?;
        let nearest = library.nearest(profile.concave_contour(points));
        let profile_difference = nearest.map_or(1.0, |it| it.difference);
        Some(PaperFeatures { length_m, width_m, radii: spheres.ordered(), profile_difference })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::surroundings::Surroundings;
    use crate::describe::vehicle_features::{VehicleDescriber, VehicleFeatures};

    const BOX: OrientedBox =
        OrientedBox { center_m: [9.0, 2.0, -1.0], length_width_height_m: [4.2, 1.7, 1.4], yaw_rad: 0.3 };

    #[test]
    fn they_are_the_first_eight_values_of_our_own_model() {
        assert_eq!(PaperFeatures::NAMES[..], VehicleFeatures::NAMES[..N_PAPER_FEATURES]);
        let positions_m: Vec<[f32; 3]> = (0..60)
            .map(|it| {
                let share = it as f32 / 60.0;
                [7.2 + 3.6 * share, 1.2 + 1.1 * share, -1.6 + (7.0 * share).sin().abs()]
            })
            .collect();
        let library = PrototypeLibrary::drawn();
        let mut ours = VehicleDescriber::new(library.clone());
        let positions = || positions_m.iter().copied();
        let of_28 = ours.describe(&BOX, &Surroundings::default(), positions()).unwrap().values();
        let of_8 = PaperDescriber::new(library).describe(&BOX, positions()).unwrap().values();
        assert_eq!(of_8[..], of_28[..N_PAPER_FEATURES]);
    }

    #[test]
    fn no_points_have_no_features() {
        let mut describer = PaperDescriber::new(PrototypeLibrary::drawn());
        assert_eq!(describer.describe(&BOX, std::iter::empty()), None);
    }
}
