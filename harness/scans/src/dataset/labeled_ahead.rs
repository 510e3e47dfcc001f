//! Labels that reach only so far to either side of forward.

use super::{Dataset, DatasetError, Listing};
use crate::annotation::{Annotation, LabeledArea, LabeledScan, PointRegion};

/// Marks all points farther than `limit_deg` to either side of forward as outside of the labelled area, and takes away the
/// annotations that lie there: without a point nearer to forward or, if they have no points, with a centre that is farther.
/// An object that the limit cuts keeps all of its points, as where people label the view of a camera.
pub fn keep_ahead(scan: &mut LabeledScan, limit_deg: f32) {
    let is_ahead = |x_m: f32, y_m: f32| y_m.atan2(x_m).abs().to_degrees() <= limit_deg;
    let columns = scan.cloud.x_m().iter().zip(scan.cloud.y_m());
    for ((x_m, y_m), region) in columns.zip(&mut scan.point_regions) {
        if !is_ahead(*x_m, *y_m) {
            *region = PointRegion::Outside;
        }
    }
    let (regions, cloud) = (&scan.point_regions, &scan.cloud);
    let has_a_point_ahead = |it: &Annotation| {
        it.point_indices.iter().any(|point_idx| regions[*point_idx as usize] != PointRegion::Outside)
    };
    let stands_ahead = |it: &Annotation| it.center_m(cloud).is_none_or(|[x_m, y_m, _]| is_ahead(x_m, y_m));
    scan.annotations
        .retain(|it| if it.point_indices.is_empty() { stands_ahead(it) } else { has_a_point_ahead(it) });
    scan.labeled_area = match scan.labeled_area {
        LabeledArea::Everywhere => LabeledArea::Ahead { to_either_side_deg: limit_deg },
        LabeledArea::Ahead { to_either_side_deg } => {
            LabeledArea::Ahead { to_either_side_deg: to_either_side_deg.min(limit_deg) }
        }
        // What two limits leave.
        LabeledArea::CameraImage { .. } | LabeledArea::AsPoints => LabeledArea::AsPoints,
    };
}

/// A data set whose labels reach only so far, whatever its files say.
pub struct LabeledAhead {
    dataset: Box<dyn Dataset>,
    limit_deg: f32,
}

impl LabeledAhead {
    /// `dataset` with labels up to `limit_deg` to either side of forward, 0 to 180.
    pub fn new(dataset: Box<dyn Dataset>, limit_deg: f32) -> Self {
        Self { dataset, limit_deg }
    }
}

impl Dataset for LabeledAhead {
    fn listing(&self) -> &Listing {
        self.dataset.listing()
    }

    fn inner(&self) -> Option<&dyn Dataset> {
        Some(&*self.dataset)
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let mut scan = self.dataset.read_scan(scan_idx)?;
        keep_ahead(&mut scan, self.limit_deg);
        Ok(scan)
    }
}

#[cfg(test)]
mod tests {
    use detector::{OrientedBox, PointCloud};
    use reports::vocabulary::class::AnnotationClass;

    use super::*;
    use crate::annotation::ScanId;

    const AHEAD: [f32; 3] = [10.0, 5.0, 0.0];
    const BESIDE: [f32; 3] = [10.0, 11.0, 0.0];
    const BEHIND: [f32; 3] = [-10.0, 0.0, 0.0];

    fn boxed(center_m: [f32; 3]) -> Annotation {
        let bounding_box = OrientedBox { center_m, length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        Annotation { bounding_box: Some(bounding_box), ..Annotation::of(AnnotationClass::Car) }
    }

    /// What 45 degrees leave of three points, of objects with these points, and of boxes without points.
    fn kept(labeled_area: LabeledArea) -> LabeledScan {
        let with_points = |point_indices: Vec<u32>| Annotation { point_indices, ..boxed(BESIDE) };
        let annotations = vec![with_points(vec![0, 1]), with_points(vec![1, 2]), boxed(AHEAD), boxed(BEHIND)];
        let id = ScanId { sequence: "a".to_owned(), index: 0 };
        let cloud = PointCloud::from_iter([AHEAD, BESIDE, BEHIND]);
        let mut scan = LabeledScan { labeled_area, ..LabeledScan::everywhere(id, cloud, annotations) };
        scan.point_regions[0] = PointRegion::Unscorable;
        keep_ahead(&mut scan, 45.0);
        scan
    }

    #[test]
    fn what_lies_farther_to_a_side_is_not_labelled() {
        let scan = kept(LabeledArea::Everywhere);
        assert_eq!(scan.point_regions, [PointRegion::Unscorable, PointRegion::Outside, PointRegion::Outside]);
        let kept: Vec<_> =
            scan.annotations.iter().map(|it| (it.point_indices.len(), it.center_m(&scan.cloud))).collect();
        assert_eq!(kept, [(2, Some(BESIDE)), (0, Some(AHEAD))]);
        assert_eq!(scan.labeled_area, LabeledArea::Ahead { to_either_side_deg: 45.0 });
    }

    #[test]
    fn a_narrower_area_stays_as_it_is() {
        let narrow = LabeledArea::Ahead { to_either_side_deg: 30.0 };
        assert_eq!(kept(narrow).labeled_area, narrow);
        assert_eq!(kept(LabeledArea::AsPoints).labeled_area, LabeledArea::AsPoints);
    }
}
