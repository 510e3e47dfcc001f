//! The values that distinguish vehicles from background.

use super::elevation_spread::ElevationSpread;
use super::height_slices::{HeightSlices, N_SLICES};

use super::lengthwise_thirds::LengthwiseThirds;
use super::object_describer::ObjectDescriber;
use super::paper_features::PaperDescriber;
use super::prototype_library::PrototypeLibrary;
use super::side_shares::SideShares;
use super::surface_roughness::RoughnessSquares;
use super::surroundings::Surroundings;
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::vector_instructions::{HotLoop, vectorised};

/// Number of values that the vehicle model looks at.
pub const N_FEATURES: usize = 28 + 2 * N_SLICES;

/// The names of the values that the classifier sees of an object, as in files.
///
/// The first eight values are the paper's. The others add height, values that distinguish a shell from a filled volume and
/// leaves from metal, the seen side of the object and how much of it is seen, and the surroundings.
///
/// Paper: VM section 5.
pub const VEHICLE_FEATURES: [&str; N_FEATURES] = joined(
    PaperDescriber::NAMES,
    [
        // Where its points are above the ground.
        "bottom_m",
        "top_m",
        "mean_elevation_m",
        "elevation_deviation_m",
        // Of the angle between the line of sight and the length of the box, without its sign: 1 if an end is seen, 0 if a
        // side is.
        "view_cosine",
        "share_above_0.5_m",
        "share_above_1.1_m",
        "share_above_1.4_m",
        // How it is built from end to end.
        "low_end_top_m",
        "middle_top_m",
        "high_end_top_m",
        "low_end_share",
        "middle_share",
        // How much of it lies on the sides of its box, and far from flat sides.
        "on_ends_share",
        "on_sides_share",
        "rough_share",
        // Its number of points; and the area they stand for: points lie wider apart the farther they are.
        "root_n_points",
        "root_seen_area",
        // Its surroundings.
        "beyond_ends_share",
        "occupied_share",
        // Its extent in slices of 0.35 m, from the ground up.
        "length_of_slice_0_m",
        "length_of_slice_1_m",
        "length_of_slice_2_m",
        "length_of_slice_3_m",
        "length_of_slice_4_m",
        "length_of_slice_5_m",
        "width_of_slice_0_m",
        "width_of_slice_1_m",
        "width_of_slice_2_m",
        "width_of_slice_3_m",
        "width_of_slice_4_m",
        "width_of_slice_5_m",
    ],
);

/// `first` and `second`, one behind the other.
pub(crate) const fn joined<T: Copy, const M: usize, const N: usize, const BOTH: usize>(
    first: [T; M],
    second: [T; N],
) -> [T; BOTH] {
    let mut both = [first[0]; BOTH];
    let mut index = 0;
    while index < M + N {
        both[index] = if index < M { first[index] } else { second[index - M] };
        index += 1;
    }
    both
}

/// Buffers for describing one object after another.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleDescriber {
    of_paper: PaperDescriber,
    squares: RoughnessSquares,
}

impl VehicleDescriber {
    /// Compares profiles with those of `library`, in the same columns.
    pub fn new(library: PrototypeLibrary) -> Self {
        Self { of_paper: PaperDescriber::new(library), squares: RoughnessSquares::default() }
    }

    /// The prototypes that profiles are compared with.
    pub fn library(&self) -> &PrototypeLibrary {
        self.of_paper.library()
    }

    /// The values of [`VEHICLE_FEATURES`] of an object with these points, in the sensor frame, and with these surroundings.
    /// `None` without points.
    pub fn describe(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_FEATURES]> {
        vectorised(Description { describer: self, bounding_box, surroundings, positions_m })
    }

