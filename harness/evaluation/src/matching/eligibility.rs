//! What counts, and what is neither right nor wrong.

use detector::{DetectedClass, Detection};
use scans::annotation::{Annotation, AnnotationClass, LabeledScan, PointRegion};
use scans::task::Task;

use crate::matching::criterion::center_m;
use crate::matching::outcome::{AnnotationOutcome, IgnoredAnnotation};

/// Which annotations are too poor to be judged. The same for every detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EligibilityParams {
    /// Annotations with fewer points are ignored.
    pub min_points: usize,
    /// Annotations and points beyond this distance on the ground plan are ignored, in metres.
    pub max_range_m: f64,
}

impl EligibilityParams {
    /// 20 points and 80 m.
    pub const STANDARD: Self = Self { min_points: 20, max_range_m: 80.0 };
}

/// What `task` makes of a class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// To be found.
    Target,
    /// Neither right nor wrong.
    Ambiguous,
    /// Not to be found.
    Background,
}

fn role(task: Task, class: AnnotationClass) -> Role {
    use AnnotationClass as Class;
    match (task, class) {
        (Task::Objects, _) | (Task::Vehicles, Class::Car | Class::Van | Class::Truck | Class::Bus) => {
            Role::Target
        }
        (Task::Vehicles, Class::Tram | Class::Trailer | Class::Misc) => Role::Ambiguous,
        (Task::Vehicles, _) => Role::Background,
    }
}

/// Whether an annotation of this class is to be found in the task *vehicles*.
pub fn counts_as_vehicle(class: AnnotationClass) -> bool {
    role(Task::Vehicles, class) == Role::Target
}

/// Whether it cannot be said of this class if it is to be found in the task *vehicles*.
pub fn may_be_vehicle(class: AnnotationClass) -> bool {
    role(Task::Vehicles, class) == Role::Ambiguous
}

/// Whether `task` asks for detections of this class.
pub fn asks_for(task: Task, class: DetectedClass) -> bool {
    match task {
        Task::Objects => true,
        Task::Vehicles => class == DetectedClass::Vehicle,
    }
}

/// Why `annotation` takes no part in the matching; `None` if it does.
pub fn exclusion(
    scan: &LabeledScan,
    annotation: &Annotation,
    task: Task,
    params: &EligibilityParams,
) -> Option<AnnotationOutcome> {
    let ignored = |reason| Some(AnnotationOutcome::Ignored(reason));
    match role(task, annotation.class) {
        Role::Background => return Some(AnnotationOutcome::NotAsked),
        Role::Ambiguous => return ignored(IgnoredAnnotation::AmbiguousClass),
        Role::Target => {}
    }
    let n_points = annotation.point_indices.len();
    if n_points < params.min_points || n_points == 0 {
        return ignored(IgnoredAnnotation::TooFewPoints);
    }
    let range_m = center_m(scan, annotation).map_or(0.0, |[x_m, y_m]| x_m.hypot(y_m));
    if range_m > params.max_range_m {
        return ignored(IgnoredAnnotation::BeyondRange);
    }
    let is_labeled = |&&point_idx: &&u32| scan.point_regions[point_idx as usize] == PointRegion::Labeled;
    let n_labeled = annotation.point_indices.iter().filter(is_labeled).count();
    if 2 * n_labeled <= n_points {
        return ignored(IgnoredAnnotation::OutsideLabeledRegion);
    }
    None
}

/// Whether at least half of the points of `detection` are not to be judged: unscorable, outside the labelled region,
/// beyond the range or (as `is_on_ignored` says for every point) on an ignored annotation.
pub fn is_mostly_ignored(
    scan: &LabeledScan,
    detection: &Detection<'_>,
    is_on_ignored: &[bool],
    params: &EligibilityParams,
) -> bool {
    let is_ignored = |&&point_idx: &&u32| {
        is_on_ignored[point_idx as usize]
            || scan.point_regions[point_idx as usize] != PointRegion::Labeled
            || is_beyond_range(scan, point_idx, params)
    };
    2 * detection.point_indices.iter().filter(is_ignored).count() >= detection.point_indices.len()
}

/// Whether point `point_idx` is too far away to be judged.
pub fn is_beyond_range(scan: &LabeledScan, point_idx: u32, params: &EligibilityParams) -> bool {
    let [x_m, y_m, _] = scan.cloud.position_m(point_idx as usize).map(f64::from);
    x_m.hypot(y_m) > params.max_range_m
}
