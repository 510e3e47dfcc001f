//! One segment for every point, as scores of labels need it.

use detector::Detections;

use crate::matching::detection_order::detection_ranks;

/// For every point of a scan of `n_points` the number of the detection it belongs to, from 1; 0 of none.
///
/// Of several it is the first by [`detection_ranks`], so that the order in which a detector reports them changes nothing.
pub fn found_segments(detections: &Detections, n_points: usize) -> Vec<u32> {
    let ranks = detection_ranks(detections);
    let mut segments = vec![0; n_points];
    for (detection_idx, detection) in detections.iter().enumerate() {
        for &point_idx in detection.point_indices {
            let segment: &mut u32 = &mut segments[point_idx as usize];
            if *segment == 0 || ranks[detection_idx] < ranks[*segment as usize - 1] {
                *segment = detection_idx as u32 + 1;
            }
        }
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::{DetectedClass, Detection, OrientedBox};

    #[test]
    fn a_point_of_several_detections_belongs_to_the_surest() {
        let bounding_box = OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        let detection = |point_indices, score| {
            Detection::new(point_indices, bounding_box, DetectedClass::Object, Some(score))
        };
        let (sure, unsure) = (detection(&[1, 2], 0.9), detection(&[0, 1], 0.1));
        let of = |all: [Detection<'_>; 2]| found_segments(&all.into_iter().collect(), 4);
        assert_eq!(of([sure, unsure]), [2, 1, 1, 0]);
        assert_eq!(of([unsure, sure]), [1, 2, 2, 0]);
    }
}
