//! Which unmatched detections are ignored: neither right nor false.

use std::cell::OnceCell;

use detector::{Detection, OrientedBox};
use reports::vocabulary::reason::IgnoredDetection;
use scans::annotation::{LabeledScan, PointRegion, range_m};

use crate::matching::eligibility::EligibilityParams;
use crate::matching::labeled_positions::LabeledPositions;
use crate::matching::outcome::AnnotationOutcome;

/// Where detections of a scan are not judged.
pub struct UnjudgedPositions<'a> {
    scan: &'a LabeledScan,
    max_range_m: f64,
    // For every point whether it is on an ignored annotation.
    is_on_ignored: Vec<bool>,
    ignored_boxes: Vec<OrientedBox>,
    // Needed only for detections without points.
    labeled_positions: OnceCell<LabeledPositions>,
}

impl<'a> UnjudgedPositions<'a> {
    /// Those of `scan`, where `exclusions` say of every annotation whether and why it does not count.
    pub fn of(
        scan: &'a LabeledScan,
        exclusions: &[Option<AnnotationOutcome>],
        params: &EligibilityParams,
    ) -> Self {
        let mut is_on_ignored = vec![false; scan.cloud.len()];
        let mut ignored_boxes = Vec::new();
        for (annotation, excluded) in scan.annotations.iter().zip(exclusions) {
            if matches!(excluded, Some(AnnotationOutcome::Ignored(_))) {
                for &point_idx in &annotation.point_indices {
                    is_on_ignored[point_idx as usize] = true;
                }
                ignored_boxes.extend(annotation.bounding_box);
            }
        }
        let labeled_positions = OnceCell::new();
        Self { scan, max_range_m: params.max_range_m, is_on_ignored, ignored_boxes, labeled_positions }
    }

    /// Why `detection`, which matches nothing, is neither right nor false; `None` if the labels give no reason.
    ///
    /// One with points is ignored if at least half of them are on ignored annotations, outside the labelled region,
    /// unscorable or beyond the range. One without is ignored if the centre of its box, on the ground plan, is inside the
    /// box of an ignored annotation, where nothing was labelled, or beyond the range; that its box is empty is no reason.
    pub fn why_ignored(&self, detection: &Detection<'_>) -> Option<IgnoredDetection> {
        if detection.point_indices.is_empty() {
            self.why_position_is_ignored(detection.bounding_box.center_m)
        } else {
            self.why_points_are_ignored(detection.point_indices)
        }
    }

    fn why_points_are_ignored(&self, point_indices: &[u32]) -> Option<IgnoredDetection> {
        let [mut n_on_ignored, mut n_outside, mut n_far, mut n_ignored] = [0; 4];
        for &point_idx in point_indices {
            let point_idx = point_idx as usize;
            let region = self.scan.point_regions[point_idx];
            let is_on_ignored = self.is_on_ignored[point_idx];
            let is_far = range_m(self.scan.cloud.position_m(point_idx)) > self.max_range_m;
            n_on_ignored += usize::from(is_on_ignored);
            n_outside += usize::from(region == PointRegion::Outside);
            n_far += usize::from(is_far);
            n_ignored += usize::from(is_on_ignored || region != PointRegion::Labeled || is_far);
        }
        let is_half = |n_points: usize| 2 * n_points >= point_indices.len();
        is_half(n_ignored).then(|| {
            if is_half(n_on_ignored) {
                IgnoredDetection::OnIgnoredAnnotation
            } else if is_half(n_outside) {
                IgnoredDetection::OutsideLabeledRegion
            } else if is_half(n_far) {
                IgnoredDetection::BeyondRange
            } else {
                IgnoredDetection::OnIgnoredPoints
            }
        })
    }

    fn why_position_is_ignored(&self, center_m: [f32; 3]) -> Option<IgnoredDetection> {
        let positions = || self.labeled_positions.get_or_init(|| LabeledPositions::of(self.scan));
        if self.ignored_boxes.iter().any(|it| is_within(it, center_m)) {
            Some(IgnoredDetection::OnIgnoredAnnotation)
        } else if positions().is_outside([center_m[0], center_m[1]]) {
            Some(IgnoredDetection::OutsideLabeledRegion)
        } else if range_m(center_m) > self.max_range_m {
            Some(IgnoredDetection::BeyondRange)
        } else {
            None
        }
    }
}

/// Whether a position is inside the box on the ground plan.
fn is_within(bounding_box: &OrientedBox, [x_m, y_m, _]: [f32; 3]) -> bool {
    let [box_x_m, box_y_m, box_z_m] = bounding_box.center_m;
    let [length_m, width_m, _] = bounding_box.length_width_height_m;
    let [dx_m, dy_m] = [x_m - box_x_m, y_m - box_y_m];
    // Twice the square of half the diagonal: most boxes are far away; this is decided without an angle.
    dx_m * dx_m + dy_m * dy_m <= 0.5 * (length_m * length_m + width_m * width_m)
        && bounding_box.contains([x_m, y_m, box_z_m])
}
