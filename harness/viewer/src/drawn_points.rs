//! Which points of a scan are drawn.

use std::collections::HashSet;

use detector::PointCloud;

/// How many of the points of a scan are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PointChoice {
    /// The first in each cube with sides of so many centimetres.
    OneOfEachCube {
        /// The side of a cube.
        side_cm: u8,
    },
    /// All.
    #[default]
    All,
    /// At most so many, spread evenly over the scan.
    AtMost(usize),
}

/// Sides of the cubes for recordings of few scans and of many; the eye cannot tell the points in a cube of the first apart.
const SIDES_CM: [u8; 2] = [10, 25];
/// Recordings of more scans are of many.
const FEW_SCANS: usize = 20;

impl PointChoice {
    /// The choice for a recording of `n_scans` scans unless the user makes another.
    pub fn for_scans(n_scans: usize) -> Self {
        let [of_few, of_many] = SIDES_CM;
        Self::OneOfEachCube { side_cm: if n_scans <= FEW_SCANS { of_few } else { of_many } }
    }
}

/// The points of one scan that are drawn: all that have a position, or fewer.
///
/// Positions and all columns of labels must be of the same points.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DrawnPoints {
    indices: Vec<u32>,
    n_points_of_scan: usize,
}

impl DrawnPoints {
    /// Those of `cloud` that `choice` takes, in scan order; a viewer cannot show NaN and infinity.
    pub fn choose(cloud: &PointCloud, choice: PointChoice) -> Self {
        let finite = |&point_idx: &u32| cloud.position_m(point_idx as usize).iter().all(|it| it.is_finite());
        let mut indices: Vec<u32> = (0..cloud.len() as u32).filter(finite).collect();
        match choice {
            PointChoice::AtMost(n_drawn) if n_drawn < indices.len() => {
                let n_finite = indices.len();
                indices = (0..n_drawn).map(|index| indices[index * n_finite / n_drawn]).collect();
            }
            PointChoice::All | PointChoice::AtMost(_) => {}
            PointChoice::OneOfEachCube { side_cm } => {
                let side_m = f32::from(side_cm) / 100.0;
                let mut taken = HashSet::with_capacity(indices.len());
                let cube = |point_idx: u32| {
                    cloud.position_m(point_idx as usize).map(|it| (it / side_m).floor() as i32)
                };
                indices.retain(|&it| taken.insert(cube(it)));
            }
        }
        Self { indices, n_points_of_scan: cloud.len() }
    }

    /// Their indices in the scan, ascending.
    pub fn indices(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.indices.iter().map(|&it| it as usize)
    }

    /// How many are drawn.
    pub fn n_drawn(&self) -> usize {
        self.indices.len()
    }

    /// How many points the scan has.
    pub fn n_points_of_scan(&self) -> usize {
        self.n_points_of_scan
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(choice: PointChoice, expected: &[usize]) {
        let with_hole = |it: usize| if it == 3 { f32::NAN } else { it as f32 };
        let cloud: PointCloud = (0..9).map(|it| [with_hole(it), 0.0, 0.0]).collect();
        let drawn = DrawnPoints::choose(&cloud, choice);
        assert_eq!(drawn.indices().collect::<Vec<_>>(), expected);
        assert_eq!((drawn.n_drawn(), drawn.n_points_of_scan()), (expected.len(), 9));
    }

    #[test]
    fn points_without_a_position_are_left_out() {
        check(PointChoice::All, &[0, 1, 2, 4, 5, 6, 7, 8]);
        check(PointChoice::AtMost(8), &[0, 1, 2, 4, 5, 6, 7, 8]);
    }

    #[test]
    fn fewer_points_are_spread_over_the_scan() {
        check(PointChoice::AtMost(4), &[0, 2, 5, 7]);
        check(PointChoice::AtMost(3), &[0, 2, 6]);
        check(PointChoice::AtMost(0), &[]);
    }

    #[test]
    fn the_first_point_in_each_cube_is_drawn() {
        let at =
            [[0.01, 0.01, 0.01], [0.09, 0.01, 0.01], [-0.01, 0.01, 0.01], [0.05, 0.02, 0.11], [f32::NAN; 3]];
        let drawn = DrawnPoints::choose(&at.into_iter().collect(), PointChoice::for_scans(20));
        assert_eq!(drawn.indices().collect::<Vec<_>>(), [0, 2, 3]);
        let drawn = DrawnPoints::choose(&at.into_iter().collect(), PointChoice::for_scans(21));
        assert_eq!(drawn.indices().collect::<Vec<_>>(), [0, 2]);
    }
}
