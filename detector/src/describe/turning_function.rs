//! Difference between the directions of two closed contours.

use std::f32::consts::{PI, TAU};

use crate::portable_math::{self, single};

/// Parts of equal length that a contour is divided into.
const N_PARTS: usize = 32;
/// Contours are shifted against each other by up to half a turn to either side.
const MAX_SHIFT: i32 = N_PARTS as i32 / 2;

/// Shifts that are tried at once.
const N_AT_ONCE: usize = 16;

/// The direction of a closed contour along its length. It does not depend on position, size and start of the contour.
///
/// It does depend on the orientation: up stays up. (Arkin et al. 1991 compare shapes that may be turned as well.)
#[derive(Debug, Clone, PartialEq)]
pub struct TurningFunction {
    /// Mean direction within each part in radians, counter-clockwise from the first axis; adds up over the turns. From
    /// half a turn before the start to half a turn after the end, so that shifting needs no wrapping.
    directions_rad: [f32; 2 * N_PARTS],
    /// Mean direction from start to end.
    mean_rad: f32,
}

impl TurningFunction {
    /// The turning function of the contour through `corners`, which is closed from the last to the first.
    ///
    /// Neither the start nor the sense of rotation matters. `None` if the contour does not wind around an area once:
    /// of fewer than three corners, without area, crossing itself, or not finite.
    ///
    /// Paper: VM section 4, reference 13.
    pub fn of(corners: &[[f32; 2]]) -> Option<Self> {
        let area: f64 = edges(corners, 0).map(|(a, b)| cross(a, b)).sum();
        if !area.is_finite() || area == 0.0 {
            return None;
        }
        // Always from the same corner and counter-clockwise, so that sums round alike.
        let by_position = |a: &(usize, &[f32; 2]), b: &(usize, &[f32; 2])| {
            a.1[0].total_cmp(&b.1[0]).then(a.1[1].total_cmp(&b.1[1]))
        };
        let (start, _) = corners.iter().enumerate().min_by(by_position)?;
        if area > 0.0 {
            Self::along(edges(corners, start))
        } else {
            let n = corners.len();
            let backwards = (0..n)
                .map(move |step| (corners[(start + n - step) % n], corners[(start + 2 * n - step - 1) % n]));
            Self::along(backwards)
        }
    }

