//! Detections that a detector reports.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use crate::oriented_box::OrientedBox;

/// Class of a detected object.
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

/// The class that a detector gives an object, if that says more than [`DetectedClass`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GivenClass {
    name: &'static str,
    word: &'static str,
}

impl GivenClass {
    /// A person on foot, as the detectors of this project say it.
    pub const PEDESTRIAN: Self = Self { name: "pedestrian", word: "pedestrian" };
    /// A bicycle or motorcycle with its rider, as the detectors of this project say it.
    pub const CYCLIST: Self = Self { name: "cyclist", word: "cyclist" };

    /// The class `name`, which the detector calls `word`.
    pub fn new(name: &str, word: &str) -> Self {
        Self { name: kept(name), word: kept(word) }
    }

    /// The name of the class.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// The word of the detector.
    pub fn word(self) -> &'static str {
        self.word
    }
}

/// `text`, kept as long as the program runs: detections are copied many times, and there are few classes.
fn kept(text: &str) -> &'static str {
    static TEXTS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = texts.get(text) {
        return known;
    }
    let text: &'static str = Box::leak(text.to_owned().into_boxed_str());
    texts.insert(text);
    text
}

/// Which upright sides of a vehicle are seen. Left and right are those of its driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "a box has four sides")]
pub struct SeenSides {
    /// The side at its front end.
    pub front: bool,
    /// The side at its rear end.
    pub rear: bool,
    /// The left side.
    pub left: bool,
    /// The right side.
    pub right: bool,
}

/// Details of a whole vehicle of which a detector sees a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SeenOfVehicle {
    /// Which sides are seen: those that face the sensor, and at which the box ends about where the points do.
    pub sides: SeenSides,
    /// Whether the detector is sure which end is the front. Otherwise the yaw may be off by 180 degrees.
    pub is_front_sure: bool,
}

/// Details of a box beside its geometry.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoxDetails {
    /// How sure the detector is of both the vehicle and its box; higher is surer, only the order matters. Never NaN.
    pub score: Option<f32>,
    /// Details of the seen part of the vehicle. `None` if the box is that of the seen part.
    pub seen: Option<SeenOfVehicle>,
    /// Velocity over ground along x and y of the scan's frame, in metres per second, finite. `None` if the detector does not
    /// know it; the detectors of this project do not.
    pub velocity_m_per_s: Option<[f32; 2]>,
    /// Number of the object in all scans of its drive; `None` if the detector does not follow it.
    pub track: Option<u32>,
    /// Whether its points are those that lie in the box, since the detector gave none.
    pub has_points_of_box: bool,
}

/// One detected object, borrowed from [`Detections`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection<'a> {
    /// Its points, as indices into the scan, ascending.
    pub point_indices: &'a [u32],
    /// The box around them, in the sensor frame.
    pub bounding_box: OrientedBox,
    /// Its class.
    pub class: DetectedClass,
    /// The class that its detector gives, if that says more.
    pub given: Option<GivenClass>,
    /// How sure the detector is of the class that it gives, or else that this is a vehicle; higher is surer, only the order
    /// matters. Never NaN.
    pub score: Option<f32>,
    /// Details of the box.
    pub box_details: BoxDetails,
}

impl<'a> Detection<'a> {
    /// A detection without details of its box.
    pub fn new(
        point_indices: &'a [u32],
        bounding_box: OrientedBox,
        class: DetectedClass,
        score: Option<f32>,
    ) -> Self {
        Self { point_indices, bounding_box, class, given: None, score, box_details: BoxDetails::default() }
    }

    /// The name of its class: the one that its detector gives, or else its kind.
    pub fn class_name(&self) -> &'static str {
        self.given.map_or(self.class.name(), GivenClass::name)
    }

    /// The score by which protocols that judge boxes rank it: how sure the detector is of its box, or else of its class.
    pub fn box_score(&self) -> Option<f32> {
        self.box_details.score.or(self.score)
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    points: Range<usize>,
    bounding_box: OrientedBox,
    class: DetectedClass,
    given: Option<GivenClass>,
    score: Option<f32>,
    box_details: BoxDetails,
}

/// The detections of one scan, in one reusable buffer.
///
/// ```
/// use detector::{DetectedClass, Detection, Detections, OrientedBox};
///
/// let bounding_box =
///     OrientedBox { center_m: [8.0, 3.0, -1.0], length_width_height_m: [4.2, 1.8, 1.3], yaw_rad: 0.0 };
/// let car = Detection::new(&[4, 5, 9], bounding_box, DetectedClass::Vehicle, Some(1.25));
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
        debug_assert!([detection.score, detection.box_details.score].iter().flatten().all(|it| !it.is_nan()));
        let start = self.point_indices.len();
        self.point_indices.extend_from_slice(detection.point_indices);
        self.entries.push(Entry {
            points: start..self.point_indices.len(),
            bounding_box: detection.bounding_box,
            class: detection.class,
            given: detection.given,
            score: detection.score,
            box_details: detection.box_details,
        });
    }

    /// Gives each detection the box and its details that `new_box` returns for it.
    pub(crate) fn replace_boxes(
        &mut self,
        mut new_box: impl FnMut(Detection<'_>) -> (OrientedBox, BoxDetails),
    ) {
        for detection_idx in 0..self.len() {
            let (bounding_box, box_details) = new_box(self.get(detection_idx));
            debug_assert!(box_details.score.is_none_or(|it| !it.is_nan()));
            let entry = &mut self.entries[detection_idx];
            (entry.bounding_box, entry.box_details) = (bounding_box, box_details);
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
            given: entry.given,
            score: entry.score,
            box_details: entry.box_details,
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
