//! The upright box that lies closest to the seen outline of an object.

use crate::fit::convex_hull::convex_hull;
use crate::fit::convex_hull_box::{direction, half_turn_yaw};
use crate::fit::strays::without_strays;
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::vector_instructions::{HotLoop, greater, lesser, vectorised};

/// Azimuths around the sensor whose nearest points are the outline: 0.2 degrees each, on average.
const N_AZIMUTHS: usize = 1800;
/// Most distance that a point of the outline counts, in metres: points that belong to no side count no more than that.
const MOST_DISTANCE_M: f32 = 0.3;
/// Most points that the sides are found by. Of more, every second, third and so on is taken.
const MOST_POINTS: usize = 256;
/// Points beyond a side, of a hundred.
const N_TRIMMED_OF_100: usize = 1;
/// Most points that may lie beyond a side.
const MOST_TRIMMED: usize = MOST_POINTS * N_TRIMMED_OF_100 / 100 + 1;
/// Turns in degrees that are tried from the best edge.
const TURNS_DEG: [f32; 4] = [-2.0, -1.0, 1.0, 2.0];
/// Directions that are tried at the same time.
const N_ABREAST: usize = 16;

/// A box along the seen sides, with buffers for one object after another.
#[derive(Debug, Clone)]
pub struct OutlineBox {
    /// Squared range and index of the nearest point of each azimuth.
    nearest: Vec<(f32, u32)>,
    /// Squared range and azimuth of each point.
    polar: Vec<(f32, u32)>,
    azimuths: Vec<u32>,
    outline_m: Vec<[f32; 2]>,
    hull_points_m: Vec<[f32; 2]>,
    hull_m: Vec<[f32; 2]>,
    taken_m: Vec<[f32; 2]>,
    directions: Vec<[f32; 2]>,
}

impl Default for OutlineBox {
    fn default() -> Self {
        Self {
            nearest: vec![(f32::INFINITY, 0); N_AZIMUTHS],
            polar: Vec::new(),
            azimuths: Vec::new(),
            outline_m: Vec::new(),
            hull_points_m: Vec::new(),
            hull_m: Vec::new(),
            taken_m: Vec::new(),
            directions: Vec::new(),
        }
    }
}

impl OutlineBox {
    /// The box around `positions_m` with its sides along the outline: the points nearest to the sensor, which is the origin,
    /// at each azimuth. The direction is that of the edge of the outline's hull to whose sides these points are closest on
    /// average, or one or two degrees beside it. A point counts at most 0.3 m, and a side is found without the outermost one
    /// of a hundred points. The box itself holds all points but [strays](without_strays).
    ///
    /// Length is the longer side and the yaw lies in (−π/2, π/2]. One point gives a box of no length and no width at yaw 0,
    /// points on a line one along it. `None` without points. All must be finite.
    ///
    /// Instead of the mean distance of the hull's corners (VM section 4), which is the same for a square's corners in any
    /// direction.
    pub fn fit(&mut self, positions_m: &[[f32; 3]]) -> Option<OrientedBox> {
        if positions_m.is_empty() {
            return None;
        }
        self.find_outline(positions_m);
        self.take_points(positions_m);
        let (mut along, mut least_m) = ([1.0, 0.0], f32::INFINITY);
        self.directions.clear();
        let edges = self.hull_m.iter().zip(self.hull_m.iter().cycle().skip(1));
        self.directions.extend(edges.map(|(&from_m, &to_m)| direction(from_m, to_m)));
        self.try_directions(&mut along, &mut least_m);
        // Points on a line lie along it.
        if self.hull_m.len() > 2 {
            let [cos, sin] = along;
            self.directions.clear();
            self.directions.extend(TURNS_DEG.map(|turn_deg| {
                let (s, c) = single::sin_cos(turn_deg.to_radians());
                [cos * c - sin * s, sin * c + cos * s]
            }));
            self.try_directions(&mut along, &mut least_m);
        }
        Some(box_along(along, positions_m))
    }

