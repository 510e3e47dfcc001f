//! What a detector reports.

use std::ops::Range;

use crate::oriented_box::OrientedBox;

/// What a detector says an object is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DetectedClass {
    /// A free-standing thing on the street that is not known to be a vehicle.
    Object,
    /// A car, van, truck or bus.
    Vehicle,
}

impl DetectedClass {
    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Vehicle => "vehicle",
        }
    }
}

/// One detected object, borrowed from [`Detections`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection<'a> {
    /// Its points, as indices into the scan, ascending.
    pub point_indices: &'a [u32],
    /// The box around them, in the sensor frame.
    pub bounding_box: OrientedBox,
    /// What it is.
    pub class: DetectedClass,
    /// How sure the detector is that it is a vehicle; higher is surer, only the order matters. Never NaN.
    pub score: Option<f32>,
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    points: Range<usize>,
    bounding_box: OrientedBox,
    class: DetectedClass,
    score: Option<f32>,
}

/// The detections of one scan, in one reusable buffer.
///
/// ```
/// use detector::{DetectedClass, Detection, Detections, OrientedBox};
///
/// let bounding_box =
///     OrientedBox { center_m: [8.0, 3.0, -1.0], length_width_height_m: [4.2, 1.8, 1.3], yaw_rad: 0.0 };
/// let car = Detection {
///     point_indices: &[4, 5, 9],
///     bounding_box,
///     class: DetectedClass::Vehicle,
///     score: Some(1.25),
/// };
/// let mut detections = Detections::default();
/// detections.push(car);
/// assert_eq!(detections.len(), 1);
/// assert_eq!(detections.get(0), car);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Detections {
    // Invariant: the ranges of `entries` partition `point_indices`. A point may belong to several detections.
    entries: Vec<Entry>,
    point_indices: Vec<u32>,
}

impl Detections {
    /// Forgets the detections and keeps the memory.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.point_indices.clear();
    }

    /// Appends a detection.
    pub fn push(&mut self, detection: Detection<'_>) {
        debug_assert!(detection.score.is_none_or(|score| !score.is_nan()));
        let start = self.point_indices.len();
        self.point_indices.extend_from_slice(detection.point_indices);
        self.entries.push(Entry {
            points: start..self.point_indices.len(),
            bounding_box: detection.bounding_box,
            class: detection.class,
            score: detection.score,
        });
    }

    /// Gives each detection the box that `new_box` returns for it.
    pub(crate) fn replace_boxes(&mut self, mut new_box: impl FnMut(Detection<'_>) -> OrientedBox) {
        for detection_idx in 0..self.len() {
            self.entries[detection_idx].bounding_box = new_box(self.get(detection_idx));
        }
    }

    /// Number of detections.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether nothing was detected.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Detection `detection_idx`.
    pub fn get(&self, detection_idx: usize) -> Detection<'_> {
        let entry = &self.entries[detection_idx];
        Detection {
            point_indices: &self.point_indices[entry.points.clone()],
            bounding_box: entry.bounding_box,
            class: entry.class,
            score: entry.score,
        }
    }

    /// All detections, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Detection<'_>> {
        (0..self.len()).map(|detection_idx| self.get(detection_idx))
    }
}

impl<'a> FromIterator<Detection<'a>> for Detections {
    fn from_iter<I: IntoIterator<Item = Detection<'a>>>(detections: I) -> Self {
        let mut all = Self::default();
        for detection in detections {
            all.push(detection);
        }
        all
    }
}