    #[inline(always)]
    fn values(
        &mut self,
        bounding_box: &OrientedBox,
        surroundings: &Surroundings,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_FEATURES]> {
        let of_paper = self.of_paper.values(bounding_box, positions_m)?;
        let points = self.of_paper.points();
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        let [center_x_m, center_y_m, center_z_m] = bounding_box.center_m;
        let center_above_m = center_z_m - surroundings.ground_m;
        let elevation = ElevationSpread::of(points, center_above_m)?;
        let on = SideShares::of(points, length_m, width_m)?;
        let thirds = LengthwiseThirds::of(points, length_m, center_above_m)?;
        let HeightSlices { lengths_m, widths_m } = HeightSlices::of(points, center_above_m);
        let n_points = points.up_m().len() as f32;
        let range_m = (center_x_m * center_x_m + center_y_m * center_y_m).sqrt();
        let n_beyond_ends = surroundings.n_beyond_ends as f32;
        let fourth_root = |it: f32| it.sqrt().sqrt();
        let beyond_paper = [
            elevation.bottom_m,
            elevation.top_m,
            elevation.mean_m,
            elevation.deviation_m,
            view_cosine(bounding_box),
            elevation.shares_above[0],
            elevation.shares_above[1],
            elevation.shares_above[2],
            thirds.tops_m[0],
            thirds.tops_m[1],
            thirds.tops_m[2],
            thirds.shares[0],
            thirds.shares[1],
            on.on_ends,
            on.on_sides,
            self.squares.rough_share(points, length_m, width_m)?,
            fourth_root(n_points),
            fourth_root(n_points * range_m * range_m),
            n_beyond_ends / (n_beyond_ends + n_points),
            surroundings.occupied_share,
        ];
        let slices: [f32; 2 * N_SLICES] = joined(lengths_m, widths_m);
        let beyond_paper: [f32; N_FEATURES - PaperDescriber::NAMES.len()] = joined(beyond_paper, slices);
        Some(joined(of_paper, beyond_paper))
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
    type Output = Option<[f32; N_FEATURES]>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.describer.values(self.bounding_box, self.surroundings, self.positions_m)
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
    use crate::describe::prototype_library::Prototype;
    use crate::describe::trained_file::Provenance;
    use proptest::prelude::*;

    /// How high a saloon is, every 0.2 m from its back to its front.
    const SALOON_TOPS_M: [f32; 24] = [
        0.97, 0.99, 1.01, 1.06, 1.16, 1.27, 1.37, 1.44, 1.44, 1.44, 1.43, 1.43, 1.42, 1.42, 1.34, 1.21, 1.08,
        0.95, 0.89, 0.86, 0.82, 0.79, 0.75, 0.72,
    ];

    /// The silhouette of a saloon.
    fn saloon_m() -> impl Iterator<Item = [f32; 2]> + Clone {
        let column = |(column, &top_m): (usize, &f32)| [0.2 * column as f32 - 2.3, top_m];
        let tops_m = SALOON_TOPS_M.iter().enumerate().map(column);
        tops_m.clone().map(|[along, _]| [along, 0.23]).chain(tops_m.rev())
    }

    fn describer() -> VehicleDescriber {
        let prototype = Prototype { name: "saloon".to_owned(), contour_m: saloon_m().collect() };
        // In columns of 0.2 m, every point is on the border of two: its place decides which one it is in.
        VehicleDescriber::new(PrototypeLibrary::new(Provenance::default(), 0.19, vec![prototype]).unwrap())
    }

    /// Points on the outline of a car, cut out at the height of the silhouette, and the box around them.
    fn car(yaw_rad: f32, center_m: [f32; 3]) -> (OrientedBox, Vec<[f32; 3]>) {
        let bounding_box = OrientedBox { center_m, length_width_height_m: [4.6, 1.8, 1.21], yaw_rad };
        let (sin, cos) = yaw_rad.sin_cos();
        let [x, y, z] = center_m;
        let point = |[along, up]: [f32; 2], across: f32| {
            [x + cos * along - sin * across, y + sin * along + cos * across, z + up - 0.835]
        };
        let positions_m =
            [-0.9, 0.9].into_iter().flat_map(|across| saloon_m().map(move |it| point(it, across)));
        (bounding_box, positions_m.collect())
    }

    #[test]
    fn names_and_values_belong_together() {
        let (bounding_box, positions_m) = car(0.0, [10.0, 0.0, -0.9]);
        let surroundings = Surroundings { ground_m: -1.735, n_beyond_ends: 32, occupied_share: 0.125 };
        let values = describer().describe(&bounding_box, &surroundings, positions_m.into_iter()).unwrap();
        for (name, wanted) in [
            ("length_m", 4.6),
            ("width_m", 1.8),
            ("profile_difference", 0.0),
            ("bottom_m", 0.23),
            ("top_m", 1.44),
            ("view_cosine", 1.0),
            ("share_above_1.4_m", 14.0 / 96.0),
            ("low_end_top_m", 1.08),
            ("high_end_top_m", 1.44),
            ("middle_share", 1.0 / 3.0),
            ("on_sides_share", 1.0),
            ("root_n_points", 96.0_f32.sqrt().sqrt()),
            ("root_seen_area", 9600.0_f32.sqrt().sqrt()),
            ("beyond_ends_share", 0.25),
            ("occupied_share", 0.125),
        ] {
            let value = values[VEHICLE_FEATURES.iter().position(|it| *it == name).unwrap()];
            assert!((value - wanted).abs() < 0.03, "{name}: {value} against {wanted}");
        }
    }

    #[test]
    fn no_points_have_no_features() {
        let (bounding_box, _) = car(0.0, [0.0; 3]);
        let mut describer = describer();
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
            let mut describer = describer();
            let mut describe = |(mut bounding_box, positions_m): (OrientedBox, Vec<[f32; 3]>), turn: bool| {
                // The box does not know which end is the front.
                bounding_box.yaw_rad += if turn { std::f32::consts::PI } else { 0.0 };
                let ground_m = bounding_box.center_m[2] - 0.8;
                let surroundings = Surroundings { ground_m, ..Surroundings::default() };
                describer.describe(&bounding_box, &surroundings, positions_m.into_iter()).unwrap()
            };
            let here = describe(car(0.0, [0.0; 3]), false);
            let there = describe(car(yaw_rad, [x, y, -0.9]), turn);
            // The side and the distance it is seen from, and squares that points on their borders may leave.
            let changes = ["view_cosine", "root_seen_area", "rough_share"];
            let values = VEHICLE_FEATURES.iter().zip(here.iter().zip(there));
            for (name, (a, b)) in values.filter(|(name, _)| !changes.contains(name)) {
                prop_assert!((a - b).abs() < 0.02, "{name}: {a} against {b}");
            }
            prop_assert!(here[7] < 0.03, "unlike itself by {}", here[7]);
            prop_assert!(here[6] > 0.1, "the bonnet falls away: {}", here[6]);
        }
    }
}
