//! Names of classes in annotation tools, recordings and other data sets.

use reports::vocabulary::class::AnnotationClass;

/// The class that `name` stands for, in any spelling: ours, KITTI's, that of nuScenes or Argoverse 2, or a plain word;
/// `None` if it is unknown.
pub fn class_named(name: &str) -> Option<AnnotationClass> {
    use AnnotationClass as Class;
    let name = plain_name(name);
    if let Some(class) = Class::from_name(&name) {
        return Some(class);
    }
    Some(match name.as_str() {
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
        | "sittingperson"
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
        | "parkedcycle"
        | "wheeled-device"
        | "vehicle-bicycle"
        | "vehicle-motorcycle"
        | "static-object-bicycle-rack" => Class::ParkedCycle,
        "sign" | "stop-sign" | "traffic-sign" | "traffic-light" | "lamp-post" => Class::Pole,
        "trunk" => Class::Tree,
        "bollard"
        | "traffic-cone"
        | "barrier"
        | "construction-cone"
        | "construction-barrel"
        | "movable-object-barrier"
        | "movable-object-trafficcone"
        | "movable-object-pushable-pullable"
        | "movable-object-debris"
        | "mobile-pedestrian-sign"
        | "mobile-pedestrian-crossing-sign"
        | "streetfurniture" => Class::StreetFurniture,
        // Classes that the makers of data sets label and we do not have.
        "animal" | "dog" | "vehicle-construction" | "construction-vehicle" => Class::Misc,
        _ => return None,
    })
}

/// Words in names, in the spelling of [`plain_name`], with the class that they make likely.
const CLASS_WORDS: &[(&str, AnnotationClass)] = &[
    ("trailer", AnnotationClass::Trailer),
    ("tram", AnnotationClass::Tram),
    ("rail", AnnotationClass::Tram),
    ("bus", AnnotationClass::Bus),
    ("coach", AnnotationClass::Bus),
    ("van", AnnotationClass::Van),
    ("minivan", AnnotationClass::Van),
    ("ambulance", AnnotationClass::Van),
    ("truck", AnnotationClass::Truck),
    ("hgv", AnnotationClass::Truck),
    ("cyclist", AnnotationClass::Cyclist),
    ("rider", AnnotationClass::Cyclist),
    ("biker", AnnotationClass::Cyclist),
    ("scooter", AnnotationClass::ParkedCycle),
    ("moped", AnnotationClass::ParkedCycle),
    ("cycle", AnnotationClass::ParkedCycle),
    ("twowheeler", AnnotationClass::ParkedCycle),
    ("vru", AnnotationClass::Pedestrian),
    ("people", AnnotationClass::Pedestrian),
    ("man", AnnotationClass::Pedestrian),
    ("woman", AnnotationClass::Pedestrian),
    ("child", AnnotationClass::Pedestrian),
    ("adult", AnnotationClass::Pedestrian),
    ("worker", AnnotationClass::Pedestrian),
    ("walker", AnnotationClass::Pedestrian),
    ("post", AnnotationClass::Pole),
    ("lamp", AnnotationClass::Pole),
    ("light", AnnotationClass::Pole),
    ("bush", AnnotationClass::Hedge),
    ("vegetation", AnnotationClass::Hedge),
    ("railing", AnnotationClass::Fence),
    ("guardrail", AnnotationClass::Fence),
    ("cone", AnnotationClass::StreetFurniture),
    ("barrier", AnnotationClass::StreetFurniture),
    ("bench", AnnotationClass::StreetFurniture),
    ("bin", AnnotationClass::StreetFurniture),
    ("cars", AnnotationClass::Car),
    ("taxi", AnnotationClass::Car),
    ("sedan", AnnotationClass::Car),
    ("pickup", AnnotationClass::Car),
    ("auto", AnnotationClass::Car),
    ("vehicles", AnnotationClass::Car),
];

/// The class that the unknown `name` most likely means, by the words in it; *misc* if no word has a class.
pub fn likeliest_class(name: &str) -> AnnotationClass {
    let spaced: String = name
        .chars()
        .scan(false, |was_lower, it| {
            let begins = *was_lower && it.is_uppercase();
            *was_lower = it.is_lowercase();
            Some(if begins { format!(" {it}") } else { it.to_string() })
        })
        .collect();
    let plain = plain_name(&spaced);
    let words: Vec<&str> =
        plain.split('-').map(|it| it.trim_end_matches(|it: char| it.is_ascii_digit())).collect();
    // *vehicle* and *object* say less than the words beside them.
    let class_of_word = |word: &&str| {
        let singular = word.strip_suffix('s').unwrap_or(word);
        let of_word = |it: &str| CLASS_WORDS.iter().find(|(word, _)| *word == it).map(|(_, class)| *class);
        [*word, singular].into_iter().find_map(|it| of_word(it).or_else(|| class_named(it)))
    };
    let is_general = |it: &&&str| matches!(**it, "vehicle" | "vehicles" | "human" | "misc");
    let special = words.iter().rev().filter(|it| !is_general(it)).find_map(class_of_word);
    let general = || words.iter().filter(is_general).find_map(class_of_word);
    special.or_else(general).unwrap_or(AnnotationClass::Misc)
}