    fn find_outline(&mut self, positions_m: &[[f32; 3]]) {
        self.azimuths.clear();
        vectorised(Polar { positions_m, polar: &mut self.polar });
        for (index, &(squared, azimuth)) in self.polar.iter().enumerate() {
            let nearest = &mut self.nearest[azimuth as usize];
            if nearest.0 == f32::INFINITY {
                self.azimuths.push(azimuth);
            }
            if squared < nearest.0 {
                *nearest = (squared, index as u32);
            }
        }
        self.outline_m.clear();
        for azimuth in &self.azimuths {
            let (_, index) = std::mem::replace(&mut self.nearest[*azimuth as usize], (f32::INFINITY, 0));
            let [x_m, y_m, _] = positions_m[index as usize];
            self.outline_m.push([x_m, y_m]);
        }
        self.hull_points_m.clear();
        self.hull_points_m.extend_from_slice(&self.outline_m);
        convex_hull(&mut self.hull_points_m, &mut self.hull_m);
    }

    fn take_points(&mut self, positions_m: &[[f32; 3]]) {
        let step = positions_m.len().div_ceil(MOST_POINTS);
        self.taken_m.clear();
        self.taken_m.extend(positions_m.iter().step_by(step).map(|&[x_m, y_m, _]| [x_m, y_m]));
    }

    fn try_directions(&self, best: &mut [f32; 2], least_m: &mut f32) {
        let n_trimmed = self.taken_m.len() * N_TRIMMED_OF_100 / 100;
        for some in self.directions.chunks(N_ABREAST) {
            let along = std::array::from_fn(|lane| some[lane.min(some.len() - 1)]);
            let points = Points { taken_m: &self.taken_m, outline_m: &self.outline_m, n_trimmed };
            let distances_m = vectorised(Distances { points, along });
            for (&along, &distance_m) in some.iter().zip(&distances_m) {
                if distance_m < *least_m {
                    (*best, *least_m) = (along, distance_m);
                }
            }
        }
    }
}

/// The azimuth of a position, one of [`N_AZIMUTHS`]: by the share of y in |x| + |y|, which grows as the angle does and needs
/// no arc tangent.
#[inline(always)]
fn azimuth_of([x_m, y_m]: [f32; 2]) -> u32 {
    let sum_m = x_m.abs() + y_m.abs();
    let share = if sum_m > 0.0 { y_m / sum_m } else { 0.0 };
    let quarters = if x_m >= 0.0 { 1.0 + share } else { 3.0 - share };
    ((quarters * (N_AZIMUTHS as f32 / 4.0)) as u32).min(N_AZIMUTHS as u32 - 1)
}

/// Finds squared range and azimuth of points.
struct Polar<'a> {
    positions_m: &'a [[f32; 3]],
    polar: &'a mut Vec<(f32, u32)>,
}

impl HotLoop for Polar<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let polar_of = |&[x_m, y_m, _]: &[f32; 3]| (x_m * x_m + y_m * y_m, azimuth_of([x_m, y_m]));
        self.polar.clear();
        self.polar.extend(self.positions_m.iter().map(polar_of));
    }
}

/// Points that directions are judged by.
#[derive(Clone, Copy)]
struct Points<'a> {
    taken_m: &'a [[f32; 2]],
    outline_m: &'a [[f32; 2]],
    n_trimmed: usize,
}

/// The mean distance of the outline from the sides along each of some directions.
struct Distances<'a> {
    points: Points<'a>,
    along: [[f32; 2]; N_ABREAST],
}

type Lanes = [f32; N_ABREAST];

/// The least and the greatest numbers of each lane.
struct Extremes {
    least: [Lanes; MOST_TRIMMED],
    greatest: [Lanes; MOST_TRIMMED],
}

impl Extremes {
    #[inline(always)]
    fn new() -> Self {
        Self {
            least: [[f32::INFINITY; N_ABREAST]; MOST_TRIMMED],
            greatest: [[f32::NEG_INFINITY; N_ABREAST]; MOST_TRIMMED],
        }
    }

