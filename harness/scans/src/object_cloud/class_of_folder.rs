//! Names of folders of objects.

use reports::vocabulary::partial_class::PartialClass;

use reports::vocabulary::taxonomy::{class_named, plain_name};

/// Names besides those of annotations, in the singular.
const OTHER_NAMES: [&str; 12] = [
    "none",
    "wall",
    "building",
    "house",
    "bush",
    "shrub",
    "bin",
    "bench",
    "barrier",
    "railing",
    "power-line",
    "furniture",
];

/// The class of the objects in a folder called `name`, in any spelling, in the singular or the plural; `None` if the name is
/// unknown.
///
/// It may be a class of ours, or any name of annotations in any data set: objects that are neither tree, car, pole nor
/// pedestrian are [`PartialClass::Other`].
pub fn class_of_folder(name: &str) -> Option<PartialClass> {
    let plain = plain_name(name);
    let singulars = [Some(plain.as_str()), plain.strip_suffix('s'), plain.strip_suffix("es")];
    singulars.into_iter().flatten().find_map(class_of_singular)
}

fn class_of_singular(name: &str) -> Option<PartialClass> {
    if let Some(class) = PartialClass::from_name(name) {
        return Some(class);
    }
    match name {
        "people" | "walker" => Some(PartialClass::Pedestrian),
        "post" | "mast" | "lamppost" | "lamp" | "lantern" | "utility-pole" | "bollard" => {
            Some(PartialClass::Pole)
        }
        name if OTHER_NAMES.contains(&name) => Some(PartialClass::Other),
        name => class_named(name).map(PartialClass::of_annotation),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_known_in_many_spellings() {
        use PartialClass as Class;
        for (name, expected) in [
            ("car", Some(Class::Car)),
            ("Cars", Some(Class::Car)),
            ("vehicle", Some(Class::Car)),
            ("VAN", Some(Class::Car)),
            ("trunk", Some(Class::Tree)),
            ("Trees", Some(Class::Tree)),
            ("person", Some(Class::Pedestrian)),
            ("people", Some(Class::Pedestrian)),
            ("Traffic Sign", Some(Class::Pole)),
            ("lamp_posts", Some(Class::Pole)),
            ("fence", Some(Class::Other)),
            ("hedges", Some(Class::Other)),
            ("bushes", Some(Class::Other)),
            ("Buildings", Some(Class::Other)),
            ("trucks", Some(Class::Other)),
            ("misc", Some(Class::Other)),
            ("other", Some(Class::Other)),
            ("velodyne", None),
            ("training", None),
            ("s", None),
            ("", None),
        ] {
            assert_eq!(class_of_folder(name), expected, "{name}");
        }
        for class in Class::ALL {
            assert_eq!(class_of_folder(class.name()), Some(class));
        }
    }
}