/// `name` in one spelling: lower case, and one `-` for all that stands between letters and digits.
pub fn plain_name(name: &str) -> String {
    let words = name.split(|it: char| !it.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::vocabulary::protocol::Protocol;

    #[test]
    fn classes_are_known_in_many_spellings() {
        for (name, expected) in [
            ("sitting_person", Some(AnnotationClass::SittingPerson)),
            ("Person (sitting)", Some(AnnotationClass::SittingPerson)),
            ("Car", Some(AnnotationClass::Car)),
            ("PEDESTRIAN", Some(AnnotationClass::Pedestrian)),
            ("REGULAR_VEHICLE", Some(AnnotationClass::Car)),
            ("vehicle.bus.rigid", Some(AnnotationClass::Bus)),
            ("human.pedestrian.adult", Some(AnnotationClass::Pedestrian)),
            ("WHEELED_RIDER", Some(AnnotationClass::Cyclist)),
            ("forklift", None),
            ("", None),
        ] {
            assert_eq!(class_named(name), expected, "{name}");
        }
        for class in AnnotationClass::ALL {
            assert_eq!(class_named(class.name()), Some(class));
        }
    }

    #[test]
    fn an_unknown_name_most_likely_means_what_its_words_say() {
        for (name, expected) in [
            ("VRU", AnnotationClass::Pedestrian),
            ("vehicle.parked", AnnotationClass::Car),
            ("Parked_Cars", AnnotationClass::Car),
            ("PassengerCar", AnnotationClass::Car),
            ("car2", AnnotationClass::Car),
            ("vehicle.truck.semi", AnnotationClass::Truck),
            ("DeliveryVan", AnnotationClass::Van),
            ("human.on.scooter", AnnotationClass::ParkedCycle),
            ("motor cyclists", AnnotationClass::Cyclist),
            ("construction workers", AnnotationClass::Pedestrian),
            ("forklift", AnnotationClass::Misc),
            ("cart", AnnotationClass::Misc),
            ("", AnnotationClass::Misc),
        ] {
            assert_eq!(likeliest_class(name), expected, "{name}");
        }
    }

    /// The names that the makers of the data sets publish.
    #[test]
    fn every_official_class_is_known() {
        const NUSCENES: &str = "animal human.pedestrian.adult human.pedestrian.child human.pedestrian.construction_worker \
            human.pedestrian.personal_mobility human.pedestrian.police_officer human.pedestrian.stroller \
            human.pedestrian.wheelchair movable_object.barrier movable_object.debris \
            movable_object.pushable_pullable movable_object.trafficcone static_object.bicycle_rack \
            vehicle.bicycle vehicle.bus.bendy vehicle.bus.rigid vehicle.car vehicle.construction \
            vehicle.emergency.ambulance vehicle.emergency.police vehicle.motorcycle vehicle.trailer \
            vehicle.truck";
        const ARGOVERSE_2: &str = "ANIMAL ARTICULATED_BUS BICYCLE BICYCLIST BOLLARD BOX_TRUCK BUS CONSTRUCTION_BARREL \
            CONSTRUCTION_CONE DOG LARGE_VEHICLE MESSAGE_BOARD_TRAILER MOBILE_PEDESTRIAN_CROSSING_SIGN \
            MOBILE_PEDESTRIAN_SIGN MOTORCYCLE MOTORCYCLIST OFFICIAL_SIGNALER PEDESTRIAN RAILED_VEHICLE \
            REGULAR_VEHICLE SCHOOL_BUS SIGN STOP_SIGN STROLLER TRAFFIC_LIGHT_TRAILER TRUCK TRUCK_CAB \
            VEHICULAR_TRAILER WHEELCHAIR WHEELED_DEVICE WHEELED_RIDER";
        const KITTI: [&str; 9] = [
            "Car",
            "Van",
            "Truck",
            "Pedestrian",
            "Person_sitting",
            "Person (sitting)",
            "Cyclist",
            "Tram",
            "Misc",
        ];
        let official = NUSCENES.split(' ').chain(ARGOVERSE_2.split(' ')).chain(KITTI);
        assert_eq!(official.clone().count(), 63);
        // Those of results, which live detectors give, too.
        let of_results = [Protocol::Nuscenes, Protocol::Argoverse2].map(Protocol::ranked_classes).concat();
        let official = official.chain(of_results);
        for name in official {
            assert!(class_named(name).is_some(), "{name}");
        }
    }
}
