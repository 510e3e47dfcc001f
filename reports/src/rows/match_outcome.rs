//! Outcomes of annotations, detections and pairs of them, with all that is needed to judge them again.

use crate::vocabulary::class::{AnnotationClass, DetectionClass, Occlusion};
use crate::vocabulary::own_slice::Extents;
use crate::vocabulary::reason::{Agreement, FalseReason, IgnoredAnnotation, IgnoredDetection, MissReason};

/// Outcome of an annotation, a detection or a pair of them.
#[derive(Debug, Clone, PartialEq)]
pub enum MatchOutcome {
    /// The detection found the annotation.
    Matched {
        /// The annotation.
        annotation: AnnotationFacts,
        /// The detection.
        detection: DetectionFacts,
        /// Lower is better; the unit is the criterion's.
        cost: f64,
    },
    /// The annotation was missed.
    Missed {
        /// The annotation.
        annotation: AnnotationFacts,
        /// Why.
        reason: MissReason,
    },
    /// The annotation is neither found nor missed.
    IgnoredAnnotation {
        /// The annotation.
        annotation: AnnotationFacts,
        /// Why.
        reason: IgnoredAnnotation,
    },
    /// The annotation is too tall for the task: neither found nor missed, and counted apart.
    Tall {
        /// The annotation.
        annotation: AnnotationFacts,
        /// The detection that found it, of those that found nothing that counts. It is neither right nor false.
        found_by: Option<FoundBy>,
    },
    /// The detection is false.
    False {
        /// The detection.
        detection: DetectionFacts,
        /// Why.
        reason: FalseReason,
    },
    /// The detection is neither right nor false.
    IgnoredDetection {
        /// The detection.
        detection: DetectionFacts,
        /// Why.
        reason: IgnoredDetection,
    },
    /// It cannot be known whether the detection is false.
    Unknowable {
        /// The detection.
        detection: DetectionFacts,
        /// How many other detectors have it, where nothing is labelled and there are others.
        agreement: Option<Agreement>,
    },
}

/// A detection that found an annotation, with the cost.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundBy {
    /// The detection.
    pub detection: DetectionFacts,
    /// Lower is better; the unit is the criterion's.
    pub cost: f64,
}

/// Facts about an annotation.
#[derive(Debug, Clone, PartialEq)]
pub struct AnnotationFacts {
    /// Its index among the annotations of the scan, from 0.
    pub id: u64,
    /// Number of the object within its drive.
    pub track: Option<u32>,
    /// Its class.
    pub class: AnnotationClass,
    /// How much of it other things hide from the sensor.
    pub occlusion: Option<Occlusion>,
    /// Number of its points.
    pub n_points: u64,
    /// How many of these lie outside the labelled region.
    pub n_points_outside: u64,
    /// Its box, where boxes are labelled.
    pub bounding_box: Option<BoxFacts>,
    /// Centroid of its points in metres, where it has no box.
    pub centroid_m: Option<[f32; 3]>,
}

impl AnnotationFacts {
    /// Where it stands, in metres: the centre of its box or the centroid of its points; `None` if it has neither.
    pub fn center_m(&self) -> Option<[f32; 3]> {
        self.bounding_box.map(|it| it.center_m).or(self.centroid_m)
    }

    /// What bounds of slices ask of it.
    pub(crate) fn extents(&self) -> Extents {
        let length_width_height_m = self.bounding_box.map(|it| it.length_width_height_m);
        Extents { center_m: self.center_m(), length_width_height_m, n_points: self.n_points }
    }

    /// Whether at least half of its points lie outside the labelled region.
    pub fn is_truncated(&self) -> bool {
        self.n_points > 0 && 2 * self.n_points_outside >= self.n_points
    }
}

#[cfg(test)]
impl AnnotationFacts {
    /// The first annotation of its scan, on no track, with all its points inside the labelled region, and no known position.
    pub(crate) fn without_position(class: AnnotationClass, n_points: u64) -> Self {
        let (track, occlusion, bounding_box, centroid_m) = (None, None, None, None);
        Self { id: 0, track, class, occlusion, n_points, n_points_outside: 0, bounding_box, centroid_m }
    }
}

/// Distance of a position from the sensor on the ground plan, in metres.
pub fn range_m(position_m: [f32; 3]) -> f64 {
    f64::from(position_m[0]).hypot(f64::from(position_m[1]))
}

/// Facts about a detection.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectionFacts {
    /// Its index among the detections of the scan, from 0.
    pub id: u64,
    /// The class that the detector takes it for.
    pub class: DetectionClass,
    /// How sure the detector is; higher is surer.
    pub score: Option<f32>,
    /// Number of its points.
    pub n_points: u64,
    /// Its box.
    pub bounding_box: BoxFacts,
    /// Its motion, as far as the detector knows it.
    pub motion: MotionFacts,
}

/// The motion of a detection, as far as its detector knows it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MotionFacts {
    /// Velocity over ground along x and y of the sensor frame, in metres per second.
    pub velocity_m_per_s: Option<[f32; 2]>,
    /// Number of the object in all scans of its drive.
    pub track: Option<u32>,
}

impl DetectionFacts {
    /// What bounds of slices ask of it.
    pub(crate) fn extents(&self) -> Extents {
        let BoxFacts { center_m, length_width_height_m, .. } = self.bounding_box;
        let length_width_height_m = Some(length_width_height_m);
        Extents { center_m: Some(center_m), length_width_height_m, n_points: self.n_points }
    }
}

/// An upright box in the sensor frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxFacts {
    /// Centre x (forward), y (left), z (up) in metres.
    pub center_m: [f32; 3],
    /// Length (along the heading), width and height in metres.
    pub length_width_height_m: [f32; 3],
    /// Heading in radians, counter-clockwise from x seen from above.
    pub yaw_rad: f32,
}
