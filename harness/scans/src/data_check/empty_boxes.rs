//! Boxes that hold no point, which shows that labels and scans differ in frame or time.

use crate::annotation::LabeledScan;

/// Boxes nearer than this should hold points, in metres.
pub const NEAR_M: f32 = 40.0;

/// If a greater share of boxes is empty, something is wrong with frames, calibration or times.
const MAX_EMPTY_SHARE: f64 = 0.5;

/// How many boxes near the sensor there are, and how many of them hold no point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EmptyBoxes {
    /// Near boxes.
    pub n_near: usize,
    /// Near boxes without a point.
    pub n_empty: usize,
}

impl EmptyBoxes {
    /// Counts the boxes of `scans`.
    pub fn of<'a>(scans: impl IntoIterator<Item = &'a LabeledScan>) -> Self {
        let mut counted = Self::default();
        for annotation in scans.into_iter().flat_map(|it| &it.annotations) {
            counted.add(annotation.bounding_box.map(|it| it.range_m()), annotation.point_indices.len());
        }
        counted
    }

    /// Counts an annotation with `n_points` points; its box, if any, is `box_range_m` metres away.
    pub fn add(&mut self, box_range_m: Option<f32>, n_points: usize) {
        if box_range_m.is_some_and(|it| it < NEAR_M) {
            self.n_near += 1;
            self.n_empty += usize::from(n_points == 0);
        }
    }

    /// Whether most near boxes are empty.
    pub fn are_most(self) -> bool {
        self.n_empty as f64 > MAX_EMPTY_SHARE * self.n_near as f64
    }
}
