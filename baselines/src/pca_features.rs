//! The values by which the rival of the vehicle model distinguishes vehicles from background.

use detector::OrientedBox;
use detector::describe::box_frame_points::BoxFramePoints;
use detector::describe::object_describer::ObjectDescriber;

use crate::neighborhood_shapes::{MOST_SAMPLES, N_BINS, NeighborhoodShapes, RADIUS_M, ShapeHistograms};

/// Number of values.
pub const N_PCA_FEATURES: usize = 3 + 3 * N_BINS;

/// The values that the classifier sees of an object: its size, and how its points lie in their neighbourhoods. With buffers
/// for one object after another.
///
/// Paper: VM section 6, \[5\].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PcaDescriber {
    points: BoxFramePoints,
    shapes: NeighborhoodShapes,
}

impl PcaDescriber {
    /// The constants that the values depend on, as trained models record them.
    pub fn constants() -> toml::Table {
        let radius_m = ("neighborhood_radius_m".to_owned(), f64::from(RADIUS_M).into());
        let most_samples = ("most_samples".to_owned(), (MOST_SAMPLES as i64).into());
        [radius_m, most_samples].into_iter().collect()
    }
}

impl ObjectDescriber<N_PCA_FEATURES> for PcaDescriber {
    /// The name of a bin holds its lower bound.
    const NAMES: [&'static str; N_PCA_FEATURES] = [
        "height_m",
        "length_m",
        "width_m",
        "scatterness_from_0",
        "scatterness_from_0.25",
        "scatterness_from_0.5",
        "scatterness_from_0.75",
        "linearness_from_0",
        "linearness_from_0.25",
        "linearness_from_0.5",
        "linearness_from_0.75",
        "surfacedness_from_0",
        "surfacedness_from_0.25",
        "surfacedness_from_0.5",
        "surfacedness_from_0.75",
    ];

    /// `bounding_box` lies along the main axis of the object.
    fn describe(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<[f32; N_PCA_FEATURES]> {
        if positions_m.len() == 0 {
            return None;
        }
        self.points.fill(bounding_box, positions_m);
        let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
        let ShapeHistograms { scatterness, linearness, surfacedness } =
            self.shapes.describe(&self.points, length_m);
        let size_m = [height_m, length_m, width_m];
        let mut all = size_m.iter().chain(&scatterness).chain(&linearness).chain(&surfacedness);
        Some(std::array::from_fn(|_| *all.next().expect("as many as there are names")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_values_belong_together() {
        let bounding_box =
            OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 1.8, 1.5], yaw_rad: 0.0 };
        let row = (0..400).map(|it| [0.01 * it as f32 - 2.0, 0.0, 0.0]);
        let values = PcaDescriber::default().describe(&bounding_box, row).unwrap();
        let value = |name: &str| values[PcaDescriber::NAMES.iter().position(|it| *it == name).unwrap()];
        assert_eq!(["height_m", "length_m", "width_m"].map(value), [1.5, 4.0, 1.8]);
        assert_eq!(
            ["scatterness_from_0", "linearness_from_0.75", "surfacedness_from_0"].map(value),
            [1.0, 1.0, 1.0]
        );
    }

    #[test]
    fn no_points_have_no_features() {
        let bounding_box = OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        assert_eq!(PcaDescriber::default().describe(&bounding_box, std::iter::empty()), None);
    }
}
