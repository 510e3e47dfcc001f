//! The classes that words stand for: those of makers, of users, and of people.

use std::collections::HashMap;
use std::sync::LazyLock;

use super::class::AnnotationClass;
use super::class_traits::{ClassTraits, shipped_classes};

/// The classes of ours by their words, in the spelling of [`plain_name`].
struct Words {
    by_name: HashMap<String, AnnotationClass>,
    by_hint: HashMap<String, AnnotationClass>,
}

static WORDS: LazyLock<Words> = LazyLock::new(|| {
    let by = |words: fn(&ClassTraits) -> &[String]| {
        let of_class = |class: AnnotationClass| {
            shipped_classes()
                .get(class.name())
                .into_iter()
                .flat_map(words)
                .map(move |it| (plain_name(it), class))
        };
        AnnotationClass::ALL.into_iter().flat_map(of_class).collect()
    };
    Words { by_name: by(|it| &it.names), by_hint: by(|it| &it.hints) }
});

/// The class that `name` stands for, in any spelling: a class, or a word that its table has; `None` if it is unknown.
pub fn class_named(name: &str) -> Option<AnnotationClass> {
    let name = plain_name(name);
    AnnotationClass::from_name(&name).or_else(|| WORDS.by_name.get(&name).copied())
}

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
        let of_hint = |it: &str| WORDS.by_hint.get(it).copied();
        [*word, singular].into_iter().find_map(|it| of_hint(it).or_else(|| class_named(it)))
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
    use crate::vocabulary::protocol::Protocol;

    #[test]
    fn every_word_stands_for_one_class() {
        let all = || shipped_classes().values();
        let (n_names, n_hints) =
            (all().flat_map(|it| &it.names).count(), all().flat_map(|it| &it.hints).count());
        assert_eq!((WORDS.by_name.len(), WORDS.by_hint.len()), (n_names, n_hints));
        for class in AnnotationClass::ALL {
            let written = &class.traits().written;
            let ranked = |protocol: Protocol, word: &Option<String>| {
                word.as_deref().is_none_or(|it| protocol.class_named(it).is_some())
            };
            assert!(written.kitti.as_deref().is_some_and(|it| class_named(it) == Some(class)), "{class}");
            assert!(ranked(Protocol::Nuscenes, &written.nuscenes), "{class}");
        }
    }

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
