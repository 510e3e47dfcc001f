//! The eight values of the paper, and nothing else.

use super::box_frame_points::BoxFramePoints;
use super::corner_spheres::{CornerSpheres, OrderedRadii};
use super::object_describer::ObjectDescriber;
use super::prototype_library::PrototypeLibrary;
use super::side_profile::SideProfile;
use crate::oriented_box::OrientedBox;
use crate::vector_instructions::{HotLoop, vectorised};

/// Number of values.
pub const N_PAPER_FEATURES: usize = 8;

/// The values that the classifier of the paper sees of an object: three components, eight values. With buffers for one
/// object after another.
///
/// Paper: VM sections 4 and 5.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperDescriber {
    library: PrototypeLibrary,
    points: BoxFramePoints,
    profile: SideProfile,
}

impl ObjectDescriber<N_PAPER_FEATURES> for PaperDescriber {
    const NAMES: [&'static str; N_PAPER_FEATURES] = [
        "length_m",
        "width_m",
        "front_near_radius_m",
        "front_far_radius_m",
        "back_near_radius_m",
        "back_far_radius_m",
        "radius_difference_m",
        // 1 if the object has no profile.
        "profile_difference",
    ];

    fn describe(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_PAPER_FEATURES]> {
        vectorised(Description { describer: self, bounding_box, positions_m })
    }
}

impl PaperDescriber {
    /// Compares profiles with those of `library`, in the same columns.
    pub fn new(library: PrototypeLibrary) -> Self {
        let profile = SideProfile::new(library.column_m());
        Self { library, points: BoxFramePoints::default(), profile }
    }

    /// The prototypes that profiles are compared with.
    pub fn library(&self) -> &PrototypeLibrary {
        &self.library
    }

    /// The points of the object that was described last.
    pub(super) fn points(&self) -> &BoxFramePoints {
        &self.points
    }

    #[inline(always)]
    pub(super) fn values(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_PAPER_FEATURES]> {
        self.points.fill(bounding_box, positions_m);
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        let radii = CornerSpheres::around(&self.points, length_m, width_m)?.ordered();
        let nearest = self.library.nearest(self.profile.concave_contour(&self.points));
        let profile_difference = nearest.map_or(1.0, |it| it.difference);
        let OrderedRadii { front_m: [front_near, front_far], back_m: [back_near, back_far] } = radii;
        let difference_m = radii.difference_m();
        Some([
            length_m,
            width_m,
            front_near,
            front_far,
            back_near,
            back_far,
            difference_m,
            profile_difference,
        ])
    }
}

/// One object to be described.
struct Description<'a, P> {
    describer: &'a mut PaperDescriber,
    bounding_box: &'a OrientedBox,
    positions_m: P,
}

impl<P: ExactSizeIterator<Item = [f32; 3]>> HotLoop for Description<'_, P> {
    type Output = Option<[f32; N_PAPER_FEATURES]>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.describer.values(self.bounding_box, self.positions_m)
    }
}
