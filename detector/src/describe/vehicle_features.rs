//! The values by which a vehicle is told from background.

use super::box_frame_points::BoxFramePoints;
use super::corner_spheres::{CornerSpheres, OrderedRadii};
use super::elevation_spread::ElevationSpread;
use super::lengthwise_thirds::LengthwiseThirds;
use super::prototype_library::PrototypeLibrary;
use super::side_profile::SideProfile;
use super::side_shares::SideShares;
use super::surface_roughness::RoughnessSquares;
use super::surroundings::Surroundings;
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::vector_instructions::{HotLoop, vectorised};

/// What the classifier sees of an object.
///
/// The first eight values are the paper's. It has no height among them, nor anything that tells a shell from a filled
/// volume or leaves from metal, which side of the object is seen, how much of it, or what stands around it; the others say
/// that.
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
    /// Where its points are above the ground.
    pub elevation: ElevationSpread,
    /// How much of it lies on the sides of its box.
    pub side_shares: SideShares,
    /// Cosine of the angle between the line of sight and the length of the box, without its sign: 1 if an end is seen, 0
    /// if a side is.
    pub view_cosine: f32,
    /// How it is built from end to end.
    pub thirds: LengthwiseThirds,
    /// The share of its points that are far from flat sides.
    pub rough_share: f32,
    /// Number of its points.
    pub n_points: f32,
    /// Distance of its middle from the sensor on the ground.
    pub range_m: f32,
    /// What stands around it.
    pub surroundings: Surroundings,
}

impl VehicleFeatures {
    /// The names of [`Self::values`], as in files.
    pub const NAMES: [&'static str; 28] = [
        "length_m",
        "width_m",
        "front_near_radius_m",
        "front_far_radius_m",
        "back_near_radius_m",
        "back_far_radius_m",
        "radius_difference_m",
        "profile_difference",
        "bottom_m",
        "top_m",
        "mean_elevation_m",
        "elevation_deviation_m",
        "view_cosine",
        "share_above_0.5_m",
        "share_above_1.1_m",
        "share_above_1.4_m",
        "low_end_top_m",
        "middle_top_m",
        "high_end_top_m",
        "low_end_share",
        "middle_share",
        "on_ends_share",
        "on_sides_share",
        "rough_share",
        "root_n_points",
        "root_seen_area",
        "beyond_ends_share",
        "occupied_share",
    ];

    /// The values in the order of [`Self::NAMES`].
    pub fn values(&self) -> [f32; 28] {
        let OrderedRadii { front_m: [front_near, front_far], back_m: [back_near, back_far] } = self.radii;
        let [above_bumper, above_bonnet, above_windows] = self.elevation.shares_above;
        let [low_end_top_m, middle_top_m, high_end_top_m] = self.thirds.tops_m;
        let [low_end_share, middle_share, _] = self.thirds.shares;
        let n_beyond_ends = self.surroundings.n_beyond_ends as f32;
        let fourth_root = |it: f32| it.sqrt().sqrt();
        [
            self.length_m,
            self.width_m,
            front_near,
            front_far,
            back_near,
            back_far,
            self.radii.difference_m(),
            self.profile_difference,
            self.elevation.bottom_m,
            self.elevation.top_m,
            self.elevation.mean_m,
            self.elevation.deviation_m,
            self.view_cosine,
            above_bumper,
            above_bonnet,
            above_windows,
            low_end_top_m,
            middle_top_m,
            high_end_top_m,
            low_end_share,
            middle_share,
            self.side_shares.on_ends,
            self.side_shares.on_sides,
            self.rough_share,
            fourth_root(self.n_points),
            // Points lie the wider apart the farther they are.
            fourth_root(self.n_points * self.range_m * self.range_m),
            n_beyond_ends / (n_beyond_ends + self.n_points),
            self.surroundings.occupied_share,
        ]
    }
}

/// Buffers for describing one object after another.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleDescriber {
    library: PrototypeLibrary,
    points: BoxFramePoints,
    profile: SideProfile,
    squares: RoughnessSquares,
}

impl VehicleDescriber {
    /// Compares profiles with those of `library`, in the same columns.
    pub fn new(library: PrototypeLibrary) -> Self {
        let profile = SideProfile::new(library.column_m());
        Self { library, points: BoxFramePoints::default(), profile, squares: RoughnessSquares::default() }
    }

