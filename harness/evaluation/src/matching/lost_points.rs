//! At which stage of a detector an annotation was lost.

use std::collections::BTreeMap;

use detector::stage_product::Shape;
use detector::surface_class::SurfaceClass;
use detector::{Detections, StageProduct};
use reports::vocabulary::reason::MissReason;
use scans::annotation::LabeledScan;

use crate::matching::outcome::{AnnotationOutcome, Assignment};

/// The points of a scan that are in no detection, and the stage that lost each.
pub struct LostPoints<'a> {
    is_detected: Vec<bool>,
    surfaces: Option<&'a [SurfaceClass]>,
    // For every point the size of its cluster, 0 for points of none.
    cluster_size: Vec<u32>,
}

impl<'a> LostPoints<'a> {
    /// Lost points of `detections` in `scan`; `products` are those of the detector's stages.
    pub fn gather(scan: &LabeledScan, detections: &Detections, products: &'a [StageProduct]) -> Self {
        let mut is_detected = vec![false; scan.cloud.len()];
        for detection in detections.iter() {
            for &point_idx in detection.point_indices {
                is_detected[point_idx as usize] = true;
            }
        }
        let mut surfaces = None;
        let mut cluster_size = vec![0; scan.cloud.len()];
        for product in products {
            match &product.shape {
                Shape::LabeledPoints(classes) => surfaces = Some(&classes[..]),
                Shape::Clusters(cluster_of_point) => add_sizes(cluster_of_point, &mut cluster_size),
                _ => {}
            }
        }
        Self { is_detected, surfaces, cluster_size }
    }

    /// Reasons why points of an annotation are in no detection, with the number of points for each, most first.
    pub fn reasons(&self, point_indices: &[u32]) -> Vec<(MissReason, usize)> {
        let mut n_lost: BTreeMap<MissReason, usize> = BTreeMap::new();
        for &point_idx in point_indices.iter().filter(|&&it| !self.is_detected[it as usize]) {
            *n_lost.entry(self.reason(point_idx as usize)).or_default() += 1;
        }
        let mut reasons: Vec<_> = n_lost.into_iter().collect();
        reasons.sort_by_key(|&(_, n_points)| std::cmp::Reverse(n_points));
        reasons
    }

    fn reason(&self, point_idx: usize) -> MissReason {
        if self.cluster_size[point_idx] > 0 {
            return MissReason::ClusterSize;
        }
        match self.surfaces.map_or(SurfaceClass::Short, |it| it[point_idx]) {
            SurfaceClass::Unseen => MissReason::OutsideGrid,
            SurfaceClass::Clutter => MissReason::Clutter,
            SurfaceClass::Ground => MissReason::Ground,
            SurfaceClass::Tall => MissReason::Tall,
            SurfaceClass::Wall => MissReason::Wall,
            SurfaceClass::Short => MissReason::NothingThere,
        }
    }

    /// Points of the largest cluster of an annotation that is no object; 0 if there is none.
    pub fn largest_cluster(&self, point_indices: &[u32]) -> u32 {
        let lost = point_indices.iter().map(|&it| it as usize).filter(|&it| !self.is_detected[it]);
        lost.map(|it| self.cluster_size[it]).max().unwrap_or(0)
    }
}

impl Assignment {
    /// For missed annotations with more than half of their points in no detection, sets the reason to the stage that lost
    /// most of these points, if a stage did. By points such an annotation cannot be found, whatever becomes of the rest.
    pub fn say_where_points_were_lost(&mut self, scan: &LabeledScan, lost: &LostPoints<'_>) {
        use MissReason::{NothingThere, PartlyFound, Split};
        for (annotation, outcome) in scan.annotations.iter().zip(&mut self.annotations) {
            let AnnotationOutcome::Missed(reason @ (NothingThere | PartlyFound | Split)) = outcome else {
                continue;
            };
            let reasons = lost.reasons(&annotation.point_indices);
            let n_lost: usize = reasons.iter().map(|(_, n_points)| n_points).sum();
            if let Some(&(stage, _)) = reasons.first()
                && 2 * n_lost > annotation.point_indices.len()
                && stage != NothingThere
            {
                *reason = stage;
            }
        }
    }
}

