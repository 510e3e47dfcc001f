//! Ground truth: the labels of a person, or of a simulator.
//!
//! It lives here and not beside the detectors, so that no detector can look at it.

use detector::{OrientedBox, PointCloud};
use nalgebra::Matrix3x4;
use reports::vocabulary::class::{AnnotationClass, Occlusion};

/// One scan with its ground truth.
#[derive(Debug, Clone, PartialEq)]
pub struct LabeledScan {
    /// Which scan this is.
    pub id: ScanId,
    /// The points, in the sensor frame.
    pub cloud: PointCloud,
    /// The labelled objects.
    pub annotations: Vec<Annotation>,
    /// For every point, whether the labels say anything about it.
    pub point_regions: Vec<PointRegion>,
    /// Where the labels say something about positions without a point.
    pub labeled_area: LabeledArea,
    /// Indices, among the points of the file, of those that are not in `cloud` since they have no position; ascending.
    pub points_left_out: Vec<u32>,
}

impl LabeledScan {
    /// A scan that is labelled completely, all round.
    pub fn everywhere(id: ScanId, cloud: PointCloud, annotations: Vec<Annotation>) -> Self {
        let point_regions = vec![PointRegion::Labeled; cloud.len()];
        let labeled_area = LabeledArea::Everywhere;
        Self { id, cloud, annotations, point_regions, labeled_area, points_left_out: Vec::new() }
    }

    /// Whether the labels say something about the scan, if only that no object is there.
    pub fn is_labeled(&self) -> bool {
        self.labeled_area != LabeledArea::AsPoints
            || !self.annotations.is_empty()
            || self.point_regions.iter().any(|it| *it != PointRegion::Outside)
    }
}

/// Name of a scan within its data set.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ScanId {
    /// The drive it belongs to, such as `0000`.
    pub sequence: String,
    /// Its number within the drive.
    pub index: u32,
}

impl std::fmt::Display for ScanId {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}/{:06}", self.sequence, self.index)
    }
}

/// One labelled object.
#[derive(Debug, Clone, PartialEq)]
pub struct Annotation {
    /// Its class.
    pub class: AnnotationClass,
    /// The box around the whole object, seen and unseen parts, in the sensor frame. `None` where only points are labelled.
    pub bounding_box: Option<OrientedBox>,
    /// Its points, as indices into the scan, ascending: the labelled ones, or those inside the box.
    pub point_indices: Vec<u32>,
    /// Number of the object within its drive, the same in all scans that show it.
    pub track: Option<u32>,
    /// How much of it is hidden from the sensor by other things.
    pub occlusion: Option<Occlusion>,
    /// Share of it outside the labelled region, 0 to 1.
    pub truncation: Option<f32>,
}

impl Annotation {
    /// An annotation of `class` without any other values.
    pub fn of(class: AnnotationClass) -> Self {
        Self {
            class,
            bounding_box: None,
            point_indices: Vec::new(),
            track: None,
            occlusion: None,
            truncation: None,
        }
    }

    /// Its name on screens, such as `car 7`.
    pub fn label(&self) -> String {
        match self.track {
            Some(track) => format!("{} {track}", self.class.name()),
            None => self.class.name().to_owned(),
        }
    }

    /// Its position in metres: the centre of its box; without one the centroid of its points in `cloud`. `None` if it has
    /// neither.
    ///
    /// Everything that needs one position of an annotation uses it: ranges, slices, the criterion *centre*, pages.
    pub fn center_m(&self, cloud: &PointCloud) -> Option<[f32; 3]> {
        if let Some(bounding_box) = &self.bounding_box {
            return Some(bounding_box.center_m);
        }
        let mut n_points = 0_u32;
        let mut sum_m = [0.0_f64; 3];
        let positions_m = self.point_indices.iter().map(|it| cloud.position_m(*it as usize));
        for position_m in positions_m.filter(|it| it.iter().all(|value| value.is_finite())) {
            n_points += 1;
            sum_m = [0, 1, 2].map(|axis| sum_m[axis] + f64::from(position_m[axis]));
        }
        // Rounded as a box would hold it, so that an echoed annotation lies exactly where it was.
        (n_points > 0).then(|| sum_m.map(|it| (it / f64::from(n_points)) as f32))
    }
}

/// Distance of a position from the sensor on the ground plan, in metres.
pub fn range_m(position_m: [f32; 3]) -> f64 {
    f64::from(position_m[0]).hypot(f64::from(position_m[1]))
}

/// Whether the labels say anything about a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PointRegion {
    /// Labelled: a point of no annotation belongs to no object.
    Labeled,
    /// Marked as not to be judged, such as KITTI's `DontCare`.
    Unscorable,
    /// Outside of what was labelled, such as behind the camera on KITTI.
    Outside,
}

impl PointRegion {
    /// The number that stands for it in scanbench's own files.
    pub fn number(self) -> u8 {
        self as u8
    }

    /// The region with this number; `None` if there is none.
    pub fn of_number(number: u8) -> Option<Self> {
        [Self::Labeled, Self::Unscorable, Self::Outside].get(usize::from(number)).copied()
    }
}

/// The part of the ground plan in which objects were labelled, as a data set describes it. Heights do not matter: it is an
/// area, and no set of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LabeledArea {
    /// All round the sensor.
    Everywhere,
    /// The view of a camera: a position belongs to it if any height above or below it projects into the image.
    CameraImage {
        /// From homogeneous sensor coordinates in metres to homogeneous pixels.
        image_from_sensor: Matrix3x4<f64>,
        /// Width and height of the image in pixels.
        image_size_px: [u32; 2],
    },
    /// A sector: positions no farther than this to either side of forward, in degrees.
    Ahead {
        /// 0 to 180.
        to_either_side_deg: f32,
    },
    /// Given by [`LabeledScan::point_regions`] alone: a position is as what the sensor saw in its direction.
    AsPoints,
}

/// Indices of the points of `cloud` inside or on `bounding_box`, ascending.
pub fn points_inside(cloud: &PointCloud, bounding_box: &OrientedBox) -> Vec<u32> {
    let inside =
        cloud.positions_m().zip(0_u32..).filter(|(position_m, _)| bounding_box.contains(*position_m));
    inside.map(|(_, point_idx)| point_idx).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_annotation_without_a_box_stands_at_the_centroid_of_its_points() {
        let cloud = PointCloud::from_iter([
            [1.0, 0.0, 0.0],
            [3.0, 2.0, 1.0],
            [f32::NAN, 0.0, 0.0],
            [90.0, 90.0, 90.0],
        ]);
        let unboxed = Annotation { point_indices: vec![0, 1, 2], ..Annotation::of(AnnotationClass::Car) };
        assert_eq!(unboxed.center_m(&cloud), Some([2.0, 1.0, 0.5]));
        let nowhere = Annotation { point_indices: vec![2], ..unboxed.clone() };
        assert_eq!(nowhere.center_m(&cloud), None);
        let bounding_box =
            OrientedBox { center_m: [3.0, 4.0, 9.0], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        let boxed = Annotation { bounding_box: Some(bounding_box), ..unboxed };
        assert_eq!(boxed.center_m(&cloud).map(range_m), Some(5.0));
    }
}
