//! Classes that are asked for of a detector in a scan.

use std::collections::BTreeSet;

use detector::Detections;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::task::Task;
use scans::annotation::LabeledScan;

use super::running_detector::RunningDetector;

/// Whether a detector gives classes, as its first detections show if it does not say so before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum GivesClasses {
    /// It has not detected anything so far.
    Unknown,
    /// It does: in scans without detections it has missed all objects.
    Yes,
    /// It gives these, none or more.
    Only(Vec<AnnotationClass>),
    /// It does not.
    No,
}

impl GivesClasses {
    /// Nothing is known of `detector`, unless it cannot give classes.
    pub fn of(detector: &dyn RunningDetector) -> Self {
        match detector.known_classes() {
            Some(known) => Self::Only(known),
            None if detector.may_give_classes() => Self::Unknown,
            None => Self::No,
        }
    }

    /// Looks at `detections`.
    pub fn look(&mut self, detections: &Detections) {
        if *self == Self::Unknown && !detections.is_empty() {
            let any = detections.iter().any(|it| it.given.is_some());
            *self = if any { Self::Yes } else { Self::No };
        }
    }

    /// The tasks of `detector` in `scan`: those of every detector, and those of the classes that are annotated or given in
    /// it.
    pub fn tasks(
        &self,
        detector: &dyn RunningDetector,
        scan: &LabeledScan,
        detections: &Detections,
    ) -> Vec<Task> {
        let may_give = detector.may_give_classes();
        self.tasks_of(may_give, scan, detections)
    }

    fn tasks_of(&self, may_give: bool, scan: &LabeledScan, detections: &Detections) -> Vec<Task> {
        let mut tasks = Task::ALL.to_vec();
        if *self == Self::No || *self == Self::Unknown && !may_give {
            return tasks;
        }
        let given = detections.iter().filter_map(|it| AnnotationClass::written(it.given?.name()).ok());
        let annotated = scan.annotations.iter().map(|it| it.class);
        let mut classes: BTreeSet<AnnotationClass> =
            annotated.chain(given).filter(|it| *it != AnnotationClass::Misc).collect();
        if let Self::Only(known) = self {
            classes.retain(|it| known.contains(it));
        }
        let of_groups = AnnotationClass::of_whole_groups();
        let asked = of_groups.into_iter().filter(|it| classes.iter().any(|class| it.includes(*class)));
        let asked: Vec<AnnotationClass> = asked.collect();
        classes.extend(asked);
        tasks.extend(classes.into_iter().map(Task::Class));
        tasks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::{DetectedClass, Detection, GivenClass, OrientedBox, PointCloud};
    use scans::annotation::{Annotation, ScanId};

    #[test]
    fn the_first_detections_show_whether_classes_are_given() {
        let id = ScanId { sequence: "drawn".to_owned(), index: 0 };
        let annotations = [AnnotationClass::Misc, AnnotationClass::Pole].map(Annotation::of).to_vec();
        let scan = LabeledScan::everywhere(id, PointCloud::default(), annotations);
        let cube = OrientedBox { center_m: [9.0, 0.0, 0.0], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        let one = |given: Option<&str>| -> Detections {
            let given = given.map(|it| GivenClass::new(it, it));
            [Detection { given, ..Detection::new(&[], cube, DetectedClass::Object, None) }]
                .into_iter()
                .collect()
        };
        let mut gives = GivesClasses::Unknown;
        gives.look(&Detections::default());
        let only = GivesClasses::Only(vec![AnnotationClass::Truck, AnnotationClass::Pedestrian]);
        let pole = Task::Class(AnnotationClass::Pole);
        let nothing = Detections::default();
        assert_eq!(gives.tasks_of(true, &scan, &nothing), [Task::Objects, Task::Vehicles, pole]);
        assert_eq!(gives.tasks_of(false, &scan, &nothing), Task::ALL);
        assert_eq!(only.tasks_of(false, &scan, &nothing), Task::ALL);
        let mut does = gives.clone();
        does.look(&one(Some("truck")));
        does.look(&one(None));
        let truck = Task::Class(AnnotationClass::Truck);
        assert_eq!(
            does.tasks_of(true, &scan, &one(Some("truck"))),
            [Task::Objects, Task::Vehicles, truck, pole]
        );
        let asked = only.tasks_of(false, &scan, &one(Some("truck")));
        assert_eq!(asked, [Task::Objects, Task::Vehicles, truck]);
        gives.look(&one(None));
        gives.look(&one(Some("truck")));
        assert_eq!(gives.tasks_of(true, &scan, &one(Some("truck"))), Task::ALL);
    }
}