    /// The turning function of edges that wind counter-clockwise.
    fn along(edges: impl Iterator<Item = ([f32; 2], [f32; 2])> + Clone) -> Option<Self> {
        let vectors = edges.map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).filter(|it| *it != [0.0, 0.0]);
        let length: f32 = vectors.clone().map(|[x, y]| single::hypot(x, y)).sum();
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        let mut directions_rad = [0.0; N_PARTS];
        let first = vectors.clone().next()?;
        let (mut previous, mut direction_rad) = (first, single::atan2(first[1], first[0]));
        // In parts of the contour.
        let mut at = 0.0;
        for vector in vectors {
            direction_rad += turn_rad(previous, vector);
            let until = at + single::hypot(vector[0], vector[1]) / length * N_PARTS as f32;
            add_edge(&mut directions_rad, [at, until], direction_rad);
            (previous, at) = (vector, until);
        }
        let total_rad = direction_rad + turn_rad(previous, first) - single::atan2(first[1], first[0]);
        // Whole turns, but for rounding.
        if (total_rad - TAU).abs() > 0.1 {
            return None;
        }
        let mean_rad = directions_rad.iter().sum::<f32>() / N_PARTS as f32;
        let directions_rad: [f32; 2 * N_PARTS] = std::array::from_fn(|idx| {
            let index = idx as i32 - MAX_SHIFT;
            let turns = index.div_euclid(N_PARTS as i32);
            directions_rad[index.rem_euclid(N_PARTS as i32) as usize] + turns as f32 * TAU
        });
        Some(Self { directions_rad, mean_rad })
    }

    /// The difference of two contours in 0 to 1: the root mean square of the angle between their directions, as a share
    /// of half a turn, for the best of all shifts by whole parts along the contour.
    pub fn distance(&self, other: &Self) -> f32 {
        self.distance_below(other, f32::INFINITY).unwrap_or(1.0)
    }

    /// [`Self::distance`] if it is below `bound`. The lower the bound, the faster this is.
    #[inline(always)]
    pub fn distance_below(&self, other: &Self, bound: f32) -> Option<f32> {
        // Least sum of squares over the parts.
        let least_sum = |mean_difference_rad: f32| N_PARTS as f32 * mean_difference_rad * mean_difference_rad;
        let mut least = least_sum(bound * PI);
        let mut found = false;
        // A shift by one part changes the difference of the means by one part of a turn, and no sum of squares is below
        // that of the mean. So shifts count only near the one for which the means agree.
        let part_rad = TAU / N_PARTS as f32;
        let ahead_rad = self.mean_rad - other.mean_rad;
        let middle = (ahead_rad / part_rad).round() as i32;
        let first_shift = (middle - N_AT_ONCE as i32 / 2).clamp(-MAX_SHIFT, MAX_SHIFT + 1 - N_AT_ONCE as i32);
        let sums = self.sums_of_squares::<N_AT_ONCE>(other, first_shift);
        for away in 0..=2 * MAX_SHIFT {
            let mut is_promising = false;
            for shift in [middle + away, middle - away] {
                if least_sum(ahead_rad - shift as f32 * part_rad) >= least {
                    continue;
                }
                is_promising = true;
                if (-MAX_SHIFT..=MAX_SHIFT).contains(&shift) {
                    let near = sums.get((shift - first_shift) as usize).copied();
                    let sum = near.unwrap_or_else(|| self.sums_of_squares::<1>(other, shift)[0]);
                    if sum < least {
                        least = sum;
                        found = true;
                    }
                }
            }
            if !is_promising {
                break;
            }
        }
        found.then(|| ((least / N_PARTS as f32).sqrt() / PI).min(1.0))
    }

    /// Sums of squares between our parts and those of `other`, for `N` shifts from `first_shift` on within half a turn.
    #[inline(always)]
    fn sums_of_squares<const N: usize>(&self, other: &Self, first_shift: i32) -> [f32; N] {
        // Added up eight parts apart and then together, whatever `N` is.
        const N_APART: usize = 8;
        let theirs = &other.directions_rad[(MAX_SHIFT + first_shift) as usize..];
        let mut totals = [0.0; N];
        for first_part in 0..N_APART {
            let mut sums = [0.0; N];
            for part in (first_part..N_PARTS).step_by(N_APART) {
                let ours = self.directions_rad[MAX_SHIFT as usize + part];
                let theirs: &[f32; N] =
                    theirs[part..].first_chunk().expect("the shifts are within half a turn");
                for step in 0..N {
                    let difference = ours - theirs[step];
                    sums[step] += difference * difference;
                }
            }
            for step in 0..N {
                totals[step] += sums[step];
            }
        }
        totals
    }
}

fn edges(corners: &[[f32; 2]], start: usize) -> impl Iterator<Item = ([f32; 2], [f32; 2])> + Clone {
    let n = corners.len();
    (0..n).map(move |step| (corners[(start + step) % n], corners[(start + step + 1) % n]))
}

fn cross(a: [f32; 2], b: [f32; 2]) -> f64 {
    f64::from(a[0]) * f64::from(b[1]) - f64::from(a[1]) * f64::from(b[0])
}

/// The angle from `a` to `b` in (−π, π]; straight back is a turn to the left.
fn turn_rad(a: [f32; 2], b: [f32; 2]) -> f32 {
    let sine = cross(a, b);
    let cosine = f64::from(a[0]) * f64::from(b[0]) + f64::from(a[1]) * f64::from(b[1]);
    // −0 counts as 0, whose angle to the negative axis is π.
    portable_math::atan2(sine, cosine) as f32
}

