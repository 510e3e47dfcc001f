//! Values of rivals: they describe a cloud as a whole.

use baselines::pca_features::{N_PCA_FEATURES, PcaDescriber};
use detector::PointCloud;
use detector::classify::grouping_model::GroupingModel;
use detector::describe::object_describer::ObjectDescriber as _;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::surroundings::Surroundings;
use detector::describe::vehicle_features::{N_FEATURES, VehicleDescriber};
use detector::partial::seen_extents::SeenExtents;

use crate::object_box::ObjectBox;

/// Number of extents.
pub const N_EXTENTS: usize = 4;
/// Number of values of the vehicle model.
pub const N_VEHICLE_VALUES: usize = N_FEATURES;

/// Length, width, bottom and top of the points, in metres; `None` without points.
pub fn extent_values(cloud: &PointCloud) -> Option<[f32; N_EXTENTS]> {
    let points_m = finite(cloud);
    let points_m: Vec<[f64; 3]> = points_m.into_iter().map(|it| it.map(f64::from)).collect();
    let SeenExtents { bottom_m, top_m, length_m, width_m } = SeenExtents::of(points_m.iter().copied());
    (!points_m.is_empty()).then_some([length_m, width_m, bottom_m, top_m].map(|it| it as f32))
}

/// The values of the rival of the vehicle model; `None` without points.
pub fn pca_values(cloud: &PointCloud) -> Option<[f32; N_PCA_FEATURES]> {
    let points_m = finite(cloud);
    let bounding_box = ObjectBox::PrincipalAxes.around(&points_m)?;
    PcaDescriber::default().describe(&bounding_box, points_m.into_iter())
}

/// The values of our vehicle model for an object without surroundings; `None` without points.
pub fn vehicle_values(cloud: &PointCloud) -> Option<[f32; N_VEHICLE_VALUES]> {
    let points_m = finite(cloud);
    let bounding_box = ObjectBox::ConvexHull.around(&points_m)?;
    let library: PrototypeLibrary = GroupingModel::shipped().library.clone();
    VehicleDescriber::new(library).describe(&bounding_box, &Surroundings::default(), points_m.into_iter())
}

fn finite(cloud: &PointCloud) -> Vec<[f32; 3]> {
    cloud.positions_m().filter(|it| it.iter().all(|value| value.is_finite())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pole_is_tall_and_thin_to_all_of_them() {
        let pole: PointCloud =
            (0..40).map(|it| [0.05 * (it % 2) as f32, 0.05 * (it % 3) as f32, 0.1 * it as f32]).collect();
        let [length_m, width_m, bottom_m, top_m] = extent_values(&pole).unwrap();
        assert!(length_m < 0.2 && width_m < 0.2 && bottom_m == 0.0 && (top_m - 3.9).abs() < 1e-5);
        assert!((pca_values(&pole).unwrap()[0] - 3.9).abs() < 1e-5);
        assert!(vehicle_values(&pole).unwrap()[0] < 0.2);
        let nowhere: PointCloud = [[f32::NAN; 3]].into_iter().collect();
        assert_eq!(
            (extent_values(&nowhere), pca_values(&nowhere), vehicle_values(&nowhere)),
            (None, None, None)
        );
    }
}
