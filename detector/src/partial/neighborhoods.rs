//! The points around a position.

use super::thinned_points::{CELL_OFFSET, cell_of};

/// Points sorted into cubes as large as the most frequent radius, so that a few cubes hold all points around a position.
#[derive(Debug, Clone, Default)]
pub struct Neighborhoods {
    cube_m: f64,
    sorted: Vec<(u64, [f64; 3])>,
    points_m: Vec<[f64; 3]>,
    /// Every cube that holds points, ascending, and the index of its first point.
    cubes: Vec<(u64, u32)>,
    n_fills: u64,
}

/// The points found around a position. It remembers which cubes were searched, and the next search takes these if they are
/// the same. To be used with one [`Neighborhoods`] only.
#[derive(Debug, Clone, Default)]
pub struct Nearby {
    /// The cloud that was searched, and the corners of the searched cubes.
    searched: Option<(u64, [[u64; 3]; 2])>,
    /// Where the points in these cubes begin and end, ascending.
    runs: Vec<[u32; 2]>,
    /// Indices of the points that were found, ascending.
    pub found: Vec<u32>,
}

impl Neighborhoods {
    /// Sorts points by cubes of side `cube_m`, and in them by x, y and z. From now on their indices are in this order.
    pub fn fill(&mut self, points_m: &[[f64; 3]], cube_m: f64) {
        self.cube_m = cube_m;
        self.sorted.clear();
        self.sorted.extend(points_m.iter().map(|&it| (cell_of(it, cube_m), it)));
        self.sorted.sort_unstable_by(|(a_cell, a), (b_cell, b)| {
            let by_coordinates =
                || a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]));
            a_cell.cmp(b_cell).then_with(by_coordinates)
        });
        self.points_m.clear();
        self.points_m.extend(self.sorted.iter().map(|it| it.1));
        self.cubes.clear();
        for (&(cube, _), index) in self.sorted.iter().zip(0..) {
            if self.cubes.last().is_none_or(|it| it.0 != cube) {
                self.cubes.push((cube, index));
            }
        }
        self.n_fills += 1;
    }

    /// All points in their order, in metres.
    pub fn points_m(&self) -> &[[f64; 3]] {
        &self.points_m
    }

    /// Finds the points within `radius_m` of `center_m`; a point at that distance is within.
    pub fn within(&self, center_m: [f64; 3], radius_m: f64, nearby: &mut Nearby) {
        let corners = [-radius_m, radius_m].map(|off_m| center_m.map(|it| self.cell_coordinate(it + off_m)));
        let Nearby { searched, runs, found } = nearby;
        if *searched != Some((self.n_fills, corners)) {
            self.fill_runs(corners, runs);
            *searched = Some((self.n_fills, corners));
        }
        found.clear();
        found.resize(runs.iter().map(|[start, end]| (end - start) as usize).sum(), 0);
        let mut n_found = 0;
        for &[start, end] in &*runs {
            for (point_idx, point_m) in (start..end).zip(&self.points_m[start as usize..end as usize]) {
                // No branch: a processor would guess it wrong half of the time.
                found[n_found] = point_idx;
                n_found += usize::from(squared_distance(*point_m, center_m) <= radius_m * radius_m);
            }
        }
        found.truncate(n_found);
    }

    /// The points in the cubes from one corner to the other.
    fn fill_runs(&self, [low, high]: [[u64; 3]; 2], runs: &mut Vec<[u32; 2]>) {
        runs.clear();
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                let column = x << 42 | y << 21;
                let [first, last] = [column | low[2], (column | high[2]) + 1]
                    .map(|cube| self.cubes.partition_point(|it| it.0 < cube))
                    .map(|index| self.cubes.get(index).map_or(self.points_m.len() as u32, |it| it.1));
                if first < last {
                    runs.push([first, last]);
                }
            }
        }
    }

    fn cell_coordinate(&self, value_m: f64) -> u64 {
        let largest = (2 * CELL_OFFSET - 1) as f64;
        ((value_m / self.cube_m).floor() + CELL_OFFSET as f64).clamp(0.0, largest) as u64
    }
}

/// Keeps `max` of `found`, evenly spread over their order, if there are more.
pub fn keep_evenly(found: &mut Vec<u32>, max: usize) {
    if found.len() > max {
        let n_found = found.len();
        for index in 0..max {
            found[index] = found[index * n_found / max];
        }
        found.truncate(max);
    }
}

/// The square of the distance between two points, in square metres.
#[inline(always)]
pub fn squared_distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn all_points_within_the_radius_are_found_and_no_others(
            points_m in prop::collection::vec(prop::array::uniform3(-3.0_f64..3.0), 0..60),
            center_m in prop::array::uniform3(-4.0_f64..4.0),
            radius_m in 0.0_f64..5.0,
        ) {
            let mut around = Neighborhoods::default();
            around.fill(&points_m, 0.8);
            let mut nearby = Nearby::default();
            around.within(center_m, radius_m, &mut nearby);
            let is_near = |idx: &u32| squared_distance(around.points_m()[*idx as usize], center_m) <= radius_m * radius_m;
            let expected: Vec<u32> = (0..points_m.len() as u32).filter(is_near).collect();
            prop_assert_eq!(nearby.found, expected);
        }

        #[test]
        fn what_was_searched_before_changes_nothing(
            points_m in prop::collection::vec(prop::array::uniform3(-2.0_f64..2.0), 1..60),
            radius_m in 0.0_f64..1.5,
        ) {
            let mut around = Neighborhoods::default();
            let mut nearby = Nearby::default();
            for &center_m in &points_m {
                // Two clouds in turn, each asked twice for mostly the same cubes.
                for points_m in [&points_m[..], &points_m[1..]] {
                    around.fill(points_m, 0.8);
                    for aside_m in [0.0, 1e-3] {
                        let center_m = [center_m[0] + aside_m, center_m[1], center_m[2]];
                        let mut anew = Nearby::default();
                        around.within(center_m, radius_m, &mut nearby);
                        around.within(center_m, radius_m, &mut anew);
                        prop_assert_eq!(&nearby.found, &anew.found);
                    }
                }
            }
        }
    }

    #[test]
    fn those_that_are_kept_are_spread_over_all() {
        let mut found: Vec<u32> = (0..10).collect();
        keep_evenly(&mut found, 4);
        assert_eq!(found, [0, 2, 5, 7]);
        keep_evenly(&mut found, 4);
        assert_eq!(found, [0, 2, 5, 7]);
    }
}
