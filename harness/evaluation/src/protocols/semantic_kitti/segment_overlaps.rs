//! Numbers of points that the segments of two segmentations of a scan share.

use std::collections::BTreeMap;

/// Two segments and the number of points that they share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SharedPoints {
    /// Number of the first segment.
    pub first: u32,
    /// Number of the second.
    pub second: u32,
    /// Points of both.
    pub n_points: u64,
}

/// The points of every segment, and of every pair of segments that share some.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SegmentOverlaps {
    /// Points of each segment of the first kind, by its number.
    pub n_of_first: BTreeMap<u32, u64>,
    /// Points of each segment of the second kind, by its number.
    pub n_of_second: BTreeMap<u32, u64>,
    // Ascending.
    shared: Vec<SharedPoints>,
}

impl SegmentOverlaps {
    /// Counts points, each given by its segment of the first kind and its segment of the second.
    pub fn of(points: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut points: Vec<[u32; 2]> = points.collect();
        points.sort_unstable();
        let mut overlaps = Self::default();
        for alike in points.chunk_by(PartialEq::eq) {
            let ([first, second], n_points) = (alike[0], alike.len() as u64);
            *overlaps.n_of_first.entry(first).or_default() += n_points;
            *overlaps.n_of_second.entry(second).or_default() += n_points;
            overlaps.shared.push(SharedPoints { first, second, n_points });
        }
        overlaps
    }

    /// The pairs, in one list for each first segment, ascending.
    pub fn by_first(&self) -> impl Iterator<Item = &[SharedPoints]> {
        self.shared.chunk_by(|a, b| a.first == b.first)
    }

    /// Intersection over union of the points of the two segments.
    pub fn iou(&self, pair: &SharedPoints) -> f64 {
        let n_either = self.n_of_first[&pair.first] + self.n_of_second[&pair.second] - pair.n_points;
        pair.n_points as f64 / n_either as f64
    }
}

/// The sum, equal to the bit for every order of the terms: the order of segments must not change it.
pub fn sum_in_order(mut terms: Vec<f64>) -> f64 {
    terms.sort_by(f64::total_cmp);
    terms.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_counted_by_segment_and_by_pair() {
        let overlaps = SegmentOverlaps::of([[7, 1], [7, 2], [3, 1], [7, 1]].into_iter());
        assert_eq!(overlaps.n_of_first, BTreeMap::from([(3, 1), (7, 3)]));
        assert_eq!(overlaps.n_of_second, BTreeMap::from([(1, 3), (2, 1)]));
        let lists: Vec<Vec<(u32, u64)>> =
            overlaps.by_first().map(|it| it.iter().map(|it| (it.second, it.n_points)).collect()).collect();
        assert_eq!(lists, [vec![(1, 1)], vec![(1, 2), (2, 1)]]);
        let last = overlaps.by_first().last().unwrap();
        assert_eq!([0, 1].map(|it| overlaps.iou(&last[it])), [0.5, 1.0 / 3.0]);
    }
}
