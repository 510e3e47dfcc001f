//! Which points of a scan are drawn.

use detector::PointCloud;

/// The points of one scan that are drawn: all that have a place, or fewer spread evenly over the scan.
///
/// Positions and all columns of labels have to agree in them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DrawnPoints {
    indices: Vec<u32>,
    n_points_of_scan: usize,
}

impl DrawnPoints {
    /// At most `max_points` of `cloud`, in scan order; a viewer has no place for NaN and infinity.
    pub fn choose(cloud: &PointCloud, max_points: Option<usize>) -> Self {
        let finite = |&point_idx: &u32| cloud.position_m(point_idx as usize).iter().all(|it| it.is_finite());
        let mut indices: Vec<u32> = (0..cloud.len() as u32).filter(finite).collect();
        if let Some(n_drawn) = max_points.filter(|it| *it < indices.len()) {
            let n_finite = indices.len();
            indices = (0..n_drawn).map(|place| indices[place * n_finite / n_drawn]).collect();
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
    fn check(max_points: Option<usize>, expected: &[usize]) {
        let with_hole = |it: usize| if it == 3 { f32::NAN } else { it as f32 };
        let cloud: PointCloud = (0..9).map(|it| [with_hole(it), 0.0, 0.0]).collect();
        let drawn = DrawnPoints::choose(&cloud, max_points);
        assert_eq!(drawn.indices().collect::<Vec<_>>(), expected);
        assert_eq!((drawn.n_drawn(), drawn.n_points_of_scan()), (expected.len(), 9));
    }

    #[test]
    fn points_without_a_place_are_left_out() {
        check(None, &[0, 1, 2, 4, 5, 6, 7, 8]);
        check(Some(8), &[0, 1, 2, 4, 5, 6, 7, 8]);
    }

    #[test]
    fn fewer_points_are_spread_over_the_scan() {
        check(Some(4), &[0, 2, 5, 7]);
        check(Some(3), &[0, 2, 6]);
        check(Some(0), &[]);
    }
}
