//! Labels and results as the makers of a data set evaluate them: as in their files, without our classes and single
//! precision.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// The labels of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct OfficialScan {
    /// The objects, in the frame of the files: the world's of nuScenes, the car's of Argoverse 2.
    pub objects: Vec<OfficialObject>,
    /// Where ranges are measured from, in that frame, in metres.
    pub origin_m: [f64; 3],
}

/// Name in results that we write for vehicles that count only in protocols that rank boxes; other evaluators ignore it.
pub const UNLIKELY: &str = "unlikely";

/// A labelled or detected object, in the frame of the files.
#[derive(Debug, Clone, PartialEq)]
pub struct OfficialObject {
    /// The name of its class in the files.
    pub name: String,
    /// Its centre.
    pub center_m: [f64; 3],
    /// Its sides.
    pub length_width_height_m: [f64; 3],
    /// Its heading on the ground plan, in radians.
    pub yaw_rad: f64,
    /// Its velocity on the ground plan; `None` if not stated.
    pub velocity_m_per_s: Option<[f64; 2]>,
    /// Attribute for what it is doing; `None` if not stated.
    pub attribute: Option<String>,
    /// Number of points in it, as stated in the files; `None` where they do not, and for detections.
    pub n_points: Option<u64>,
    /// How sure the detector is of it; `None` for labels.
    pub score: Option<f64>,
}

impl OfficialObject {
    /// An object at `frame_from_box` without any other values.
    pub fn new(name: &str, frame_from_box: &Isometry3<f64>, length_width_height_m: [f64; 3]) -> Self {
        let heading = frame_from_box.rotation * Vector3::x();
        Self {
            name: name.to_owned(),
            center_m: frame_from_box.translation.vector.into(),
            length_width_height_m,
            yaw_rad: heading.y.atan2(heading.x),
            velocity_m_per_s: None,
            attribute: None,
            n_points: None,
            score: None,
        }
    }
}

/// A velocity on the ground plan, seen from a frame that is turned.
pub fn turned_velocity([x, y]: [f64; 2], turn: &UnitQuaternion<f64>) -> [f64; 2] {
    let turned = turn * Vector3::new(x, y, 0.0);
    [turned.x, turned.y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Translation3;

    #[test]
    fn a_heading_is_that_on_the_ground_plan() {
        let turn = UnitQuaternion::from_euler_angles(0.2, 0.1, 0.5);
        let tilted = Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), turn);
        let it = OfficialObject::new("car", &tilted, [4.0, 2.0, 1.5]);
        assert_eq!(it.center_m, [1.0, 2.0, 3.0]);
        assert!((it.yaw_rad - 0.5).abs() < 1e-12, "{it:?}");
    }
}