    /// What profiles are compared with.
    pub fn library(&self) -> &PrototypeLibrary {
        &self.library
    }

    /// The features of an object with these points, in the sensor frame, and with these surroundings. `None` without points.
    pub fn describe(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<VehicleFeatures> {
        vectorised(Description { describer: self, bounding_box, surroundings, positions_m })
    }

    #[inline(always)]
    fn features(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<VehicleFeatures> {
        self.points.fill(bounding_box, positions_m);
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        let spheres = CornerSpheres::around(&self.points, length_m, width_m)?;
        let nearest = self.library.nearest(self.profile.concave_contour(&self.points));
        let [center_x_m, center_y_m, center_z_m] = bounding_box.center_m;
        let center_above_m = center_z_m - surroundings.ground_m;
        Some(VehicleFeatures {
            length_m,
            width_m,
            radii: spheres.ordered(),
            profile_difference: nearest.map_or(1.0, |it| it.difference),
            elevation: ElevationSpread::of(&self.points, center_above_m)?,
            side_shares: SideShares::of(&self.points, length_m, width_m)?,
            view_cosine: view_cosine(bounding_box),
            thirds: LengthwiseThirds::of(&self.points, length_m, center_above_m)?,
            rough_share: self.squares.rough_share(&self.points, length_m, width_m)?,
            n_points: self.points.up_m().len() as f32,
            range_m: (center_x_m * center_x_m + center_y_m * center_y_m).sqrt(),
            surroundings: *surroundings,
        })
    }
}

/// One object to be described.
struct Description<'a, P> {
    describer: &'a mut VehicleDescriber,
    bounding_box: &'a OrientedBox,
    surroundings: &'a Surroundings,
    positions_m: P,
}

impl<P: ExactSizeIterator<Item = [f32; 3]>> HotLoop for Description<'_, P> {
    type Output = Option<VehicleFeatures>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.describer.features(self.bounding_box, self.surroundings, self.positions_m)
    }
}

