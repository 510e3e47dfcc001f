//! Possible errors in the position of labels, given as the changes that correct them.

use std::f32::consts::{FRAC_PI_2, PI};
use std::fmt;

use detector::OrientedBox;

/// A change of all boxes at once. Lengths in metres, angles in radians, counter-clockwise seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Correction {
    /// Length and width are swapped.
    SwapSides,
    /// The yaw gets the other sign.
    NegateYaw,
    /// The yaw counts clockwise from the left, as KITTI's `rotation_y`.
    YawFromLeft,
    /// The yaw is in degrees.
    YawFromDegrees,
    /// All yaws turn by this angle.
    Yaw(f32),
    /// Lengths and widths are multiplied.
    Scale(f32),
    /// Centres and yaws turn about the sensor.
    Turn(f32),
    /// Left and right are swapped.
    Mirror,
    /// x and y are swapped.
    ExchangeAxes,
    /// All boxes move by this vector, along x and y of the sensor.
    Shift([f32; 2]),
    /// Each box moves by this vector, to its own front and left.
    OwnShift([f32; 2]),
    /// The boxes are those of the scan after, or of the one before.
    OtherScan {
        /// Whether they are those of the scan after.
        is_next: bool,
    },
}

/// Origin of boxes: what may be wrong with all of them at once depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrawnBy {
    /// Labels: boxes fit their objects, unless something is wrong with all.
    People,
    /// Results of a detector, whose boxes may be a little too large, turned or off in all scans.
    Detector,
}

impl DrawnBy {
    /// Whether all boxes at once may need `correction`, for a reason other than a weakness of the detector.
    pub fn may_need(self, correction: Correction) -> bool {
        match (self, correction) {
            (Self::Detector, Correction::Scale(_) | Correction::OwnShift(_) | Correction::Yaw(_)) => false,
            (Self::Detector, Correction::Turn(by_rad)) => by_rad.to_degrees().abs() >= 4.0,
            (Self::Detector, Correction::Shift(by_m)) => by_m[0].hypot(by_m[1]) >= 0.8,
            (Self::People | Self::Detector, _) => true,
        }
    }
}

impl Correction {
    /// Whether boxes keep their size, and can be compared by the points in them.
    pub fn keeps_size(self) -> bool {
        !matches!(self, Self::Scale(_))
    }

    /// The box with this change.
    pub fn of(self, labelled: &OrientedBox) -> OrientedBox {
        let mut it = *labelled;
        let [x_m, y_m, _] = it.center_m;
        let [length_m, width_m, height_m] = it.length_width_height_m;
        match self {
            Self::SwapSides => it.length_width_height_m = [width_m, length_m, height_m],
            Self::NegateYaw => it.yaw_rad = -it.yaw_rad,
            Self::YawFromLeft => it.yaw_rad = FRAC_PI_2 - it.yaw_rad,
            Self::YawFromDegrees => it.yaw_rad = it.yaw_rad.to_radians(),
            Self::Yaw(by_rad) => it.yaw_rad += by_rad,
            Self::Scale(factor) => it.length_width_height_m = [factor * length_m, factor * width_m, height_m],
            Self::Turn(by_rad) => {
                let (sin, cos) = by_rad.sin_cos();
                (it.center_m[0], it.center_m[1]) = (cos * x_m - sin * y_m, sin * x_m + cos * y_m);
                it.yaw_rad += by_rad;
            }
            Self::Mirror => (it.center_m[1], it.yaw_rad) = (-y_m, -it.yaw_rad),
            Self::ExchangeAxes => {
                (it.center_m[0], it.center_m[1], it.yaw_rad) = (y_m, x_m, FRAC_PI_2 - it.yaw_rad);
            }
            Self::Shift([by_x_m, by_y_m]) => {
                (it.center_m[0], it.center_m[1]) = (x_m + by_x_m, y_m + by_y_m);
            }
            Self::OwnShift([along_m, across_m]) => {
                let (sin, cos) = it.yaw_rad.sin_cos();
                it.center_m[0] += cos * along_m - sin * across_m;
                it.center_m[1] += sin * along_m + cos * across_m;
            }
            Self::OtherScan { .. } => {}
        }
        it
    }

    /// Whether it is so large that carefully drawn boxes do not need it: they are larger than vehicles by a tenth, and lie
    /// 0.2 m off.
    pub fn is_large(self) -> bool {
        let degrees = |it: f32| it.to_degrees().abs() + 1e-3;
        match self {
            Self::Yaw(by_rad) => degrees(by_rad) >= 4.0,
            Self::Turn(by_rad) => degrees(by_rad) >= 1.0,
            Self::Scale(factor) => !(0.81..1.19).contains(&factor),
            Self::Shift(by_m) | Self::OwnShift(by_m) => by_m[0].hypot(by_m[1]) >= 0.3,
            _ => true,
        }
    }

