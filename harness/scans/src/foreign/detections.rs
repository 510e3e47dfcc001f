//! Detections of another program in one scan.

use crate::dataset::kitti::label::KittiObject;
use crate::dataset::official::OfficialObject;
use crate::dataset::positioned_points::MAX_COORDINATE_M;
use crate::foreign::foreign_class::ForeignClass;
use detector::OrientedBox;

/// A longer side of a box is damage, in metres.
pub const MAX_SIDE_M: f32 = 1000.0;
/// More boxes of one scan are damage.
pub const MAX_BOXES: usize = 100_000;

/// Detections of another program in one scan, in the frame of the scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ForeignDetections {
    /// For every point of the cloud the number of its cluster: 0 is none, others begin at 1 and may have gaps. `None` if
    /// there are only boxes.
    pub clusters: Option<Vec<u32>>,
    /// The class of cluster *k* at index *k* − 1, if clusters have classes; empty if they have none, or boxes have them.
    pub cluster_classes: Vec<Option<ForeignClass>>,
    /// The boxes; if there are clusters, that of cluster *k* at index *k* − 1.
    pub boxes: Vec<ForeignBox>,
    /// The lines of `boxes` in KITTI's files, to the last digit; `None` for other files.
    pub kitti_objects: Option<Vec<KittiObject>>,
    /// The boxes as in the file, in the same order; empty if the makers of the format have no evaluation.
    pub official: Vec<OfficialObject>,
    /// For every point of the cloud its label, class and instance, if results are in SemanticKITTI's format.
    pub point_labels: Option<Vec<u32>>,
}

/// A box detected by another program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForeignBox {
    /// The box, in the frame of the scan.
    pub bounding_box: OrientedBox,
    /// Its class; `None` if the file has no class.
    pub class: Option<ForeignClass>,
    /// How sure the program is; more is surer.
    pub score: Option<f32>,
    /// How sure it is of the box, if files have a score for this as well.
    pub box_score: Option<f32>,
    /// Velocity over ground along x and y of the frame of the scan, in metres per second, if files have one.
    pub velocity_m_per_s: Option<[f32; 2]>,
    /// Whether only protocols that rank boxes count it: so are unlikely vehicles in files of our own detectors.
    pub is_unlikely: bool,
}

impl ForeignDetections {
    /// Boxes alone.
    pub fn of_boxes(boxes: Vec<ForeignBox>) -> Self {
        Self { boxes, ..Self::default() }
    }

    /// Makes sure that they can be detections in a scan of `n_points`, as the protocol for detectors does. Errors say what
    /// is wrong.
    ///
    /// # Errors
    ///
    /// If there are more than [`MAX_BOXES`]; a number is NaN or infinite; a side is not above 0 and at most [`MAX_SIDE_M`];
    /// a centre is beyond [`MAX_COORDINATE_M`]; points lack clusters; or clusters lack boxes, though there are some.
    pub fn check(&self, n_points: usize) -> Result<(), String> {
        if self.boxes.len() > MAX_BOXES {
            return Err(format!("there are {} boxes, more than {MAX_BOXES}", self.boxes.len()));
        }
        for (number, it) in (1..).zip(&self.boxes) {
            it.check().map_err(|problem| format!("box {number} {problem}"))?;
        }
        let Some(clusters) = &self.clusters else { return Ok(()) };
        if clusters.len() != n_points {
            return Err(format!("there are clusters of {} points, but {n_points} points", clusters.len()));
        }
        match clusters.iter().max() {
            Some(&last) if !self.boxes.is_empty() && last as usize > self.boxes.len() => {
                Err(format!("cluster {last} has no box: there are {}", self.boxes.len()))
            }
            _ => Ok(()),
        }
    }
}

impl ForeignBox {
    fn check(&self) -> Result<(), String> {
        let OrientedBox { center_m, length_width_height_m, yaw_rad } = &self.bounding_box;
        if !center_m.iter().all(|it| f64::from(it.abs()) <= MAX_COORDINATE_M) {
            return Err(format!("has the centre {center_m:?} m"));
        }
        if !length_width_height_m.iter().all(|it| *it > 0.0 && *it <= MAX_SIDE_M) {
            return Err(format!("has sides of {length_width_height_m:?} m"));
        }
        if !yaw_rad.is_finite() {
            return Err(format!("has the yaw {yaw_rad}"));
        }
        match [self.score, self.box_score].into_iter().flatten().find(|it| !it.is_finite()) {
            Some(score) => Err(format!("has the score {score}")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use reports::vocabulary::class::AnnotationClass;

    /// A car ahead.
    pub(crate) fn car() -> ForeignBox {
        ForeignBox {
            bounding_box: OrientedBox {
                center_m: [10.0, -3.0, -0.9],
                length_width_height_m: [4.2, 1.8, 1.5],
                yaw_rad: 0.5,
            },
            class: Some(AnnotationClass::Car.into()),
            score: Some(0.5),
            box_score: None,
            velocity_m_per_s: None,
            is_unlikely: false,
        }
    }

    #[track_caller]
    fn check_refused(change: impl Fn(&mut ForeignBox), problem: &str) {
        let mut damaged = car();
        change(&mut damaged);
        let detections = ForeignDetections::of_boxes(vec![car(), damaged]);
        assert_eq!(detections.check(0), Err(problem.to_owned()));
    }

    #[test]
    fn boxes_beyond_all_measure_are_refused() {
        assert_eq!(ForeignDetections::of_boxes(vec![car()]).check(9), Ok(()));
        check_refused(
            |it| it.bounding_box.center_m[1] = f32::NAN,
            "box 2 has the centre [10.0, NaN, -0.9] m",
        );
        check_refused(
            |it| it.bounding_box.center_m[0] = 20_000.0,
            "box 2 has the centre [20000.0, -3.0, -0.9] m",
        );
        check_refused(
            |it| it.bounding_box.length_width_height_m[0] = 1001.0,
            "box 2 has sides of [1001.0, 1.8, 1.5] m",
        );
        check_refused(
            |it| it.bounding_box.length_width_height_m[2] = 0.0,
            "box 2 has sides of [4.2, 1.8, 0.0] m",
        );
        check_refused(|it| it.bounding_box.yaw_rad = f32::INFINITY, "box 2 has the yaw inf");
        check_refused(|it| it.score = Some(f32::NAN), "box 2 has the score NaN");
        check_refused(|it| it.box_score = Some(f32::INFINITY), "box 2 has the score inf");
    }

    #[test]
    fn clusters_belong_to_the_points_and_to_the_boxes() {
        let of = |clusters: &[u32], boxes: &[ForeignBox]| {
            let clusters = Some(clusters.to_vec());
            ForeignDetections { clusters, boxes: boxes.to_vec(), ..ForeignDetections::default() }.check(3)
        };
        assert_eq!(of(&[0, 7, u32::MAX], &[]), Ok(()));
        assert_eq!(of(&[0, 1, 1], &[car(), car()]), Ok(()));
        assert_eq!(of(&[0, 1], &[]), Err("there are clusters of 2 points, but 3 points".to_owned()));
        assert_eq!(of(&[0, 1, 2], &[car()]), Err("cluster 2 has no box: there are 1".to_owned()));
    }
}
