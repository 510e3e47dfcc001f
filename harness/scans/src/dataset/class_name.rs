//! What annotation tools, recordings and other data sets call the classes.

use crate::annotation::AnnotationClass;

/// The class that `name` stands for, in whatever spelling: ours, KITTI's, that of nuScenes or Argoverse 2, or a plain word.
///
/// A name that stands for nothing known is [`AnnotationClass::Misc`]: labelled, and neither right nor wrong among vehicles.
pub fn class_named(name: &str) -> AnnotationClass {
    use AnnotationClass as Class;
    let name: String =
        name.chars().map(|it| if it.is_alphanumeric() { it.to_ascii_lowercase() } else { '-' }).collect();
    if let Some(class) = Class::ALL.into_iter().find(|class| class.name() == name) {
        return class;
    }
    match name.as_str() {
        "vehicle-car" | "regular-vehicle" | "automobile" | "suv" | "vehicle-emergency-police" | "vehicle" => {
            Class::Car
        }
        "vehicle-emergency-ambulance" => Class::Van,
        "large-vehicle" | "box-truck" | "vehicle-truck" | "truck-cab" | "lorry" => Class::Truck,
        "school-bus" | "articulated-bus" | "vehicle-bus-rigid" | "vehicle-bus-bendy" => Class::Bus,
        "vehicular-trailer" | "vehicle-trailer" | "message-board-trailer" | "traffic-light-trailer" => {
            Class::Trailer
        }
        "railed-vehicle" | "train" => Class::Tram,
        "human-pedestrian-adult"
        | "human-pedestrian-child"
        | "human-pedestrian-construction-worker"
        | "human-pedestrian-police-officer"
        | "official-signaler"
        | "person"
        | "human" => Class::Pedestrian,
        "person-sitting"
        | "human-pedestrian-personal-mobility"
        | "human-pedestrian-stroller"
        | "human-pedestrian-wheelchair"
        | "wheelchair"
        | "stroller" => Class::SittingPerson,
        "bicyclist" | "motorcyclist" | "wheeled-rider" | "rider" => Class::Cyclist,
        "bicycle"
        | "motorcycle"
        | "motorbike"
        | "bike"
        | "wheeled-device"
        | "vehicle-bicycle"
        | "vehicle-motorcycle"
        | "static-object-bicycle-rack" => Class::ParkedCycle,
        "sign" | "stop-sign" | "traffic-sign" | "traffic-light" | "lamp-post" => Class::Pole,
        "trunk" => Class::Tree,
        "bollard"
        | "construction-cone"
        | "construction-barrel"
        | "movable-object-barrier"
        | "movable-object-trafficcone"
        | "movable-object-pushable-pullable"
        | "movable-object-debris"
        | "mobile-pedestrian-sign"
        | "mobile-pedestrian-crossing-sign"
        | "streetfurniture" => Class::StreetFurniture,
        _ => Class::Misc,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_known_in_many_spellings() {
        for (name, expected) in [
            ("sitting_person", AnnotationClass::SittingPerson),
            ("Car", AnnotationClass::Car),
            ("REGULAR_VEHICLE", AnnotationClass::Car),
            ("vehicle.bus.rigid", AnnotationClass::Bus),
            ("human.pedestrian.adult", AnnotationClass::Pedestrian),
            ("WHEELED_RIDER", AnnotationClass::Cyclist),
            ("Dog", AnnotationClass::Misc),
            ("", AnnotationClass::Misc),
        ] {
            assert_eq!(class_named(name), expected, "{name}");
        }
        for class in AnnotationClass::ALL {
            assert_eq!(class_named(class.name()), class);
        }
    }
}
