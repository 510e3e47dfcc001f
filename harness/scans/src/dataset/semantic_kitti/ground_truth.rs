//! Makes a labelled scan of a scan and its point labels.

use std::collections::BTreeMap;
use std::path::Path;

use reports::vocabulary::class::AnnotationClass;

use super::semantic_class::{SemanticClass, semantic_class};
use super::upright_components::upright_components;
use crate::annotation::{Annotation, LabeledScan, PointRegion, ScanId};
use crate::dataset::class_table::ClassReader;
use crate::dataset::positioned_points::PositionedPoints;

/// The scan `id` with one annotation for each instance, then one for each pole or sign; `path` is the file of `labels`, one
/// for each point of the file of `points`.
///
/// Annotations have no boxes. Their tracks are the whole labels, which an object keeps throughout its drive. Points of
/// instance 0 belong to objects that were labelled without separating them: they become unscorable, like points whose label
/// leaves open whether they are an object.
///
/// Points with a label that is not in the format are noted in `classes`, by its number, and are unscorable.
pub fn label_scan(
    id: ScanId,
    points: PositionedPoints,
    labels: &[u32],
    path: &Path,
    classes: &mut ClassReader<'_>,
) -> LabeledScan {
    let labels = points.values_of_kept(labels);
    let (cloud, points_left_out) = points.into_parts();
    let mut instances: BTreeMap<u32, (AnnotationClass, Vec<u32>)> = BTreeMap::new();
    let mut uprights = Vec::new();
    let mut point_regions = vec![PointRegion::Labeled; labels.len()];
    for ((point_idx, &label), region) in (0_u32..).zip(&labels).zip(&mut point_regions) {
        let (number, instance) = (label as u16, label >> 16);
        let position = || format!("{path:?}, point {point_idx}");
        let class = class_of_number(number, classes, position).unwrap_or(SemanticClass::Unscorable);
        let instance_class = match class {
            SemanticClass::Object(class) | SemanticClass::UnscorableUnlessInstance(class) if instance > 0 => {
                Some(class)
            }
            SemanticClass::Upright if instance > 0 => Some(AnnotationClass::Pole),
            SemanticClass::Upright => {
                uprights.push(point_idx);
                None
            }
            SemanticClass::Object(_)
            | SemanticClass::Unscorable
            | SemanticClass::UnscorableUnlessInstance(_) => {
                *region = PointRegion::Unscorable;
                None
            }
            SemanticClass::Background => None,
        };
        if let Some(class) = instance_class {
            instances.entry(label).or_insert_with(|| (class, Vec::new())).1.push(point_idx);
        }
    }
    let of_instances =
        instances.into_iter().map(|(label, (class, points))| annotation(class, points, Some(label)));
    let of_uprights = upright_components(&cloud, &uprights)
        .into_iter()
        .map(|points| annotation(AnnotationClass::Pole, points, None));
    let everywhere = LabeledScan::everywhere(id, cloud, of_instances.chain(of_uprights).collect());
    LabeledScan { point_regions, points_left_out, ..everywhere }
}

/// The class of a label's number: as the user has it, else as the format has it. A number unknown to both is noted.
pub fn class_of_number(
    number: u16,
    classes: &mut ClassReader<'_>,
    position: impl FnOnce() -> String,
) -> Option<SemanticClass> {
    let of_class = |class| match class {
        AnnotationClass::Pole => SemanticClass::Upright,
        class => SemanticClass::Object(class),
    };
    if classes.has_own_classes()
        && let Some(class) = classes.own_class_of(&number.to_string())
    {
        return Some(of_class(class));
    }
    semantic_class(number).or_else(|| classes.class_of(&number.to_string(), position).map(of_class))
}

