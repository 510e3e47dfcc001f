//! The boxes that detectors put around the points of an object.

use detector::OrientedBox;
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::fit::outline_box::{OutlineBox, box_along};
use detector::fit::principal_axes_box::principal_axes_box;
use detector::portable_math::single::sin_cos;
use reports::vocabulary::named::named;

named! {
    /// A way to fit a box: the paper's and its rival's first.
    pub enum ObjectBox {
        /// Closest to the convex hull, as the hierarchical detector does it (VM section 4).
        ConvexHull = "hull box",
        /// Along the principal axes, as its rival does it (VM section 1, \[5\]).
        PrincipalAxes = "PCA box",
        /// Closest to all points, in steps of a degree (Zhang et al. 2017, *Efficient L-shape fitting for vehicle
        /// detection*).
        Closeness = "closeness box",
        /// Along the outline that the sensor sees, as `hierarchical` does it.
        Outline = "outline box",
    }
}

impl ObjectBox {
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
            Self::Closeness => closeness_box(positions_m),
            Self::Outline => OutlineBox::default().fit(positions_m),
        }
    }
}

/// Points nearer to a side than this count as this far away, in metres.
const LEAST_DISTANCE_M: f64 = 0.01;

/// Box along the direction, in whole degrees, that maximizes the sum over all points of one over the distance to the nearest
/// side. `None` without points.
fn closeness_box(positions_m: &[[f32; 3]]) -> Option<OrientedBox> {
    let closeness = |along: [f32; 2]| -> f64 {
        let [cos, sin] = along.map(f64::from);
        let positions = || {
            positions_m
                .iter()
                .map(|it| it.map(f64::from))
                .map(|[x, y, _]| [x * cos + y * sin, y * cos - x * sin])
        };
        let ends = positions().fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], it| {
            [[0, 1].map(|axis| low[axis].min(it[axis])), [0, 1].map(|axis| high[axis].max(it[axis]))]
        });
        let distance_m = |it: [f64; 2]| {
            let to_ends = [0, 1].map(|axis| (it[axis] - ends[0][axis]).min(ends[1][axis] - it[axis]));
            to_ends[0].min(to_ends[1]).max(LEAST_DISTANCE_M)
        };
        positions().map(|it| 1.0 / distance_m(it)).sum()
    };
    let directions = (0..90_u8).map(|degrees| {
        let (sin, cos) = sin_cos(f32::from(degrees).to_radians());
        [cos, sin]
    });
    let best =
        directions.map(|it| (closeness(it), it)).reduce(|best, it| if it.0 > best.0 { it } else { best })?;
    (!positions_m.is_empty()).then(|| box_along(best.1, positions_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sides_of_a_car_have_their_corner_in_the_hull_box_and_turn_the_other() {
        // A car as a sensor at the origin sees it: 40 points on the long side, 18 on the short one.
        let side = (0_u8..40).map(|it| [5.0 + f32::from(it) / 10.0, 2.0, -1.0]);
        let end = (0_u8..18).map(|it| [5.0, 2.0 + f32::from(it) / 10.0, 0.4]);
        let seen: Vec<[f32; 3]> = side.chain(end).collect();
        let [hull, pca, closeness, outline] = ObjectBox::ALL.map(|it| it.around(&seen).unwrap());
        assert!(hull.yaw_rad.abs() < 1e-5, "{hull:?}");
        assert!((hull.length_width_height_m[0] - 3.9).abs() < 1e-4, "{hull:?}");
        assert!(pca.yaw_rad.abs() > 0.05, "{pca:?}");
        assert_eq!(hull.length_width_height_m[2], pca.length_width_height_m[2]);
        for it in [closeness, outline] {
            assert!(it.yaw_rad.abs() < 1e-5 && (it.length_width_height_m[0] - 3.9).abs() < 1e-4, "{it:?}");
        }
        assert_eq!(ObjectBox::ALL.map(|it| it.around(&[])), [None; 4]);
    }
}