    /// Adds a number in each lane to its extremes, of which `n_kept` are kept.
    #[inline(always)]
    fn add(&mut self, mut numbers: Lanes, n_kept: usize) {
        let mut others = numbers;
        for index in 0..n_kept {
            let (least, greatest) = (&mut self.least[index], &mut self.greatest[index]);
            for lane in 0..N_ABREAST {
                let (low, high) = (lesser(numbers[lane], least[lane]), greater(numbers[lane], least[lane]));
                (least[lane], numbers[lane]) = (low, high);
                let (low, high) =
                    (lesser(others[lane], greatest[lane]), greater(others[lane], greatest[lane]));
                (greatest[lane], others[lane]) = (high, low);
            }
        }
    }
}

impl HotLoop for Distances<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn run(self) -> Lanes {
        let Self { points: Points { taken_m, outline_m, n_trimmed }, along } = self;
        let [along_x, along_y] = [0, 1].map(|axis| along.map(|it| it[axis]));
        let (mut u_m, mut v_m) = ([0.0; N_ABREAST], [0.0; N_ABREAST]);
        let [mut along_m, mut across_m] = [Extremes::new(), Extremes::new()];
        let n_kept = n_trimmed + 1;
        for &[x_m, y_m] in taken_m {
            for lane in 0..N_ABREAST {
                u_m[lane] = x_m * along_x[lane] + y_m * along_y[lane];
                v_m[lane] = y_m * along_x[lane] - x_m * along_y[lane];
            }
            along_m.add(u_m, n_kept);
            across_m.add(v_m, n_kept);
        }
        let mut sums_m = [0.0; N_ABREAST];
        let sides = |it: &Extremes| [it.least[n_trimmed], it.greatest[n_trimmed]];
        let (along_m, across_m) = (sides(&along_m), sides(&across_m));
        for &[x_m, y_m] in outline_m {
            for lane in 0..N_ABREAST {
                let u_m = x_m * along_x[lane] + y_m * along_y[lane];
                let v_m = y_m * along_x[lane] - x_m * along_y[lane];
                let to_side = |value_m: f32, sides_m: &[Lanes; 2]| {
                    lesser((value_m - sides_m[0][lane]).abs(), (sides_m[1][lane] - value_m).abs())
                };
                let nearest_m = lesser(to_side(u_m, &along_m), to_side(v_m, &across_m));
                sums_m[lane] += lesser(nearest_m, MOST_DISTANCE_M);
            }
        }
        sums_m.map(|it| it / outline_m.len() as f32)
    }
}

