//! The points of an object, evened out, so that the work has a bound and near surfaces do not outweigh far ones.

use serde::{Deserialize, Serialize};

/// Tuning of [`ThinnedPoints`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThinningParams {
    /// Side of the cubes of which each keeps one point, the mean of its points, in metres; 0 keeps all points.
    pub cube_m: f64,
    /// Most points that are kept. Cubes grow by a quarter until no more are left; each time the means are thinned again.
    pub max_points: usize,
}

/// Points with a coordinate beyond this are treated as absent, like those that are not finite.
pub const FARTHEST_M: f32 = 10_000.0;
/// The least side of cubes that are needed only because there are too many points.
const LEAST_CUBE_M: f64 = 0.02;

/// Buffers for thinning one cloud after another.
#[derive(Debug, Clone, Default)]
pub struct ThinnedPoints {
    all: Vec<(u64, [f64; 3])>,
    thinned_again: Vec<(u64, [f64; 3])>,
    points_m: Vec<[f64; 3]>,
}

impl ThinnedPoints {
    /// Keeps the mean of the points in every cube. The result does not depend on the order of `positions_m`, and its order
    /// is arbitrary but fixed.
    ///
    /// Not in the papers.
    pub fn fill(&mut self, positions_m: impl Iterator<Item = [f32; 3]>, params: &ThinningParams) {
        let is_usable = |it: &[f32; 3]| it.iter().all(|value| value.abs() <= FARTHEST_M);
        // No negative nought: it is another one to `total_cmp`.
        let usable = positions_m.filter(is_usable).map(|it| (0, it.map(|value| f64::from(value) + 0.0)));
        let Self { all, thinned_again, points_m } = self;
        all.clear();
        all.extend(usable);
        let mut cube_m = params.cube_m;
        keep_means(all, cube_m, points_m);
        while points_m.len() > params.max_points {
            cube_m = (cube_m * 1.25).max(LEAST_CUBE_M);
            thinned_again.clear();
            thinned_again.extend(points_m.iter().map(|&it| (0, it)));
            keep_means(thinned_again, cube_m, points_m);
        }
    }

    /// The thinned points, in metres.
    pub fn points_m(&self) -> &[[f64; 3]] {
        &self.points_m
    }

    /// All points that are not absent, in metres, in a fixed order.
    pub fn all_points_m(&self) -> impl Iterator<Item = [f64; 3]> + Clone {
        self.all.iter().map(|it| it.1)
    }
}

/// Sorts `sorted` by cubes, and writes the mean of each to `points_m`.
fn keep_means(sorted: &mut [(u64, [f64; 3])], cube_m: f64, points_m: &mut Vec<[f64; 3]>) {
    for (cube, position_m) in &mut *sorted {
        *cube = if cube_m > 0.0 { cell_of(*position_m, cube_m) } else { 0 };
    }
    sorted.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| by_coordinates(a.1, b.1)));
    points_m.clear();
    if cube_m > 0.0 {
        points_m.extend(sorted.chunk_by(|a, b| a.0 == b.0).map(mean_m));
    } else {
        points_m.extend(sorted.iter().map(|it| it.1));
    }
}

fn by_coordinates(a: [f64; 3], b: [f64; 3]) -> std::cmp::Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
}

fn mean_m(points: &[(u64, [f64; 3])]) -> [f64; 3] {
    let sum = points
        .iter()
        .fold([0.0; 3], |sum: [f64; 3], (_, it)| [sum[0] + it[0], sum[1] + it[1], sum[2] + it[2]]);
    sum.map(|it| it / points.len() as f64)
}

/// The number of the cube of side `side_m`, at least a centimetre, that holds a point: cubes are ordered by x, then y, then
/// z.
pub(super) fn cell_of(point_m: [f64; 3], side_m: f64) -> u64 {
    let [x, y, z] = point_m.map(|it| ((it / side_m).floor() as i64 + CELL_OFFSET) as u64);
    x << 42 | y << 21 | z
}

/// Cells are counted from 0; twenty-one bits serve each coordinate.
pub(super) const CELL_OFFSET: i64 = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(cube_m: f64, max_points: usize, points_m: &[[f32; 3]], expected_m: &[[f64; 3]]) {
        let mut thinned = ThinnedPoints::default();
        thinned.fill(points_m.iter().copied(), &ThinningParams { cube_m, max_points });
        assert_eq!(thinned.points_m(), expected_m);
        thinned.fill(points_m.iter().rev().copied(), &ThinningParams { cube_m, max_points });
        assert_eq!(thinned.points_m(), expected_m);
    }

    #[test]
    fn each_cube_keeps_the_mean_of_its_points() {
        let points = [[0.25, 0.0, 0.0], [0.75, 0.5, 0.0], [1.5, 0.0, 0.0], [-0.5, 0.0, 0.0]];
        check(1.0, 9, &points, &[[-0.5, 0.0, 0.0], [0.5, 0.25, 0.0], [1.5, 0.0, 0.0]]);
    }

    #[test]
    fn without_cubes_all_points_are_kept() {
        check(
            0.0,
            9,
            &[[2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
            &[[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        );
    }

    #[test]
    fn missing_returns_and_points_out_of_this_world_are_absent() {
        let (nan, far) = (f32::NAN, 2.0 * FARTHEST_M);
        check(0.1, 9, &[[nan, 0.0, 0.0], [0.0, f32::INFINITY, 0.0], [0.0, 0.0, far]], &[]);
    }

    #[test]
    fn cubes_grow_until_no_more_points_are_left_than_allowed() {
        let mut thinned = ThinnedPoints::default();
        let grid = (0..40).flat_map(|x| (0..40).map(move |y| [x as f32 * 0.1, y as f32 * 0.1, 0.0]));
        thinned.fill(grid.clone(), &ThinningParams { cube_m: 0.0, max_points: 100 });
        assert!((30..=100).contains(&thinned.points_m().len()), "{}", thinned.points_m().len());
        // However many lie on one position, they are one point of a cube.
        thinned.fill(std::iter::repeat_n([1.0; 3], 1000), &ThinningParams { cube_m: 0.0, max_points: 1 });
        assert_eq!(thinned.points_m(), [[1.0; 3]]);
    }
}