    /// How the labels look, and how to correct them.
    fn words(self) -> [String; 2] {
        // No minus zero.
        let round = |it: f32| (it * 100.0).round() / 100.0 + 0.0;
        let metres = |[a, b]: [f32; 2]| format!("({:+.2}, {:+.2}) m", round(a), round(b));
        let degrees = |it: f32| format!("{:+.1} degrees", round(it.to_degrees()));
        let [looks, mend] = match self {
            Self::SwapSides => ["length and width are swapped", "swap length and width in the labels"],
            Self::NegateYaw => ["yaws have the wrong sign", "change the sign of every yaw in the labels"],
            Self::YawFromLeft => [
                "yaws count clockwise from the left, as KITTI's rotation_y",
                "write pi/2 minus the yaw for every yaw in the labels",
            ],
            Self::YawFromDegrees => ["yaws are in degrees", "write every yaw in radians"],
            Self::Mirror => ["left and right are exchanged", "change the signs of y and yaw in the labels"],
            Self::ExchangeAxes => {
                ["x and y are exchanged", "exchange x and y in the labels, and write pi/2 minus the yaw"]
            }
            Self::OtherScan { is_next: true } => {
                ["labels are a scan late", "give each scan the labels that the scan after it has now"]
            }
            Self::OtherScan { is_next: false } => {
                ["labels are a scan early", "give each scan the labels that the scan before it has now"]
            }
            Self::Yaw(by_rad) => {
                return [
                    format!("yaws are off by {}", degrees(-by_rad)),
                    format!("add {} ({by_rad:+.3} rad) to every yaw in the labels", degrees(by_rad)),
                ];
            }
            Self::Scale(factor) => {
                return [
                    format!("boxes are {:.2} times as long and wide as vehicles", 1.0 / factor),
                    format!("multiply lengths and widths in the labels by {factor:.2}"),
                ];
            }
            Self::Turn(by_rad) => {
                return [
                    format!("boxes are turned about the sensor by {}", degrees(-by_rad)),
                    format!("turn centres and yaws in the labels by {} about the sensor", degrees(by_rad)),
                ];
            }
            Self::Shift(by_m) => {
                let off = metres(by_m.map(|it| -it));
                return [
                    format!("boxes are off by {off} in x and y of the sensor"),
                    format!("add {} to every centre in the labels", metres(by_m)),
                ];
            }
            Self::OwnShift(by_m) => {
                let off = metres(by_m.map(|it| -it));
                return [
                    format!("boxes are off by {off} to their own front and left, so these may be no centres"),
                    format!("move every centre in the labels by {} to its front and left", metres(by_m)),
                ];
            }
        };
        [looks, mend].map(str::to_owned)
    }

    /// The turns, mirror images and exchanges that move boxes away from their labelled places.
    pub const ELSEWHERE: [Self; 5] =
        [Self::Turn(FRAC_PI_2), Self::Turn(-FRAC_PI_2), Self::Turn(PI), Self::Mirror, Self::ExchangeAxes];
}

impl fmt::Display for Correction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [looks, mend] = self.words();
        write!(formatter, "it looks as if {looks}: {mend}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_opposite_change_leads_back() {
        let car =
            OrientedBox { center_m: [8.0, -3.0, -0.9], length_width_height_m: [4.0, 1.8, 1.5], yaw_rad: 0.4 };
        for [there, back] in [
            [Correction::SwapSides, Correction::SwapSides],
            [Correction::NegateYaw, Correction::NegateYaw],
            [Correction::YawFromLeft, Correction::YawFromLeft],
            [Correction::Mirror, Correction::Mirror],
            [Correction::ExchangeAxes, Correction::ExchangeAxes],
            [Correction::Yaw(0.3), Correction::Yaw(-0.3)],
            [Correction::Turn(0.3), Correction::Turn(-0.3)],
            [Correction::Scale(2.0), Correction::Scale(0.5)],
            [Correction::Shift([1.0, -2.0]), Correction::Shift([-1.0, 2.0])],
            [Correction::OwnShift([1.0, -2.0]), Correction::OwnShift([-1.0, 2.0])],
        ] {
            let moved = there.of(&car);
            assert_ne!(moved, car, "{there:?}");
            let home = back.of(&moved);
            for (a, b) in home.footprint_m().into_iter().zip(car.footprint_m()) {
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-5, "{there:?}: {home:?}");
            }
        }
    }

    #[test]
    fn words_say_how_far_off_labels_are_and_what_mends_them() {
        let words = |it: Correction| it.to_string();
        assert_eq!(
            words(Correction::Shift([-0.5, 0.0])),
            "it looks as if boxes are off by (+0.50, +0.00) m in x and y of the sensor: add (-0.50, +0.00) m to every \
             centre in the labels"
        );
        assert!(
            words(Correction::Turn(-5_f32.to_radians())).contains("turned about the sensor by +5.0 degrees")
        );
        assert!(words(Correction::Scale(0.5)).contains("2.00 times as long and wide"));
        assert!(!Correction::Turn(0.01).is_large() && Correction::Turn(0.02).is_large());
        assert!(!Correction::Scale(0.9).is_large() && Correction::Scale(0.8).is_large());
    }
}
