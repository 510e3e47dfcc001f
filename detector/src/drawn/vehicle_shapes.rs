//! The shapes that the features of objects were taken from.

use crate::describe::box_frame_points::{BoxFramePoints, extent_m};
use crate::describe::corner_spheres::CornerSpheres;
use crate::describe::prototype_library::PrototypeLibrary;
use crate::describe::side_profile::SideProfile;
use crate::fit::convex_hull::convex_hull;
use crate::fit::fitted_objects::{FittedObject, FittedObjects};
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::stage;
use crate::stage_product::{ProductSphere, Shape, StageProduct};

/// Spheres at the upper corners, side profiles, and the nearest prototypes in `library` of `fitted`. Objects without points
/// are left out.
///
/// Profiles stand on the vertical plane through the middle of the box along its length.
pub fn vehicle_shapes(library: &PrototypeLibrary, fitted: &FittedObjects) -> Vec<StageProduct> {
    let mut profile = SideProfile::new(library.column_m());
    let mut points = BoxFramePoints::default();
    let (mut spheres, mut convex, mut concave, mut nearest) = (vec![], vec![], vec![], vec![]);
    for FittedObject { bounding_box, members, .. } in &fitted.objects {
        points.fill(bounding_box, fitted.members.positions_m(members).iter().copied());
        let Some(of_corners) = corner_spheres(bounding_box, &points) else { continue };
        let upright = |contour_m: &[[f32; 2]]| on_main_plane(bounding_box, contour_m);
        let concave_m = profile.concave_contour(&points);
        spheres.extend(of_corners);
        convex.push(upright(&convex_contour(&points)));
        concave.push(upright(concave_m));
        nearest.extend(library.nearest(concave_m).map(|it| upright(&library.placed(&it, concave_m))));
    }
    let product = |name, shape| StageProduct { stage: stage::FEATURES, name, shape };
    vec![
        product("corner_spheres", Shape::Spheres(spheres)),
        product("convex_profiles", Shape::Contours(convex)),
        product("concave_profiles", Shape::Contours(concave)),
        product("nearest_prototypes", Shape::Contours(nearest)),
    ]
}

/// Spheres from each upper corner to the nearest point; `None` without points.
fn corner_spheres(bounding_box: &OrientedBox, points: &BoxFramePoints) -> Option<[ProductSphere; 4]> {
    let [length_m, width_m, _] = bounding_box.length_width_height_m;
    let spheres = CornerSpheres::around(points, length_m, width_m)?;
    let [_, top_m] = extent_m(points.up_m())?;
    let corners_m = bounding_box.footprint_m();
    Some(std::array::from_fn(|corner| {
        let [x_m, y_m] = corners_m[corner];
        let center_m = [x_m, y_m, bounding_box.center_m[2] + top_m];
        ProductSphere { center_m, radius_m: spheres.radii_m[corner] }
    }))
}

/// The convex contour of `points` on the same plane as the concave one: corners (along, up) in metres, counter-clockwise.
///
/// Paper: VM section 4. It is drawn for comparison with the concave one; the classifier does not use it.
fn convex_contour(points: &BoxFramePoints) -> Vec<[f32; 2]> {
    let mut points_m: Vec<[f32; 2]> =
        points.along_m().iter().zip(points.up_m()).map(|(&along, &up)| [along, up]).collect();
    let mut hull_m = Vec::new();
    convex_hull(&mut points_m, &mut hull_m);
    hull_m
}

fn on_main_plane(bounding_box: &OrientedBox, contour_m: &[[f32; 2]]) -> Vec<[f32; 3]> {
    let (sin, cos) = single::sin_cos(bounding_box.yaw_rad);
    let [x, y, z] = bounding_box.center_m;
    contour_m.iter().map(|&[along, up]| [x + cos * along, y + sin * along, z + up]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::prototype_library::tests::library;

    fn contours(products: &[StageProduct], name: &str) -> Vec<Vec<[f32; 3]>> {
        let product = products.iter().find(|it| it.name == name).unwrap();
        let Shape::Contours(contours) = &product.shape else { panic!("{name} are no contours") };
        contours.clone()
    }

    #[test]
    fn the_convex_profile_bridges_a_notch_and_the_concave_one_goes_into_it() {
        let bounding_box =
            OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        let notched = [[0.0, 0.0], [0.0, 1.0], [0.3, 0.0], [0.3, 0.4], [0.6, 0.0], [0.6, 1.0]];
        let points = (0..).zip(notched).map(|(point_idx, [along, up])| (point_idx, [along, 0.3, up]));
        let mut fitted = FittedObjects::default();
        fitted.add(points, bounding_box, &[]);
        let products = vehicle_shapes(&library(), &fitted);
        assert_eq!(
            contours(&products, "convex_profiles"),
            [[[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [0.6, 0.0, 1.0], [0.0, 0.0, 1.0]]]
        );
        let [concave_m] = &contours(&products, "concave_profiles")[..] else { panic!("one object") };
        assert!(concave_m.contains(&[0.3, 0.0, 0.4]), "{concave_m:?}");
    }

    #[test]
    fn what_has_no_points_is_not_drawn() {
        let bounding_box =
            OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        let mut fitted = FittedObjects::default();
        fitted.add(std::iter::empty(), bounding_box, &[]);
        let products = vehicle_shapes(&library(), &fitted);
        assert!(contours(&products, "concave_profiles").is_empty());
    }
}
