//! From a scan and its point labels to a labelled scan.

use std::collections::BTreeMap;
use std::path::Path;

use detector::PointCloud;

use super::semantic_class::{SemanticClass, semantic_class};
use super::upright_components::upright_components;
use crate::annotation::{Annotation, AnnotationClass, LabeledScan, PointRegion, ScanId};
use crate::dataset::DatasetError;

/// The scan `id` with one annotation for each instance, then one for each pole or sign; `path` is the file of `labels`.
///
/// Annotations have no boxes. Their tracks are the whole labels, which the same object keeps throughout its drive. Things of
/// instance 0 are objects that were not told apart: their points become unscorable, as those do whose label leaves open
/// whether they are an object.
///
/// # Errors
///
/// [`DatasetError::UnknownLabel`] for a class that the format does not have.
pub fn label_scan(
    id: ScanId,
    cloud: PointCloud,
    labels: &[u32],
    path: &Path,
) -> Result<LabeledScan, DatasetError> {
    let mut instances: BTreeMap<u32, (AnnotationClass, Vec<u32>)> = BTreeMap::new();
    let mut uprights = Vec::new();
    let mut point_regions = vec![PointRegion::Labeled; labels.len()];
    for ((point_idx, &label), region) in (0_u32..).zip(labels).zip(&mut point_regions) {
        let (number, instance) = (label as u16, label >> 16);
        let class = semantic_class(number).ok_or_else(|| DatasetError::UnknownLabel {
            path: path.to_path_buf(),
            point_idx,
            label: number,
        })?;
        let told_apart = match class {
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
        if let Some(class) = told_apart {
            instances.entry(label).or_insert_with(|| (class, Vec::new())).1.push(point_idx);
        }
    }
    let of_instances =
        instances.into_iter().map(|(label, (class, points))| annotation(class, points, Some(label)));
    let of_uprights = upright_components(&cloud, &uprights)
        .into_iter()
        .map(|points| annotation(AnnotationClass::Pole, points, None));
    let annotations = of_instances.chain(of_uprights).collect();
    Ok(LabeledScan { id, cloud, annotations, point_regions })
}

fn annotation(class: AnnotationClass, point_indices: Vec<u32>, track: Option<u32>) -> Annotation {
    Annotation { class, bounding_box: None, point_indices, track, occlusion: None, truncation: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points 2 m apart, with these classes and instances.
    fn label(labels: &[(u32, u32)]) -> Result<LabeledScan, DatasetError> {
        let labels: Vec<u32> = labels.iter().map(|(class, instance)| class | instance << 16).collect();
        let cloud: PointCloud = (0..labels.len()).map(|it| [2.0 * it as f32, 0.0, 0.0]).collect();
        label_scan(ScanId { sequence: "00".to_owned(), index: 0 }, cloud, &labels, Path::new("a.label"))
    }

    #[test]
    fn instances_and_poles_are_objects() {
        let scan = label(&[(80, 0), (10, 7), (252, 7), (10, 7), (81, 0), (40, 0)]).unwrap();
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
    fn what_is_not_told_apart_is_unscorable() {
        let scan = label(&[(0, 0), (10, 0), (70, 0), (71, 0), (99, 0), (50, 0)]).unwrap();
        assert_eq!(scan.annotations, []);
        let n_unscorable = scan.point_regions.iter().filter(|it| **it == PointRegion::Unscorable).count();
        assert_eq!((n_unscorable, scan.point_regions[5]), (5, PointRegion::Labeled));
    }

    #[test]
    fn a_label_that_the_format_does_not_have_is_named_with_its_point() {
        let error = label(&[(10, 1), (12, 0)]).expect_err("no such label");
        assert_eq!(error.to_string(), r#""a.label", point 1: there is no label 12"#);
    }
}