/// Cosine between the line of sight and the length of the box, without its sign; 1 above and below the sensor.
fn view_cosine(bounding_box: &OrientedBox) -> f32 {
    let [x, y, _] = bounding_box.center_m;
    let range_m = (x * x + y * y).sqrt();
    let (sin, cos) = single::sin_cos(bounding_box.yaw_rad);
    if range_m > 0.0 { ((cos * x + sin * y) / range_m).abs().min(1.0) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Points on the outline of a car, cut out at the height of the silhouette, and the box around them.
    fn car(yaw_rad: f32, center_m: [f32; 3]) -> (OrientedBox, Vec<[f32; 3]>) {
        let library = PrototypeLibrary::drawn();
        let contour_m = library.prototypes()[1].contour_m.clone();
        let [low, high] = [0, 1].map(|axis| {
            contour_m
                .iter()
                .map(|it| it[axis])
                .fold([f32::MAX, f32::MIN], |[low, high], it| [low.min(it), high.max(it)])
        });
        let length_width_height_m = [low[1] - low[0], 1.8, high[1] - high[0]];
        let bounding_box = OrientedBox { center_m, length_width_height_m, yaw_rad };
        let (sin, cos) = yaw_rad.sin_cos();
        let point = |&[along, up]: &[f32; 2], across: f32| {
            let [along, up] = [along - 0.5 * (low[0] + low[1]), up - 0.5 * (high[0] + high[1])];
            [
                center_m[0] + cos * along - sin * across,
                center_m[1] + sin * along + cos * across,
                center_m[2] + up,
            ]
        };
        let sides = [-0.9, 0.9].into_iter();
        let positions_m =
            sides.flat_map(|across| contour_m.iter().map(move |it| point(it, across))).collect();
        (bounding_box, positions_m)
    }

    #[test]
    fn names_and_values_belong_together() {
        let radii = OrderedRadii { front_m: [0.3, 0.5], back_m: [0.1, 0.1] };
        let shares_above = [0.9, 0.6, 0.2];
        let elevation =
            ElevationSpread { bottom_m: 0.2, top_m: 1.5, mean_m: 0.8, deviation_m: 0.4, shares_above };
        let it = VehicleFeatures {
            length_m: 4.0,
            width_m: 1.8,
            radii,
            profile_difference: 0.07,
            elevation,
            side_shares: SideShares { on_ends: 0.2, on_sides: 0.7 },
            view_cosine: 0.9,
            thirds: LengthwiseThirds { tops_m: [0.9, 1.5, 1.4], shares: [0.3, 0.5, 0.2] },
            rough_share: 0.15,
            n_points: 81.0,
            range_m: 10.0,
            surroundings: Surroundings { ground_m: -1.7, n_beyond_ends: 27, occupied_share: 0.25 },
        };
        let value =
            |name: &str| it.values()[VehicleFeatures::NAMES.iter().position(|it| *it == name).unwrap()];
        assert_eq!(value("length_m"), it.length_m);
        assert_eq!(value("front_far_radius_m"), 0.5);
        assert_eq!(value("back_near_radius_m"), 0.1);
        assert!((value("radius_difference_m") - 0.3).abs() < 1e-6);
        assert_eq!(value("profile_difference"), 0.07);
        assert_eq!(value("top_m"), 1.5);
        assert_eq!(value("elevation_deviation_m"), 0.4);
        assert_eq!(value("view_cosine"), 0.9);
        assert_eq!(value("share_above_1.1_m"), 0.6);
        assert_eq!([value("low_end_top_m"), value("high_end_top_m"), value("middle_share")], [0.9, 1.4, 0.5]);
        assert_eq!([value("on_sides_share"), value("rough_share")], [0.7, 0.15]);
        assert_eq!(value("root_n_points"), 3.0);
        assert!((value("root_seen_area") - 90.0_f32.sqrt()).abs() < 1e-5);
        assert_eq!([value("beyond_ends_share"), value("occupied_share")], [0.25, 0.25]);
    }

    #[test]
    fn no_points_have_no_features() {
        let (bounding_box, _) = car(0.0, [0.0; 3]);
        let mut describer = VehicleDescriber::new(PrototypeLibrary::drawn());
        assert_eq!(describer.describe(&bounding_box, &Surroundings::default(), std::iter::empty()), None);
    }

    #[test]
    fn the_view_is_along_or_across_whichever_way_the_box_faces() {
        let seen = |center_m: [f32; 3], yaw_rad: f32| {
            view_cosine(&OrientedBox { center_m, length_width_height_m: [4.0, 2.0, 1.5], yaw_rad })
        };
        assert_eq!(seen([10.0, 0.0, 0.0], 0.0), 1.0);
        assert!((seen([10.0, 0.0, 0.0], std::f32::consts::PI) - 1.0).abs() < 1e-6);
        assert!(seen([0.0, -7.0, 0.0], 0.0).abs() < 1e-6);
        assert!((seen([5.0, 5.0, 0.0], 0.0) - 0.5_f32.sqrt()).abs() < 1e-6);
        assert_eq!(seen([0.0, 0.0, 1.0], 0.3), 1.0);
    }

    proptest! {
        #[test]
        fn the_features_of_a_car_hold_wherever_it_stands(
            yaw_rad in -1.5_f32..1.5, x in -40.0_f32..40.0, y in -40.0_f32..40.0, turn in any::<bool>(),
        ) {
            let mut describer = VehicleDescriber::new(PrototypeLibrary::drawn());
            let mut describe = |(mut bounding_box, positions_m): (OrientedBox, Vec<[f32; 3]>), turn: bool| {
                // The box does not know which end is the front.
                bounding_box.yaw_rad += if turn { std::f32::consts::PI } else { 0.0 };
                let ground_m = bounding_box.center_m[2] - 0.8;
                let surroundings = Surroundings { ground_m, ..Surroundings::default() };
                describer.describe(&bounding_box, &surroundings, positions_m.into_iter()).unwrap().values()
            };
            let here = describe(car(0.0, [0.0; 3]), false);
            let there = describe(car(yaw_rad, [x, y, -0.9]), turn);
            // Where it is seen from, from how far, and squares that points on their borders may leave.
            let changes = ["view_cosine", "root_seen_area", "rough_share"];
            let values = VehicleFeatures::NAMES.iter().zip(here.iter().zip(there));
            for (name, (a, b)) in values.filter(|(name, _)| !changes.contains(name)) {
                prop_assert!((a - b).abs() < 0.02, "{name}: {a} against {b}");
            }
            prop_assert!(here[7] < 0.03, "unlike itself by {}", here[7]);
            prop_assert!(here[6] > 0.1, "the bonnet falls away: {}", here[6]);
        }
    }
}
