//! An object together with the points that completion found for it.

use crate::oriented_box::OrientedBox;
use crate::point_cloud::PointCloud;

/// Writes the points `own` and `added` to `all`, ascending as both are; they have none in common.
pub fn merge_points(mut own: &[u32], added: impl Iterator<Item = u32>, all: &mut Vec<u32>) {
    all.clear();
    for point_idx in added {
        // Rarely more than some points away, so that a search by halves would take longer.
        let n_before = own.iter().position(|it| *it > point_idx).unwrap_or(own.len());
        let (before, behind) = own.split_at(n_before);
        all.extend_from_slice(before);
        all.push(point_idx);
        own = behind;
    }
    all.extend_from_slice(own);
}

/// `bounding_box`, made high enough for the points `added` of `cloud`. Its ground plan stays: they lie beside it by no more
/// than [`growth_m`](super::completion::CompletionParams::growth_m).
pub fn box_with_points(
    mut bounding_box: OrientedBox,
    cloud: &PointCloud,
    added: impl Iterator<Item = u32>,
) -> OrientedBox {
    for point_idx in added {
        include(&mut bounding_box, cloud.z_m()[point_idx as usize]);
    }
    bounding_box
}

/// Makes a box high enough for a point at this elevation.
fn include(bounding_box: &mut OrientedBox, z_m: f32) {
    let (center_m, height_m) = (&mut bounding_box.center_m[2], &mut bounding_box.length_width_height_m[2]);
    let (low_m, high_m) = (*center_m - 0.5 * *height_m, *center_m + 0.5 * *height_m);
    if z_m < low_m || z_m > high_m {
        let (low_m, high_m) = (low_m.min(z_m), high_m.max(z_m));
        (*center_m, *height_m) = (0.5 * (low_m + high_m), high_m - low_m);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_merged_in_ascending_order() {
        #[track_caller]
        fn check(own: &[u32], added: &[u32], expected: &[u32]) {
            let mut all = vec![99];
            merge_points(own, added.iter().copied(), &mut all);
            assert_eq!(all, expected);
        }
        check(&[2, 5, 6], &[0, 3, 4, 9], &[0, 2, 3, 4, 5, 6, 9]);
        check(&[2, 5], &[], &[2, 5]);
        check(&[], &[1, 2], &[1, 2]);
    }

    #[test]
    fn a_box_grows_down_to_the_wheels_and_stays_where_points_are_inside() {
        let body =
            OrientedBox { center_m: [8.0, 3.0, -0.5], length_width_height_m: [4.0, 1.8, 1.0], yaw_rad: 0.3 };
        let cloud: PointCloud = [[8.0, 3.0, -1.5], [8.0, 3.0, -0.7]].into_iter().collect();
        let grown = box_with_points(body, &cloud, [0].into_iter());
        assert_eq!((grown.center_m, grown.length_width_height_m), ([8.0, 3.0, -0.75], [4.0, 1.8, 1.5]));
        assert_eq!(box_with_points(body, &cloud, [1].into_iter()), body);
    }
}