/// Writes the size of each point's cluster, if the point has one.
fn add_sizes(cluster_of_point: &[Option<u32>], cluster_size: &mut [u32]) {
    let n_clusters = cluster_of_point.iter().flatten().max().map_or(0, |last| *last as usize + 1);
    let mut sizes = vec![0; n_clusters];
    for cluster in cluster_of_point.iter().flatten() {
        sizes[*cluster as usize] += 1;
    }
    for (cluster, size) in cluster_of_point.iter().zip(cluster_size) {
        if let Some(cluster) = cluster {
            *size = sizes[*cluster as usize];
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use SurfaceClass::{Clutter, Ground, Short, Tall, Unseen, Wall};
    use detector::DetectedClass;
    use reports::vocabulary::class::AnnotationClass::Car;
    use reports::vocabulary::task::Task;
    use scans::dataset::AnnotatedClasses;

    use super::*;
    use crate::matching::assign::assign;
    use crate::matching::criterion::Criterion;
    use crate::matching::drawn_labels::{annotations_in_row, detections_in_row, labeled, row, standard};

    /// A car of 50 points; `detections` and `taken_for` are ranges of its points. Points taken for `Short` are a cluster.
    #[track_caller]
    fn check(detections: &[[u32; 2]], taken_for: &[(SurfaceClass, Range<u32>)], expected: MissReason) {
        let scan = labeled(row(50), annotations_in_row(&[(Car, 0..50)]));
        let detections: Vec<_> =
            detections.iter().map(|&[from, to]| (DetectedClass::Object, from..to)).collect();
        let found = detections_in_row(&detections, None);
        let mut surfaces = vec![Short; 50];
        let mut clusters = vec![None; 50];
        for (class, range) in taken_for {
            let range = range.start as usize..range.end as usize;
            surfaces[range.clone()].fill(*class);
            if *class == Short {
                clusters[range].fill(Some(0));
            }
        }
        let product = |shape| StageProduct { stage: "drawn", name: "drawn", shape };
        let products = [product(Shape::LabeledPoints(surfaces)), product(Shape::Clusters(clusters))];
        let annotated = AnnotatedClasses::EveryObject;
        let mut assignment = assign(&scan, &found, Task::Objects, &annotated, &standard(Criterion::POINTS));
        assignment.say_where_points_were_lost(&scan, &LostPoints::gather(&scan, &found, &products));
        assert_eq!(assignment.annotations, [AnnotationOutcome::Missed(expected)]);
    }

    #[test]
    fn the_stage_that_lost_most_points_is_the_reason() {
        for (class, reason) in [
            (Unseen, MissReason::OutsideGrid),
            (Clutter, MissReason::Clutter),
            (Ground, MissReason::Ground),
            (Tall, MissReason::Tall),
            (Wall, MissReason::Wall),
            (Short, MissReason::ClusterSize),
        ] {
            let other = if class == Ground { Tall } else { Ground };
            check(&[], &[(class, 0..26), (other, 26..50)], reason);
        }
    }

    #[test]
    fn what_the_rest_became_counts_only_where_half_is_in_a_detection() {
        check(&[[0, 24]], &[(Ground, 24..50)], MissReason::Ground);
        check(&[[0, 24]], &[(Ground, 24..40)], MissReason::Ground);
        check(&[[0, 10], [20, 36]], &[(Ground, 36..50)], MissReason::Split);
        // The other points are lost by no stage and are in no detection.
        check(&[[0, 20]], &[], MissReason::PartlyFound);
        check(&[], &[], MissReason::NothingThere);
    }
}