/// The box around points, at least one, but [strays](without_strays), with a side along `along`, a unit vector.
pub fn box_along([cos, sin]: [f32; 2], positions_m: &[[f32; 3]]) -> OrientedBox {
    let mut low_m = [f32::INFINITY; 3];
    let mut high_m = [f32::NEG_INFINITY; 3];
    let turned_m = |&[x_m, y_m, z_m]: &[f32; 3]| [x_m * cos + y_m * sin, y_m * cos - x_m * sin, z_m];
    for position_m in positions_m {
        for (axis, it_m) in turned_m(position_m).into_iter().enumerate() {
            low_m[axis] = lesser(it_m, low_m[axis]);
            high_m[axis] = greater(it_m, high_m[axis]);
        }
    }
    for axis in 0..2 {
        let values_m = positions_m.iter().map(|it| turned_m(it)[axis]);
        if let Some(kept_m) = without_strays([low_m[axis], high_m[axis]], values_m) {
            [low_m[axis], high_m[axis]] = kept_m;
        }
    }
    let middle_m: [f32; 3] = std::array::from_fn(|axis| 0.5 * (low_m[axis] + high_m[axis]));
    let [along_m, across_m, height_m] = std::array::from_fn(|axis| high_m[axis] - low_m[axis]);
    let [u_m, v_m, z_m] = middle_m;
    let yaw_rad = single::atan2(sin, cos);
    let (length_m, width_m, yaw_rad) = if along_m >= across_m {
        (along_m, across_m, yaw_rad)
    } else {
        (across_m, along_m, yaw_rad + std::f32::consts::FRAC_PI_2)
    };
    OrientedBox {
        center_m: [u_m * cos - v_m * sin, u_m * sin + v_m * cos, z_m],
        length_width_height_m: [length_m, width_m, height_m],
        yaw_rad: half_turn_yaw(yaw_rad),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn fit(positions_m: &[[f32; 3]]) -> Option<OrientedBox> {
        OutlineBox::default().fit(positions_m)
    }

    /// `n` points from one position to another, both included.
    fn line(from_m: [f32; 2], to_m: [f32; 2], n: u16) -> impl Iterator<Item = [f32; 3]> {
        (0..n).map(move |it| {
            let share = f32::from(it) / f32::from(n - 1);
            let [x_m, y_m] = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
            [x_m, y_m, -1.0]
        })
    }

    #[test]
    fn nothing_has_no_box_and_points_and_lines_have_flat_ones() {
        assert_eq!(fit(&[]), None);
        let point = fit(&[[3.0, 4.0, -1.0]]).unwrap();
        assert_eq!(
            (point.center_m, point.length_width_height_m, point.yaw_rad),
            ([3.0, 4.0, -1.0], [0.0; 3], 0.0)
        );
        assert_eq!(fit(&[[0.0; 3]; 5]).unwrap().length_width_height_m, [0.0; 3]);
        let along: Vec<[f32; 3]> = line([4.0, 1.0], [7.0, 5.0], 30).collect();
        let along = fit(&along).unwrap();
        assert!((along.length_width_height_m[0] - 5.0).abs() < 1e-4 && along.length_width_height_m[1] < 1e-4);
        assert!((along.yaw_rad - 4.0_f32.atan2(3.0)).abs() < 1e-4, "{along:?}");
    }

    #[test]
    fn a_square_is_no_diamond() {
        // Its corners all lie on the square that is turned by half a right angle: the corners of the hull show nothing.
        let corners_m = [[6.0, 4.0], [8.0, 4.0], [8.0, 6.0], [6.0, 6.0]];
        let sides = (0..4).flat_map(|it| line(corners_m[it], corners_m[(it + 1) % 4], 40));
        let square = fit(&sides.collect::<Vec<_>>()).unwrap();
        assert!((square.length_width_height_m[0] - 2.0).abs() < 1e-3, "{square:?}");
        assert!((2.0 * square.yaw_rad).sin().abs() < 1e-3, "{square:?}");
    }

    #[test]
    fn a_mirror_and_a_stray_point_turn_nothing() {
        let body = line([6.0, 2.0], [10.4, 2.0], 100).chain(line([6.0, 2.0], [6.0, 3.8], 60));
        let mut positions_m: Vec<[f32; 3]> = body.collect();
        positions_m.push([9.0, 1.75, -0.6]);
        let car = fit(&positions_m).unwrap();
        assert!(car.yaw_rad.abs() < 0.01, "{car:?}");
        // The corners of the hull say otherwise.
        let mut by_corners = crate::fit::convex_hull_box::ConvexHullBox::default();
        let turned = by_corners.fit(positions_m.iter().map(|&[x, y, _]| [x, y]), [-1.0, -0.6]).unwrap();
        assert!(turned.yaw_rad.abs() > 0.03, "{turned:?}");
    }

    #[test]
    fn azimuths_ascend_around_the_sensor() {
        let of = |degrees: u16| {
            let (sin, cos) = f32::from(degrees).to_radians().sin_cos();
            azimuth_of([9.0 * cos, 9.0 * sin])
        };
        let all: Vec<u32> = (0..360).map(of).collect();
        let first = all.iter().position(|it| *it == *all.iter().min().unwrap()).unwrap();
        assert!((0..359).all(|it| all[(first + it) % 360] < all[(first + it + 1) % 360]));
        assert!(azimuth_of([0.0, -3.0]) == 0 && azimuth_of([-1e-9, -3.0]) < N_AZIMUTHS as u32);
        assert_eq!(azimuth_of([0.0, 0.0]), azimuth_of([1.0, 0.0]));
    }

    proptest! {
        #[test]
        fn two_visible_sides_give_the_whole_footprint(
            angle_rad in -3.1_f32..3.1, range_m in 6.0_f32..30.0, yaw_rad in -1.5_f32..1.5,
        ) {
            let center_m = [range_m * angle_rad.cos(), range_m * angle_rad.sin(), -1.0];
            let car = OrientedBox { center_m, length_width_height_m: [4.2, 1.8, 0.0], yaw_rad };
            let corners_m = car.footprint_m();
            let near = (0..4).min_by(|&a, &b| {
                let range_m = |it: usize| corners_m[it][0].hypot(corners_m[it][1]);
                range_m(a).total_cmp(&range_m(b))
            });
            let near = near.unwrap();
            let sides = [near + 1, near + 3].into_iter().flat_map(|it| line(corners_m[near], corners_m[it % 4], 60));
            let found = fit(&sides.collect::<Vec<_>>()).unwrap();
            prop_assert!((found.yaw_rad - car.yaw_rad).sin().abs() < 0.01, "{:?}", found);
            for axis in 0..2 {
                prop_assert!((found.center_m[axis] - car.center_m[axis]).abs() < 0.05);
                prop_assert!((found.length_width_height_m[axis] - car.length_width_height_m[axis]).abs() < 0.05);
            }
        }

        #[test]
        fn the_box_encloses_its_points_but_for_strays(
            positions_m in prop::collection::vec(prop::array::uniform3(-9.0_f32..9.0), 1..400),
        ) {
            let mut it = fit(&positions_m).unwrap();
            it.length_width_height_m = it.length_width_height_m.map(|side_m| side_m + 1e-3);
            let n_outside = positions_m.iter().filter(|position_m| !it.contains(**position_m)).count();
            // At each of four ends.
            prop_assert!(n_outside <= 4 * (positions_m.len() * 4 / 100), "{n_outside}");
        }

        #[test]
        fn of_all_directions_the_closest_is_taken(
            positions_m in prop::collection::vec(prop::array::uniform3(2.0_f32..9.0), 3..90),
        ) {
            // Fewer than a hundred points, so that none lies beyond a side.
            let mut fitter = OutlineBox::default();
            let found = fitter.fit(&positions_m).unwrap();
            let mean_m = |[cos, sin]: [f32; 2]| {
                let position = |&[x, y]: &[f32; 2]| [x * cos + y * sin, y * cos - x * sin];
                let all: Vec<[f32; 2]> = positions_m.iter().map(|&[x, y, _]| position(&[x, y])).collect();
                let end = |axis: usize, pick: fn(f32, f32) -> f32| all.iter().map(|it| it[axis]).reduce(pick).unwrap();
                let ends = [0, 1].map(|axis| [end(axis, f32::min), end(axis, f32::max)]);
                let distance_m = |it: [f32; 2]| {
                    let to_ends = [0, 1].map(|axis| (it[axis] - ends[axis][0]).min(ends[axis][1] - it[axis]));
                    to_ends[0].min(to_ends[1]).min(MOST_DISTANCE_M)
                };
                let outline_m = &fitter.outline_m;
                outline_m.iter().map(|it| distance_m(position(it))).sum::<f32>() / outline_m.len() as f32
            };
            let taken_m = mean_m([found.yaw_rad.cos(), found.yaw_rad.sin()]);
            let edges = fitter.hull_m.iter().zip(fitter.hull_m.iter().cycle().skip(1));
            for (from_m, to_m) in edges {
                prop_assert!(taken_m <= mean_m(direction(*from_m, *to_m)) + 1e-4);
            }
        }
    }
}
