//! The boxes that detectors put around the points of an object.

use detector::OrientedBox;
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::fit::principal_axes_box::principal_axes_box;

/// A way to fit a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ObjectBox {
    /// Closest to the convex hull, as the hierarchical detector does it (VM section 4).
    ConvexHull,
    /// Along the principal axes, as its rival does it (VM section 1, \[5\]).
    PrincipalAxes,
}

impl ObjectBox {
    /// Both, the method's first.
    pub const ALL: [Self; 2] = [Self::ConvexHull, Self::PrincipalAxes];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::ConvexHull => "hull box",
            Self::PrincipalAxes => "PCA box",
        }
    }

    /// The box around finite points. `None` without points.
    pub fn around(self, positions_m: &[[f32; 3]]) -> Option<OrientedBox> {
        match self {
            Self::ConvexHull => {
                let heights_m = positions_m.iter().map(|it| it[2]);
                let z_range_m = heights_m
                    .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
                ConvexHullBox::default().fit(positions_m.iter().map(|&[x, y, _]| [x, y]), z_range_m)
            }
            Self::PrincipalAxes => principal_axes_box(positions_m.iter().copied()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sides_of_a_car_have_their_corner_in_the_hull_box_and_turn_the_other() {
        // What a sensor at the origin sees of a car: 40 points on the long side, 18 on the short one.
        let side = (0_u8..40).map(|it| [5.0 + f32::from(it) / 10.0, 2.0, -1.0]);
        let end = (0_u8..18).map(|it| [5.0, 2.0 + f32::from(it) / 10.0, 0.4]);
        let seen: Vec<[f32; 3]> = side.chain(end).collect();
        let [hull, pca] = ObjectBox::ALL.map(|it| it.around(&seen).unwrap());
        assert!(hull.yaw_rad.abs() < 1e-5, "{hull:?}");
        assert!((hull.length_width_height_m[0] - 3.9).abs() < 1e-4, "{hull:?}");
        assert!(pca.yaw_rad.abs() > 0.05, "{pca:?}");
        assert_eq!(hull.length_width_height_m[2], pca.length_width_height_m[2]);
        assert_eq!(ObjectBox::ALL.map(|it| it.around(&[])), [None, None]);
    }
}
