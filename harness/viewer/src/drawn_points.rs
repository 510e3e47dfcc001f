//! Which points of a scan are drawn.

use detector::PointCloud;

use super::rounding::Rounding;

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

    /// How coordinates are rounded: to about a tenth of a cube, and not at all without cubes.
    fn rounding(self) -> Rounding {
        match self {
            Self::OneOfEachCube { side_cm } => Rounding::finer_than(f32::from(side_cm) / 1000.0),
            Self::All | Self::AtMost(_) => Rounding::default(),
        }
    }
}

/// The points of one scan that are drawn: all that have a position, or fewer.
///
/// Positions and all columns of labels must be of the same points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DrawnPoints {
    indices: Vec<u32>,
    n_points_of_scan: usize,
    rounding: Rounding,
}

impl DrawnPoints {
    /// Those of `cloud` that `choice` takes; a viewer cannot show NaN and infinity.
    ///
    /// They are in scan order, or where one of each cube is taken along a Z-order curve through the cubes: neighbours have
    /// the same labels, and equal values in a row are compressed.
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
                let cube = |point_idx: u32| {
                    cloud.position_m(point_idx as usize).map(|it| (it / side_m).floor() as i32)
                };
                let mut by_cube: Vec<(u64, u32)> =
                    indices.into_iter().map(|it| (along_z_order(cube(it)), it)).collect();
                by_cube.sort_unstable();
                by_cube.dedup_by_key(|(cube, _)| *cube);
                indices = by_cube.into_iter().map(|(_, point_idx)| point_idx).collect();
            }
        }
        Self { indices, n_points_of_scan: cloud.len(), rounding: choice.rounding() }
    }

    /// Their indices in the scan.
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

    /// How coordinates in this scan are rounded.
    pub fn rounding(&self) -> Rounding {
        self.rounding
    }
}

/// Position of `cube` on a Z-order curve (Morton 1966): the bits of its three indices in turn. Cubes more than a million from
/// the origin share the places of those at the edge.
fn along_z_order(cube: [i32; 3]) -> u64 {
    const N_BITS: u32 = 21;
    const MIDDLE: i32 = 1 << (N_BITS - 1);
    let indices = cube.map(|it| (it.clamp(-MIDDLE, MIDDLE - 1) + MIDDLE) as u64);
    let bits = (0..N_BITS).flat_map(|bit| (0..3).map(move |axis| (bit, axis)));
    bits.fold(0, |code, (bit, axis)| code | (indices[axis] >> bit & 1) << (3 * bit + axis as u32))
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
        assert_eq!(drawn.indices().collect::<Vec<_>>(), [2, 0, 3]);
        let drawn = DrawnPoints::choose(&at.into_iter().collect(), PointChoice::for_scans(21));
        assert_eq!(drawn.indices().collect::<Vec<_>>(), [2, 0]);
    }

    #[test]
    fn cubes_that_touch_are_near_on_the_curve() {
        let octant = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]];
        let codes = octant.map(along_z_order);
        assert!(codes.windows(2).all(|it| it[1] == it[0] + 1), "{codes:?}");
        let far = [[i32::MIN; 3], [-(1 << 20); 3]].map(along_z_order);
        assert_eq!(far, [0, 0]);
    }
}