/// Adds an edge from position `from` to position `until`, in parts, to the means of the parts it runs through.
fn add_edge(directions_rad: &mut [f32; N_PARTS], [from, until]: [f32; 2], direction_rad: f32) {
    let first = (from as usize).min(N_PARTS - 1);
    let last = (until as usize).min(N_PARTS - 1);
    for (part, mean_rad) in directions_rad.iter_mut().enumerate().take(last + 1).skip(first) {
        let share = until.min(part as f32 + 1.0) - from.max(part as f32);
        *mean_rad += share.max(0.0) * direction_rad;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn function(corners: &[[f32; 2]]) -> TurningFunction {
        TurningFunction::of(corners).unwrap()
    }

    const SQUARE: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn contours_without_an_area_have_none() {
        for corners in [
            &[][..],
            &[[1.0, 1.0]],
            &[[0.0, 0.0], [1.0, 1.0]],
            &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]],
            &[[0.0, 0.0], [f32::NAN, 1.0], [2.0, 0.0]],
            &[[0.0, 0.0], [f32::INFINITY, 1.0], [2.0, 0.0]],
            // A figure eight with one lobe larger than the other winds around both, in two senses.
            &[[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 2.0]],
        ] {
            assert_eq!(TurningFunction::of(corners), None, "{corners:?}");
        }
    }

    #[test]
    fn a_square_turns_by_a_quarter_at_each_quarter() {
        let square = function(&SQUARE);
        for (part, direction_rad) in square.directions_rad[N_PARTS / 2..][..N_PARTS].iter().enumerate() {
            let quarter = (part / (N_PARTS / 4)) as f32;
            assert!((direction_rad - quarter * TAU / 4.0).abs() < 1e-5, "part {part}: {direction_rad}");
        }
    }

    #[test]
    fn a_square_on_its_corner_is_an_eighth_of_a_turn_away() {
        let on_its_corner = [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];
        let distance = function(&SQUARE).distance(&function(&on_its_corner));
        // Every direction is off by 45 of 180 degrees, whichever sides are compared.
        assert!((distance - 0.25).abs() < 1e-5, "{distance}");
    }

    /// Contours that wind once: around the origin, corner by corner.
    fn star() -> impl Strategy<Value = Vec<[f32; 2]>> {
        let reach = prop::collection::vec(4_u8..40, 5..30);
        reach.prop_map(|reach| {
            let n = reach.len() as f32;
            let corner = |(idx, &reach): (usize, &u8)| {
                let angle_rad = TAU * idx as f32 / n;
                // On a lattice, so that moving and doubling is exact.
                [angle_rad.cos(), angle_rad.sin()].map(|it| (it * f32::from(reach) * 64.0).round())
            };
            reach.iter().enumerate().map(corner).collect()
        })
    }

    fn mirrored(corners: &[[f32; 2]]) -> Vec<[f32; 2]> {
        corners.iter().map(|&[x, y]| [-x, y]).collect()
    }

    proptest! {
        #[test]
        fn start_sense_position_and_size_do_not_matter(
            corners in star(), start in 0_usize..30, dx in -4096_i16..4096, dy in -4096_i16..4096,
        ) {
            let original = function(&corners);
            let mut turned = corners.clone();
            turned.rotate_left(start % corners.len());
            prop_assert_eq!(&function(&turned), &original);
            turned.reverse();
            prop_assert_eq!(&function(&turned), &original);
            let moved: Vec<[f32; 2]> = corners.iter().map(|&[x, y]| [x + f32::from(dx), y + f32::from(dy)]).collect();
            prop_assert_eq!(&function(&moved), &original);
            let doubled: Vec<[f32; 2]> = corners.iter().map(|it| it.map(|it| 2.0 * it)).collect();
            prop_assert_eq!(&function(&doubled), &original);
            let scaled: Vec<[f32; 2]> = corners.iter().map(|it| it.map(|it| 0.37 * it)).collect();
            prop_assert!(function(&scaled).distance(&original) < 1e-3);
        }

        #[test]
        fn a_corner_more_on_an_edge_changes_nothing(corners in star(), at in 0_usize..30) {
            let at = at % corners.len();
            let next = corners[(at + 1) % corners.len()];
            let mut more = corners.clone();
            more.insert(at + 1, [0, 1].map(|axis| f32::midpoint(corners[at][axis], next[axis])));
            prop_assert!(function(&more).distance(&function(&corners)) < 1e-3);
        }

        #[test]
        fn it_is_a_distance(a in star(), b in star(), c in star()) {
            let [a, b, c] = [a, b, c].map(|it| function(&it));
            let ab = a.distance(&b);
            prop_assert_eq!(a.distance(&a), 0.0);
            prop_assert!((0.0..=1.0).contains(&ab));
            prop_assert!((ab - b.distance(&a)).abs() < 1e-5);
            prop_assert!(ab <= a.distance(&c) + c.distance(&b) + 1e-5);
        }

        #[test]
        fn no_shift_is_better_than_the_one_that_was_found(a in star(), b in star()) {
            let [a, b] = [a, b].map(|it| function(&it));
            let least = (-MAX_SHIFT..=MAX_SHIFT).map(|shift| a.sums_of_squares::<1>(&b, shift)[0]).fold(f32::INFINITY, f32::min);
            let expected = ((least / N_PARTS as f32).sqrt() / PI).min(1.0);
            prop_assert!((a.distance(&b) - expected).abs() < 1e-5);
            prop_assert_eq!(a.distance_below(&b, 0.5 * expected), None);
        }

        #[test]
        fn mirroring_both_changes_little(a in star(), b in star()) {
            let mirrored_distance = function(&mirrored(&a)).distance(&function(&mirrored(&b)));
            // The parts begin elsewhere.
            prop_assert!((function(&a).distance(&function(&b)) - mirrored_distance).abs() < 0.1);
        }
    }
}
