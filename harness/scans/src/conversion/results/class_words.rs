//! Words that the formats of others have for the classes of detections.

use detector::{DetectedClass, Detection};
use reports::vocabulary::class::{AnnotationClass, DetectionClass};
use reports::vocabulary::class_traits::WrittenWords;

use super::detection_rows::detection_class;
use crate::conversion::kitti_label_line::class_word;
use reports::vocabulary::taxonomy::plain_name;

/// KITTI's word for a detection. Its evaluators pass over words that they do not know, and over `Misc`.
pub fn kitti_word(detection: &Detection<'_>) -> &'static str {
    match (detection_class(detection), detection.class) {
        (DetectionClass::Given(class), _) => class_word(class),
        (_, DetectedClass::Vehicle) => class_word(AnnotationClass::Car),
        (_, DetectedClass::Object) => class_word(AnnotationClass::Misc),
    }
}

/// The one of `words` for a detection: that of its detector, in any spelling, or else the one of its class, which is
/// `of_class`; for a vehicle without a class that of a car. `None` if the format has none.
pub fn word_among(
    detection: &Detection<'_>,
    words: &[&'static str],
    of_class: fn(&'static WrittenWords) -> Option<&'static str>,
) -> Option<&'static str> {
    let of_class = |class: AnnotationClass| of_class(&class.traits().written);
    match (detection.given, detection_class(detection), detection.class) {
        (Some(given), DetectionClass::Given(class), _) => {
            let plain = plain_name(given.word());
            words.iter().find(|it| plain_name(it) == plain).copied().or_else(|| of_class(class))
        }
        (_, _, DetectedClass::Vehicle) => of_class(AnnotationClass::Car),
        (_, _, DetectedClass::Object) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::{GivenClass, OrientedBox};

    fn detection(kind: DetectedClass, given: Option<[&str; 2]>) -> Detection<'static> {
        let cube = OrientedBox { center_m: [9.0, 0.0, 0.0], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        let given = given.map(|[name, word]| GivenClass::new(name, word));
        Detection { given, ..Detection::new(&[], cube, kind, None) }
    }

    #[test]
    fn every_class_has_the_nearest_word() {
        use DetectedClass::{Object, Vehicle};
        let words = ["BOX_TRUCK", "TRUCK"];
        let of_class = |it: &'static WrittenWords| it.argoverse2.as_deref();
        for (kind, given, kitti, among) in [
            (Vehicle, None, "Car", Some("REGULAR_VEHICLE")),
            (Object, None, "Misc", None),
            (Vehicle, Some(["truck", "box.truck"]), "Truck", Some("BOX_TRUCK")),
            (Vehicle, Some(["truck", "lorry"]), "Truck", Some("TRUCK")),
            (Object, Some(["pedestrian", "Pedestrian"]), "Pedestrian", Some("PEDESTRIAN")),
            (Object, Some(["tree", "tree"]), "Tree", None),
        ] {
            let it = detection(kind, given);
            assert_eq!((kitti_word(&it), word_among(&it, &words, of_class)), (kitti, among), "{given:?}");
        }
    }
}
