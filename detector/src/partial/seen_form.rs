//! What form all has that is seen of an object, from every point of it.

use super::level_spread::LevelSpread;
use super::seen_extents::SeenExtents;

/// Lengths of what is seen of an object, in metres, and how much it leans. All points count, because thinning would
/// take the edge off thin things.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SeenForm {
    /// Its extents.
    pub extents: SeenExtents,
    /// How its points spread on the ground plan.
    pub spread: LevelSpread,
    /// The same of the lowest sixth of its height.
    pub foot: LevelSpread,
    /// The same of the fourth sixth from below.
    pub middle: LevelSpread,
    /// The same of the highest sixth.
    pub head: LevelSpread,
    /// How far it goes aside for each metre upward, by the line that fits its points best.
    pub lean: f64,
}

/// Level slices that its height is cut into.
const N_SLICES: f64 = 6.0;
/// Slices with fewer points have no spread.
const LEAST_POINTS: usize = 3;
/// What is not higher counts as so high, in metres.
const LEAST_HEIGHT_M: f64 = 1e-3;
/// Added to the squares of heights, so that what is level does not lean, in square metres.
const LEVEL_M2: f64 = 1e-6;

impl SeenForm {
    /// That of some points; nothing without any. Not in the papers.
    pub fn of(points_m: impl Iterator<Item = [f64; 3]> + Clone) -> Self {
        let spread = LevelSpread::of(points_m.clone());
        let extents = SeenExtents::with_spread(spread, points_m.clone());
        let height_m = (extents.top_m - extents.bottom_m).max(LEAST_HEIGHT_M);
        let slice = |number: f64| {
            let [low_m, high_m] =
                [number, number + 1.0].map(|it| extents.bottom_m + height_m * it / N_SLICES);
            let inside = points_m.clone().filter(move |[_, _, z]| (low_m..=high_m).contains(z));
            if inside.clone().nth(LEAST_POINTS - 1).is_none() {
                return LevelSpread::default();
            }
            LevelSpread::of(inside)
        };
        Self {
            extents,
            spread,
            foot: slice(0.0),
            middle: slice(3.0),
            head: slice(N_SLICES - 1.0),
            lean: lean(points_m),
        }
    }

    /// Height of what is seen, from its bottom to its top, in metres.
    pub fn height_m(&self) -> f64 {
        self.extents.top_m - self.extents.bottom_m
    }
}

fn lean(points_m: impl Iterator<Item = [f64; 3]> + Clone) -> f64 {
    let (mut n, mut sum_z) = (0.0_f64, 0.0);
    for [_, _, z] in points_m.clone() {
        n += 1.0;
        sum_z += z;
    }
    let mean_z = sum_z / n.max(1.0);
    let (mut with_x, mut with_y, mut squares) = (0.0, 0.0, LEVEL_M2);
    let Some([first_x, first_y, _]) = points_m.clone().next() else { return 0.0 };
    for [x, y, z] in points_m {
        let z = z - mean_z;
        with_x += z * (x - first_x);
        with_y += z * (y - first_y);
        squares += z * z;
    }
    (with_x * with_x + with_y * with_y).sqrt() / squares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board 1 m wide at the foot and 3 m at the head, 6 m high, which moves aside by `lean` metres a metre.
    fn board(lean: f64) -> Vec<[f64; 3]> {
        let row = |z: u32| {
            let half_m = if z >= 50 { 1.5 } else { 0.5 };
            [-1.0, 0.0, 1.0].map(|side| [7.0 + half_m * side, lean * f64::from(z) * 0.1, f64::from(z) * 0.1])
        };
        (0..=60).flat_map(row).collect()
    }

    #[test]
    fn foot_and_head_are_measured_by_themselves() {
        let form = SeenForm::of(board(0.0).into_iter());
        let lengths_m = [form.foot, form.middle, form.head, form.spread].map(|it| it.length_m);
        assert_eq!(lengths_m, [1.0, 1.0, 3.0, 3.0]);
        assert!((form.height_m() - 6.0).abs() < 1e-12 && form.spread.width_m == 0.0);
        assert!((form.foot.deviation_along_m - (0.25_f64 / 1.5).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_goes_aside_leans() {
        for lean in [0.0, 0.1, 0.5] {
            let found = SeenForm::of(board(lean).into_iter()).lean;
            assert!((found - lean).abs() < 1e-6, "{found} {lean}");
        }
    }

    #[test]
    fn slices_of_few_points_have_no_spread_and_nothing_has_no_form() {
        let form = SeenForm::of([[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 5.0]].into_iter());
        assert_eq!([form.foot, form.middle, form.head], [LevelSpread::default(); 3]);
        assert_eq!(SeenForm::of(std::iter::empty()), SeenForm::default());
    }
}
