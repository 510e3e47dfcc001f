//! The values by which the rival of the vehicle model tells a vehicle from background.

use detector::OrientedBox;
use detector::describe::box_frame_points::BoxFramePoints;

use crate::neighborhood_shapes::{MOST_SAMPLES, N_BINS, NeighborhoodShapes, RADIUS_M, ShapeHistograms};

/// What the classifier sees of an object: its size, and how its points lie in their neighbourhoods.
///
/// Paper: VM section 6, \[5\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PcaFeatures {
    /// Height of the box.
    pub height_m: f32,
    /// Extent along the main axis.
    pub length_m: f32,
    /// Extent across it.
    pub width_m: f32,
    /// Histograms over the neighbourhoods.
    pub shapes: ShapeHistograms,
}

/// Number of values.
pub const N_PCA_FEATURES: usize = PcaFeatures::NAMES.len();

impl PcaFeatures {
    /// The names of [`Self::values`], as in files; bins by where they begin.
    pub const NAMES: [&'static str; 3 + 3 * N_BINS] = [
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

    /// The values in the order of [`Self::NAMES`].
    pub fn values(&self) -> [f32; N_PCA_FEATURES] {
        let ShapeHistograms { scatterness, linearness, surfacedness } = self.shapes;
        let mut values = [0.0; N_PCA_FEATURES];
        let histograms = scatterness.into_iter().chain(linearness).chain(surfacedness);
        let all = [self.height_m, self.length_m, self.width_m].into_iter().chain(histograms);
        for (value, it) in values.iter_mut().zip(all) {
            *value = it;
        }
        values
    }
}

/// Buffers for describing one object after another.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PcaDescriber {
    points: BoxFramePoints,
    shapes: NeighborhoodShapes,
}

impl PcaDescriber {
    /// What decides the values beside the points, as trained models record it.
    pub fn constants() -> toml::Table {
        let radius_m = ("neighborhood_radius_m".to_owned(), f64::from(RADIUS_M).into());
        let most_samples = ("most_samples".to_owned(), (MOST_SAMPLES as i64).into());
        [radius_m, most_samples].into_iter().collect()
    }

    /// The features of an object with these points, in the sensor frame; `bounding_box` lies along its main axis. `None`
    /// without points.
    pub fn describe(
        &mut self,
        bounding_box: &OrientedBox,
        positions_m: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Option<PcaFeatures> {
        if positions_m.len() == 0 {
            return None;
        }
        self.points.fill(bounding_box, positions_m);
        let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
        let shapes = self.shapes.describe(&self.points, length_m);
        Some(PcaFeatures { height_m, length_m, width_m, shapes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_values_belong_together() {
        let shapes = ShapeHistograms {
            scatterness: [0.1, 0.2, 0.3, 0.4],
            linearness: [0.5, 0.6, 0.7, 0.8],
            surfacedness: [0.9, 1.0, 1.1, 1.2],
        };
        let it = PcaFeatures { height_m: 1.5, length_m: 4.0, width_m: 1.8, shapes };
        let value = |name: &str| it.values()[PcaFeatures::NAMES.iter().position(|it| *it == name).unwrap()];
        assert_eq!(["height_m", "length_m", "width_m"].map(value), [1.5, 4.0, 1.8]);
        assert_eq!([value("scatterness_from_0"), value("scatterness_from_0.75")], [0.1, 0.4]);
        assert_eq!([value("linearness_from_0.5"), value("surfacedness_from_0.75")], [0.7, 1.2]);
    }

    #[test]
    fn no_points_have_no_features() {
        let bounding_box = OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        assert_eq!(PcaDescriber::default().describe(&bounding_box, std::iter::empty()), None);
    }
}
