//! SemanticKITTI's `.label` files: for each point of the scan's file the instance in the upper half of a number, the class
//! in the lower.
//!
//! An instance is a cluster; its class is that of most of its points. Points of instance 0 belong to no cluster. The files
//! lie as in submissions, `sequences/00/predictions/000000.label`, or as [`ResultFiles`] finds them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use reports::vocabulary::class::AnnotationClass;

use super::detections::ForeignDetections;
use super::result_files::ResultFiles;
use super::result_reader::{FoundInScan, OpenResults, ResultReader, ResultsOf};
use crate::annotation::LabeledScan;
use crate::dataset::class_table::{ClassReader, ClassRules};
use crate::dataset::semantic_kitti::ground_truth::class_of_number;
use crate::dataset::semantic_kitti::label_file::read_labels_of_kept;
use crate::dataset::semantic_kitti::semantic_class::SemanticClass;
use crate::foreign::foreign_class::ForeignClass;

/// The ending of the files.
pub const ENDING: &str = ".label";

/// Results with a label for each point.
pub struct SemanticLabels {
    files: BTreeMap<usize, PathBuf>,
    classes: ClassRules,
}

impl SemanticLabels {
    /// Finds the files of the scans.
    pub fn open(files: &ResultFiles, of: &ResultsOf<'_>) -> OpenResults {
        let of_scans = files.of_scans(of.dataset, ENDING);
        let taken: BTreeSet<&Path> = of_scans.values().map(PathBuf::as_path).collect();
        let left_over = files.left_over(ENDING, &taken);
        OpenResults::new(Self { files: of_scans, classes: of.classes.clone() }, left_over)
    }
}

impl ResultReader for SemanticLabels {
    fn has(&self, scan_idx: usize) -> bool {
        self.files.contains_key(&scan_idx)
    }

    fn read(&mut self, scan_idx: usize, scan: &LabeledScan) -> FoundInScan {
        let Some(path) = self.files.get(&scan_idx) else { return Ok(None) };
        let labels = read_labels_of_kept(path, scan)?;
        let mut classes = ClassReader::new(&self.classes, &[]);
        let found = clusters_of(&labels, path, &mut classes);
        classes.unknown().refuse_results(&path.display().to_string())?;
        Ok(Some(ForeignDetections { point_labels: Some(labels), ..found }))
    }
}

/// The instances as clusters, under the numbers of the instances, which have sixteen bits.
fn clusters_of(labels: &[u32], path: &Path, classes: &mut ClassReader<'_>) -> ForeignDetections {
    let clusters: Vec<u32> = labels.iter().map(|label| label >> 16).collect();
    let mut votes: BTreeMap<u32, BTreeMap<Option<AnnotationClass>, u32>> = BTreeMap::new();
    for (point_idx, &label) in labels.iter().enumerate().filter(|(_, label)| **label >> 16 > 0) {
        let position = || format!("{path:?}, point {point_idx}");
        let class = match class_of_number(label as u16, classes, position) {
            Some(SemanticClass::Object(class) | SemanticClass::UnscorableUnlessInstance(class)) => {
                Some(class)
            }
            Some(SemanticClass::Upright) => Some(AnnotationClass::Pole),
            Some(SemanticClass::Background | SemanticClass::Unscorable) | None => None,
        };
        *votes.entry(label >> 16).or_default().entry(class).or_default() += 1;
    }
    let last = votes.last_key_value().map_or(0, |(instance, _)| *instance as usize);
    let mut cluster_classes = vec![None; last];
    for (instance, votes) in votes {
        // Of equal counts the first in the order of classes, so that the result is always the same.
        let most = votes.iter().max_by(|a, b| a.1.cmp(b.1).then(b.0.cmp(a.0)));
        cluster_classes[instance as usize - 1] = most.and_then(|(class, _)| *class).map(ForeignClass::from);
    }
    ForeignDetections { clusters: Some(clusters), cluster_classes, ..ForeignDetections::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instance_is_a_cluster_of_the_class_of_most_of_its_points() {
        // A class, and the number of the instance above it.
        let label = |class: u32, instance: u32| class + (instance << 16);
        let labels = [(40, 0), (10, 3), (10, 3), (18, 3), (70, 0), (81, 1), (0, 3), (40, 9)];
        let labels = labels.map(|(class, instance)| label(class, instance));
        let rules = ClassRules::default();
        let mut classes = ClassReader::new(&rules, &[]);
        let found = clusters_of(&labels, Path::new("a.label"), &mut classes);
        assert_eq!(found.clusters, Some(vec![0, 3, 3, 3, 0, 1, 3, 9]));
        let mut expected = [None; 9];
        (expected[0], expected[2]) = (Some(AnnotationClass::Pole.into()), Some(AnnotationClass::Car.into()));
        assert_eq!(found.cluster_classes, expected);
        assert!(classes.unknown().is_empty());
        assert_eq!(found.check(labels.len()), Ok(()));
    }

    #[test]
    fn without_instances_nothing_is_found() {
        let rules = ClassRules::default();
        let found = clusters_of(&[10, 40], Path::new("a.label"), &mut ClassReader::new(&rules, &[]));
        assert_eq!((found.clusters, found.cluster_classes), (Some(vec![0, 0]), vec![]));
    }
}
