//! How far two rectangles of a plane overlap; they may be rotated against each other.

/// A rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Its centre in metres.
    pub center_m: [f64; 2],
    /// Its sides in metres.
    pub length_width_m: [f64; 2],
    /// Angle of the side `length` from the first axis towards the second.
    pub yaw_rad: f64,
}

impl Rectangle {
    /// Its area in square metres.
    pub fn area_m2(&self) -> f64 {
        self.length_width_m[0] * self.length_width_m[1]
    }

    /// Radius of the circle around it.
    pub fn radius_m(&self) -> f64 {
        self.length_width_m[0].hypot(self.length_width_m[1]) / 2.0
    }

    /// Whether the centres are farther from each other than `reach_m`. If that is the sum of both radii, they have nothing
    /// in common.
    pub fn are_centers_apart(&self, other: &Self, reach_m: f64) -> bool {
        let [x_m, y_m] = [0, 1].map(|axis| self.center_m[axis] - other.center_m[axis]);
        x_m * x_m + y_m * y_m > reach_m * reach_m
    }
}

/// Intersection over union of two sizes that have `common` in common, 0 to 1; 0 if both are empty.
pub fn over_union(common: f64, first: f64, second: f64) -> f64 {
    let union = first + second - common;
    if union > 0.0 { (common / union).clamp(0.0, 1.0) } else { 0.0 }
}

/// Area in square metres that both cover: the second, clipped by the sides of the first in the frame of the first.
///
/// Sutherland, Hodgman: Reentrant Polygon Clipping, 1974.
pub fn common_area_m2(first: &Rectangle, second: &Rectangle) -> f64 {
    let mut corners_m = corners_in_frame_of(first, second).to_vec();
    let [length_m, width_m] = first.length_width_m;
    for (axis, half_m) in [(0, length_m / 2.0), (1, width_m / 2.0)] {
        for side in [1.0, -1.0] {
            corners_m = clipped(&corners_m, |corner_m| half_m - side * corner_m[axis]);
        }
    }
    polygon_area_m2(&corners_m)
}

/// Corners of `it`, counter-clockwise, in the frame in which `frame` is at the origin and heads along the first axis.
fn corners_in_frame_of(frame: &Rectangle, it: &Rectangle) -> [[f64; 2]; 4] {
    let [dx_m, dy_m] = [0, 1].map(|axis| it.center_m[axis] - frame.center_m[axis]);
    let (frame_sin, frame_cos) = frame.yaw_rad.sin_cos();
    let center_m = [frame_cos * dx_m + frame_sin * dy_m, frame_cos * dy_m - frame_sin * dx_m];
    let (sin, cos) = (it.yaw_rad - frame.yaw_rad).sin_cos();
    let [length_m, width_m] = it.length_width_m;
    [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)].map(|(along, across)| {
        let (along_m, across_m) = (along * length_m, across * width_m);
        [center_m[0] + cos * along_m - sin * across_m, center_m[1] + sin * along_m + cos * across_m]
    })
}

/// The part of a convex polygon where `inside_m`, the distance from a line, is not negative.
fn clipped(corners_m: &[[f64; 2]], inside_m: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::with_capacity(corners_m.len() + 1);
    for (corner_idx, &to_m) in corners_m.iter().enumerate() {
        let from_m = corners_m[(corner_idx + corners_m.len() - 1) % corners_m.len()];
        let (from_inside_m, to_inside_m) = (inside_m(from_m), inside_m(to_m));
        if (from_inside_m < 0.0) != (to_inside_m < 0.0) {
            let share = from_inside_m / (from_inside_m - to_inside_m);
            kept.push([0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis])));
        }
        if to_inside_m >= 0.0 {
            kept.push(to_m);
        }
    }
    kept
}

/// Area of a polygon whose corners go counter-clockwise.
fn polygon_area_m2(corners_m: &[[f64; 2]]) -> f64 {
    let mut doubled = 0.0;
    for (corner_idx, [x_m, y_m]) in corners_m.iter().enumerate() {
        let [next_x_m, next_y_m] = corners_m[(corner_idx + 1) % corners_m.len()];
        doubled += x_m * next_y_m - next_x_m * y_m;
    }
    doubled / 2.0
}
