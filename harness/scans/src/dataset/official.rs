//! What the makers of a data set evaluate: labels and results as their files have them, before our classes and single
//! precision.

use nalgebra::{Isometry3, Vector3};

/// The labels of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct OfficialScan {
    /// The objects, in the frame of the files: the world's of nuScenes, the car's of Argoverse 2.
    pub objects: Vec<OfficialObject>,
    /// Where ranges are measured from, in that frame, in metres.
    pub origin_m: [f64; 3],
}

/// What results that we write call a vehicle which only protocols count that rank boxes; evaluators of others do not read it.
pub const UNLIKELY: &str = "unlikely";

/// An object, labelled or found, in the frame of the files.
#[derive(Debug, Clone, PartialEq)]
pub struct OfficialObject {
    /// What the files call its class.
    pub name: String,
    /// Its centre.
    pub center_m: [f64; 3],
    /// Its sides.
    pub length_width_height_m: [f64; 3],
    /// Its heading on the ground plan.
    pub yaw_rad: f64,
    /// How it moves over the ground plan; `None` where nobody says.
    pub velocity_m_per_s: Option<[f64; 2]>,
    /// What it is doing; `None` where nobody says.
    pub attribute: Option<String>,
    /// Number of points in it, as the files have it; `None` where they do not, and of what was found.
    pub n_points: Option<u64>,
    /// How sure the detector is of it; `None` of labels.
    pub score: Option<f64>,
}

impl OfficialObject {
    /// An object at `frame_from_box` of which no more is known.
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

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};

    #[test]
    fn a_heading_is_that_on_the_ground_plan() {
        let turn = UnitQuaternion::from_euler_angles(0.2, 0.1, 0.5);
        let tilted = Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), turn);
        let it = OfficialObject::new("car", &tilted, [4.0, 2.0, 1.5]);
        assert_eq!(it.center_m, [1.0, 2.0, 3.0]);
        assert!((it.yaw_rad - 0.5).abs() < 1e-12, "{it:?}");
    }
}