fn annotation(class: AnnotationClass, point_indices: Vec<u32>, track: Option<u32>) -> Annotation {
    Annotation { point_indices, track, ..Annotation::of(class) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::class_table::{ClassRules, UnknownClasses};

    /// Points 2 m apart, with these classes and instances.
    fn label(labels: &[(u32, u32)], rules: &ClassRules) -> (LabeledScan, UnknownClasses) {
        let labels: Vec<u32> = labels.iter().map(|(class, instance)| class | instance << 16).collect();
        let mut points = PositionedPoints::default();
        for index in 0..labels.len() {
            points.push([2.0 * index as f64, 0.0, 0.0], 0.0).unwrap();
        }
        let mut classes = ClassReader::new(rules, &[]);
        let id = ScanId { sequence: "00".to_owned(), index: 0 };
        let scan = label_scan(id, points, &labels, Path::new("a.label"), &mut classes);
        (scan, classes.unknown().clone())
    }

    #[test]
    fn instances_and_poles_are_objects() {
        let labels = [(80, 0), (10, 7), (252, 7), (10, 7), (81, 0), (40, 0)];
        let (scan, _) = label(&labels, &ClassRules::default());
        let found: Vec<_> =
            scan.annotations.iter().map(|it| (it.class.name(), it.point_indices.clone(), it.track)).collect();
        let car = |number: u32| Some(number | 7 << 16);
        let expected = [
            ("car", vec![1, 3], car(10)),
            ("car", vec![2], car(252)),
            ("pole", vec![0], None),
            ("pole", vec![4], None),
        ];
        assert_eq!(found, expected);
        assert!(scan.point_regions.iter().all(|it| *it == PointRegion::Labeled));
    }

    #[test]
    fn objects_that_are_not_separated_are_unscorable() {
        let labels = [(0, 0), (10, 0), (70, 0), (71, 0), (99, 0), (50, 0)];
        let (scan, _) = label(&labels, &ClassRules::default());
        assert_eq!(scan.annotations, []);
        let n_unscorable = scan.point_regions.iter().filter(|it| **it == PointRegion::Unscorable).count();
        assert_eq!((n_unscorable, scan.point_regions[5]), (5, PointRegion::Labeled));
    }

    #[test]
    fn labels_that_the_format_does_not_have_are_listed_by_number_and_may_be_mapped() {
        let labels = [(10, 1), (12, 3), (300, 0), (12, 3)];
        let (_, unknown) = label(&labels, &ClassRules::default());
        let message = unknown.refuse("drive").expect_err("no such labels").to_string();
        for line in
            [r#"  "12"        2 times, first in "a.label", point 1"#, "  --class 12=misc --class 300=misc"]
        {
            assert!(message.lines().any(|it| it == line), "{line}\n{message}");
        }
        let mut rules = ClassRules::default();
        rules.table.insert("12", AnnotationClass::Truck);
        rules.table.insert("300", AnnotationClass::Pole);
        let (scan, unknown) = label(&labels, &rules);
        assert!(unknown.is_empty());
        let found: Vec<_> =
            scan.annotations.iter().map(|it| (it.class.name(), &it.point_indices[..])).collect();
        assert_eq!(found, [("car", &[0][..]), ("truck", &[1, 3]), ("pole", &[2])]);
    }

    #[test]
    fn labels_stay_with_their_points_where_a_point_has_no_position() {
        let mut points = PositionedPoints::default();
        for x_m in [1.0, f64::NAN, 3.0] {
            points.push([x_m, 0.0, 0.0], 0.0).unwrap();
        }
        let (rules, labels) = (ClassRules::default(), [40, 0xa | 1 << 16, 0xa | 2 << 16]);
        let id = ScanId { sequence: "00".to_owned(), index: 0 };
        let mut classes = ClassReader::new(&rules, &[]);
        let scan = label_scan(id, points, &labels, Path::new("a.label"), &mut classes);
        assert_eq!((scan.points_left_out, scan.point_regions.len()), (vec![1], 2));
        let [car] = &scan.annotations[..] else { panic!("{:?}", scan.annotations) };
        assert_eq!((car.track, &car.point_indices[..]), (Some(0xa | 2 << 16), &[1][..]));
    }
}
