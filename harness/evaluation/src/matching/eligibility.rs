//! Which annotations count, and which are neither right nor wrong.

use detector::{DetectedClass, Detection};
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::class_traits::ClassGroup;
use reports::vocabulary::own_slice::SliceBounds;
use reports::vocabulary::reason::IgnoredAnnotation;
use reports::vocabulary::task::Task;
use scans::annotation::{Annotation, LabeledScan, PointRegion, range_m};

use crate::matching::criterion::Criterion;
use crate::matching::height_above_ground::heights_above_ground_m;
use crate::matching::outcome::AnnotationOutcome;

/// In the task *objects* an annotation that reaches higher above the ground than this is tall, in metres; see
/// [`reports::vocabulary::class_traits::ClassTraits::may_be_tall`].
///
/// Paper: HG, whose objects are short street objects, as vehicles, pedestrians and mail boxes; signs, walls and lamp posts
/// are tall, from 3.10 m on (section 3.1).
pub const TALL_ABOVE_GROUND_M: f64 = 3.10;

/// Which annotations are too poor to be judged. Every detector is judged by the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EligibilityParams {
    /// Annotations with fewer points are ignored.
    pub min_points: usize,
    /// Annotations and points beyond this distance on the ground plan are ignored, in metres.
    pub max_range_m: f64,
    /// Annotations that reach higher above the ground are ignored in the task *objects*, in metres: see [`reports::vocabulary::class_traits::ClassTraits::may_be_tall`].
    pub tall_above_ground_m: f64,
    /// The slice outside of which nothing is judged; `None` for everywhere.
    pub only: Option<&'static SliceBounds>,
}

impl EligibilityParams {
    /// 20 points, 80 m and 3.10 m.
    pub const STANDARD: Self =
        Self { min_points: 20, max_range_m: 80.0, tall_above_ground_m: TALL_ABOVE_GROUND_M, only: None };
}

/// Role of a class in a task.
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
    match task {
        Task::Objects => Role::Target,
        Task::Vehicles if class.group() == Some(ClassGroup::Vehicle) => Role::Target,
        Task::Vehicles if class.traits().may_be_vehicle => Role::Ambiguous,
        Task::Class(asked) if asked.includes(class) => Role::Target,
        // It may be of the class that is asked for.
        Task::Class(asked) if class.includes(asked) => Role::Ambiguous,
        Task::Class(_) if class == AnnotationClass::Misc => Role::Ambiguous,
        Task::Vehicles | Task::Class(_) => Role::Background,
    }
}

/// Whether an annotation of this class is to be found in the task *vehicles*.
pub fn counts_as_vehicle(class: AnnotationClass) -> bool {
    role(Task::Vehicles, class) == Role::Target
}

/// Whether annotations of this class may or may not be vehicles, so that the task *vehicles* ignores them.
pub fn may_be_vehicle(class: AnnotationClass) -> bool {
    role(Task::Vehicles, class) == Role::Ambiguous
}

/// Whether `task` asks for `detection`.
pub fn asks_for(task: Task, detection: &Detection<'_>) -> bool {
    match task {
        Task::Objects => true,
        Task::Vehicles => detection.class == DetectedClass::Vehicle,
        Task::Class(class) => {
            let given = detection.given.and_then(|it| AnnotationClass::met(it.name()));
            given.is_some_and(|it| class.includes(it))
        }
    }
}

/// For every annotation of `scan` why it is excluded from the matching; `None` if it is not.
///
/// Of several reasons the first counts: too few points, beyond the range, unscorable, without a box where `criterion` needs
/// one, tall. So a tall annotation would count but for its height. A labelled object counts wherever its points lie, also
/// outside the labelled region.
pub fn exclusions(
    scan: &LabeledScan,
    task: Task,
    criterion: Criterion,
    params: &EligibilityParams,
) -> Vec<Option<AnnotationOutcome>> {
    let mut exclusions: Vec<Option<AnnotationOutcome>> = scan
        .annotations
        .iter()
        .map(|it| exclusion(scan, it, task, params).or_else(|| without_box(it, criterion)))
        .collect();
    if task == Task::Objects {
        let may_be_tall = |&annotation_idx: &usize| {
            let class = scan.annotations[annotation_idx].class;
            exclusions[annotation_idx].is_none() && class.traits().may_be_tall()
        };
        let asked: Vec<usize> = (0..exclusions.len()).filter(may_be_tall).collect();
        for (annotation_idx, height_m) in asked.iter().zip(heights_above_ground_m(scan, &asked)) {
            if height_m.is_some_and(|it| it > params.tall_above_ground_m) {
                exclusions[*annotation_idx] = Some(AnnotationOutcome::Ignored(IgnoredAnnotation::Tall));
            }
        }
    }
    exclusions
}

fn exclusion(
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
    if annotation.center_m(&scan.cloud).is_some_and(|it| range_m(it) > params.max_range_m) {
        return ignored(IgnoredAnnotation::BeyondRange);
    }
    if 2 * n_points_in(scan, annotation, PointRegion::Unscorable) >= n_points {
        return ignored(IgnoredAnnotation::Unscorable);
    }
    None
}

fn without_box(annotation: &Annotation, criterion: Criterion) -> Option<AnnotationOutcome> {
    let is_unboxed = criterion.needs_boxes() && annotation.bounding_box.is_none();
    is_unboxed.then_some(AnnotationOutcome::Ignored(IgnoredAnnotation::NoBox))
}

/// Number of points of `annotation` that lie in a region of this kind.
pub fn n_points_in(scan: &LabeledScan, annotation: &Annotation, region: PointRegion) -> usize {
    let is_there = |point_idx: &&u32| scan.point_regions[**point_idx as usize] == region;
    annotation.point_indices.iter().filter(is_there).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_of_a_whole_group_asks_for_all_of_them_and_is_no_mistake_in_theirs() {
        use reports::vocabulary::class_traits::ClassTraits;
        let traits =
            ClassTraits { group: Some(ClassGroup::Cycle), whole_group: true, ..ClassTraits::default() };
        let cycle = AnnotationClass::define("some-cycle", traits).unwrap();
        assert_eq!(role(Task::Class(cycle), AnnotationClass::ParkedCycle), Role::Target);
        assert_eq!(role(Task::Class(cycle), AnnotationClass::Pedestrian), Role::Background);
        assert_eq!(role(Task::Class(AnnotationClass::Cyclist), cycle), Role::Ambiguous);
        assert_eq!(role(Task::Vehicles, cycle), Role::Background);
    }

    #[test]
    fn vehicles_people_and_cycles_are_never_tall() {
        use AnnotationClass::{Fence, Hedge, Misc, Pole, StreetFurniture, Tree};
        let tall: Vec<_> = AnnotationClass::ALL.into_iter().filter(|it| it.traits().may_be_tall()).collect();
        assert_eq!(tall, [Pole, Tree, Hedge, Fence, StreetFurniture, Misc]);
        assert!(!tall.iter().any(|it| counts_as_vehicle(*it)));
    }
}
