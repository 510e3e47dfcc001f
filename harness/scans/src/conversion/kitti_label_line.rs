//! Annotations as lines of KITTI's label files, and the calibration they are written under.

use std::f64::consts::{FRAC_PI_2, PI};

use detector::OrientedBox;
use reports::vocabulary::class::{AnnotationClass, Occlusion};

use crate::annotation::Annotation;

/// A camera at the sensor that looks along x, so that boxes change axes and nothing else.
pub const CALIBRATION: &str = "\
P2: 700 0 621 0 0 700 187 0 0 0 1 0
R0_rect: 1 0 0 0 1 0 0 0 1
Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0
";

/// The line of the object benchmark for `annotation`, whose box is `bounding_box`, without the number of the scan and the
/// track that the tracking benchmark has before it. Unknown values are written as the benchmarks do.
///
/// Coordinates are written in full, so that the box that is read is the one that was written.
pub fn label_line(annotation: &Annotation, bounding_box: &OrientedBox, truncation: &str) -> String {
    let [x, y, z] = bounding_box.center_m.map(f64::from);
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m.map(f64::from);
    let occlusion = match annotation.occlusion {
        Some(Occlusion::None) => 0,
        Some(Occlusion::Partly) => 1,
        Some(Occlusion::Largely) => 2,
        None => 3,
    };
    // The camera's x is our -y, its y our -z, its z our x.
    let (right_m, down_m, forward_m) = (-y, -(z - height_m / 2.0), x);
    let rotation_y_rad = wrapped(-f64::from(bounding_box.yaw_rad) - FRAC_PI_2);
    format!(
        "{} {truncation} {occlusion} -10 -1 -1 -1 -1 {height_m} {width_m} {length_m} {right_m} {down_m} {forward_m} \
         {rotation_y_rad}",
        class_word(annotation.class)
    )
}

/// The angle in -π to π.
pub fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(2.0 * PI) - PI
}

/// KITTI's word for `class`, or its own name, which the evaluators of KITTI pass over.
pub(super) fn class_word(class: AnnotationClass) -> &'static str {
    class.traits().written.kitti.as_deref().unwrap_or(class.name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::class_table::{ClassReader, ClassRules};
    use crate::dataset::kitti::box_in_velodyne::box_in_velodyne;
    use crate::dataset::kitti::calibration::parse_calibration;
    use crate::dataset::kitti::label::{KITTI_VOCABULARY, KittiLabel, parse_object_labels};
    use proptest::prelude::*;
    use std::path::Path;

    fn annotation(class: AnnotationClass) -> Annotation {
        Annotation { occlusion: Some(Occlusion::Largely), ..Annotation::of(class) }
    }

    fn read_back(line: &str) -> (AnnotationClass, Option<Occlusion>, OrientedBox) {
        let rules = ClassRules::default();
        let mut classes = ClassReader::new(&rules, KITTI_VOCABULARY);
        let labels = parse_object_labels(Path::new("l.txt"), line, &mut classes).unwrap();
        let [KittiLabel::Object(object)] = &labels[..] else { panic!("{labels:?}") };
        let calibration = parse_calibration(Path::new("c.txt"), CALIBRATION).unwrap();
        let bounding_box = box_in_velodyne(&object.camera_box, &calibration.velodyne_from_camera);
        (object.class, object.occlusion, bounding_box)
    }

    #[test]
    fn every_class_comes_back() {
        let unit = OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        for class in AnnotationClass::ALL {
            let line = label_line(&annotation(class), &unit, "-1");
            let (read_class, occlusion, read) = read_back(&line);
            assert_eq!(
                (read_class, occlusion, read.center_m),
                (class, Some(Occlusion::Largely), [0.0; 3]),
                "{line}"
            );
        }
    }

    proptest! {
        #[test]
        fn any_box_comes_back(
            center_m in prop::array::uniform3(-200.0_f32..200.0),
            length_width_height_m in prop::array::uniform3(0.01_f32..30.0),
            yaw_rad in -3.1_f32..3.1,
        ) {
            let written = OrientedBox { center_m, length_width_height_m, yaw_rad };
            let (_, _, read) = read_back(&label_line(&annotation(AnnotationClass::Car), &written, "-1"));
            prop_assert_eq!(read.length_width_height_m, written.length_width_height_m);
            for axis in 0..3 {
                prop_assert!((read.center_m[axis] - written.center_m[axis]).abs() < 1e-5);
            }
            prop_assert!((read.yaw_rad - written.yaw_rad).abs() < 1e-6);
        }
    }
}
