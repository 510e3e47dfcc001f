//! Coordinates as exact as an eye can tell them apart: fewer digits and fewer corners are fewer bytes.

/// How coordinates are rounded; the default leaves them as they are.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rounding {
    /// A power of two, so that the last bytes of a rounded coordinate are zero.
    step_m: Option<f32>,
}

impl Rounding {
    /// To the multiples of a power of two that is at most `step_m` metres.
    pub fn finer_than(step_m: f32) -> Self {
        Self { step_m: Some(step_m.log2().floor().exp2()) }
    }

    /// The nearest coordinate in metres that is drawn.
    pub fn coordinate_m(self, coordinate_m: f32) -> f32 {
        self.step_m.map_or(coordinate_m, |step_m| (coordinate_m / step_m).round() * step_m)
    }

    /// The nearest position in metres that is drawn.
    pub fn position_m(self, position_m: [f32; 3]) -> [f32; 3] {
        position_m.map(|it| self.coordinate_m(it))
    }

    /// The line through `corners_m`, rounded, without those that lie less than a step beside it (Ramer 1972, Douglas and
    /// Peucker 1973).
    pub fn line_m(self, corners_m: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut kept = vec![self.step_m.is_none(); corners_m.len()];
        if let (Some(step_m), [first, .., last]) = (self.step_m, &mut kept[..]) {
            (*first, *last) = (true, true);
            keep_bends(corners_m, step_m, &mut kept);
        }
        let kept = corners_m.iter().zip(kept).filter(|(_, is_kept)| *is_kept);
        kept.map(|(&corner_m, _)| self.position_m(corner_m)).collect()
    }
}

/// Marks the corners between the first and the last that are needed to stay within `step_m` of each.
fn keep_bends(corners_m: &[[f32; 3]], step_m: f32, kept: &mut [bool]) {
    let [from_m, between_m @ .., to_m] = corners_m else { return };
    let distances = between_m.iter().map(|it| distance_m(*it, [*from_m, *to_m]));
    let Some((index, farthest_m)) = distances.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b)) else {
        return;
    };
    if farthest_m >= step_m {
        let bend = index + 1;
        kept[bend] = true;
        keep_bends(&corners_m[..=bend], step_m, &mut kept[..=bend]);
        keep_bends(&corners_m[bend..], step_m, &mut kept[bend..]);
    }
}

/// Distance of a position from the piece of a line between two ends.
fn distance_m(position_m: [f32; 3], [from_m, to_m]: [[f32; 3]; 2]) -> f32 {
    let minus = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|axis| a[axis] - b[axis]);
    let dot = |a: [f32; 3], b: [f32; 3]| -> f32 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (along, to) = (minus(to_m, from_m), minus(position_m, from_m));
    let share =
        if dot(along, along) > 0.0 { (dot(to, along) / dot(along, along)).clamp(0.0, 1.0) } else { 0.0 };
    let beside = minus(to, along.map(|it| share * it));
    dot(beside, beside).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_OF_64: f32 = 1.0 / 64.0;

    #[test]
    fn steps_are_powers_of_two() {
        assert_eq!(Rounding::finer_than(0.025), Rounding { step_m: Some(STEP_OF_64) });
        assert_eq!(Rounding::finer_than(STEP_OF_64), Rounding { step_m: Some(STEP_OF_64) });
        assert_eq!(Rounding::finer_than(0.025).coordinate_m(-10.01), -10.015_625);
        assert_eq!(Rounding::default().position_m([0.1, 0.2, -0.3]), [0.1, 0.2, -0.3]);
    }

    #[test]
    fn corners_on_a_straight_line_are_left_out() {
        let stairs = [[0.0; 3], [1.0, 0.0, 0.001], [2.0, 0.0, 0.0], [2.0, 0.0, 0.5], [2.0, 0.0, 1.0]];
        let drawn = Rounding::finer_than(0.025).line_m(&stairs);
        assert_eq!(drawn, [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 0.0, 1.0]]);
        assert_eq!(Rounding::default().line_m(&stairs), stairs);
        assert_eq!(Rounding::finer_than(0.025).line_m(&stairs[..2]), [[0.0; 3], [1.0, 0.0, 0.0]]);
        assert!(Rounding::finer_than(0.025).line_m(&[]).is_empty());
    }

    #[test]
    fn a_closed_line_stays_closed_and_near_its_corners() {
        let circle: Vec<[f32; 3]> = (0..=90)
            .map(|corner| (corner as f32 / 90.0 * std::f32::consts::TAU).sin_cos())
            .map(|(sin, cos)| [cos, sin, 0.0])
            .collect();
        let drawn = Rounding::finer_than(0.025).line_m(&circle);
        assert_eq!(drawn.first(), drawn.last());
        assert!((10..40).contains(&drawn.len()), "{}", drawn.len());
        let pieces: Vec<[[f32; 3]; 2]> = drawn.windows(2).map(|it| [it[0], it[1]]).collect();
        for corner in circle {
            let nearest_m = pieces.iter().map(|it| distance_m(corner, *it)).fold(f32::INFINITY, f32::min);
            assert!(nearest_m < 2.0 * STEP_OF_64, "{nearest_m}");
        }
    }
}
