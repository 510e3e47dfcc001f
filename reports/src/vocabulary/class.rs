//! Classes of objects: of annotations, and of detections.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::vocabulary::class_traits::{ClassGroup, ClassTraits, shipped_classes};
use crate::vocabulary::named::named;

/// What an annotated object is: a class of ours, or one that the user defines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AnnotationClass {
    /// Passenger car.
    Car,
    /// Van or large people carrier.
    Van,
    /// Truck.
    Truck,
    /// Bus.
    Bus,
    /// Person on foot.
    Pedestrian,
    /// Person sitting.
    SittingPerson,
    /// Bicycle or motorcycle with its rider.
    Cyclist,
    /// Bicycle or motorcycle without a rider.
    ParkedCycle,
    /// Tram or train.
    Tram,
    /// Trailer.
    Trailer,
    /// Excavator, crane and the like.
    ConstructionVehicle,
    /// Animal.
    Animal,
    /// Pole, lamp post, traffic light or sign.
    Pole,
    /// Trunk and crown of a tree.
    Tree,
    /// Hedge or bush.
    Hedge,
    /// Fence or railing.
    Fence,
    /// Mail box, bin, bench, advertising column and the like.
    StreetFurniture,
    /// Labelled, but none of the above.
    Misc,
    /// A class of the user.
    Own(OwnClass),
}

/// Classes of ours with their names.
const OURS: [(AnnotationClass, &str); 18] = [
    (AnnotationClass::Car, "car"),
    (AnnotationClass::Van, "van"),
    (AnnotationClass::Truck, "truck"),
    (AnnotationClass::Bus, "bus"),
    (AnnotationClass::Pedestrian, "pedestrian"),
    (AnnotationClass::SittingPerson, "sitting-person"),
    (AnnotationClass::Cyclist, "cyclist"),
    (AnnotationClass::ParkedCycle, "parked-cycle"),
    (AnnotationClass::Tram, "tram"),
    (AnnotationClass::Trailer, "trailer"),
    (AnnotationClass::ConstructionVehicle, "construction-vehicle"),
    (AnnotationClass::Animal, "animal"),
    (AnnotationClass::Pole, "pole"),
    (AnnotationClass::Tree, "tree"),
    (AnnotationClass::Hedge, "hedge"),
    (AnnotationClass::Fence, "fence"),
    (AnnotationClass::StreetFurniture, "street-furniture"),
    (AnnotationClass::Misc, "misc"),
];

/// Longest name of a class of the user, in characters.
const LONGEST_NAME: usize = 40;

impl AnnotationClass {
    /// Those of ours, in the order in which tables list them.
    pub const ALL: [Self; OURS.len()] = {
        let mut all = [Self::Misc; OURS.len()];
        let mut index = 0;
        while index < OURS.len() {
            all[index] = OURS[index].0;
            index += 1;
        }
        all
    };

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own(own) => own.0,
            ours => OURS.iter().find(|(it, _)| *it == ours).map_or("misc", |(_, name)| name),
        }
    }

    /// The class of this name: of ours, or defined by the user; `None` if there is none.
    pub fn from_name(name: &str) -> Option<Self> {
        let ours = OURS.iter().find(|(_, it)| *it == name).map(|(class, _)| *class);
        ours.or_else(|| OwnClass::named(name).filter(|it| it.definition().is_some()).map(Self::Own))
    }

    /// The class of this name that is known, or that a file of a run has had.
    pub fn met(name: &str) -> Option<Self> {
        Self::from_name(name).or_else(|| OwnClass::named(name).map(Self::Own))
    }

    /// The class of this name in a file of ours: one that is unknown was defined by the user who made the file.
    ///
    /// # Errors
    ///
    /// A sentence if it is no name of a class.
    pub fn written(name: &str) -> Result<Self, String> {
        if let Some(known) = Self::from_name(name) {
            return Ok(known);
        }
        check_name(name)?;
        Ok(Self::Own(OwnClass::kept(name)))
    }

    /// Defines a class of the user.
    ///
    /// # Errors
    ///
    /// A sentence if `name` is no name of a class, that of one of ours, or of a class of which something else is known.
    pub fn define(name: &str, traits: ClassTraits) -> Result<Self, String> {
        check_name(name)?;
        if OURS.iter().any(|(_, it)| *it == name) {
            return Err(format!("{name:?} is a class already"));
        }
        if traits.whole_group && traits.group.is_none() {
            return Err("whole_group needs a group".to_owned());
        }
        let own = OwnClass::kept(name);
        match own.definition() {
            Some(known) if *known != traits => Err(format!("{name:?} is a class already, another one")),
            Some(_) => Ok(Self::Own(own)),
            None => {
                own_classes().insert(own.0, Some(Box::leak(Box::new(traits))));
                Ok(Self::Own(own))
            }
        }
    }

    /// What is known of it: by `classes.toml`, or by the user.
    pub fn traits(self) -> &'static ClassTraits {
        static UNKNOWN: LazyLock<ClassTraits> = LazyLock::new(ClassTraits::default);
        let known = match self {
            Self::Own(own) => own.definition(),
            ours => shipped_classes().get(ours.name()),
        };
        known.unwrap_or(&UNKNOWN)
    }

    /// Whether something of the class `other` is one of it: the same class or, of a class that stands for its whole group, one
    /// of that.
    pub fn includes(self, other: Self) -> bool {
        self == other || self.traits().whole_group && self.group().is_some() && self.group() == other.group()
    }

    /// The classes of the user that stand for their whole group.
    pub fn of_whole_groups() -> Vec<Self> {
        let classes = own_classes();
        let all = classes.iter().filter(|(_, traits)| traits.is_some_and(|it| it.whole_group));
        all.map(|(name, _)| Self::Own(OwnClass(name))).collect()
    }

    /// The group that it belongs to, if it does.
    pub fn group(self) -> Option<ClassGroup> {
        self.traits().group
    }
}

fn check_name(name: &str) -> Result<(), String> {
    let is_plain = |it: char| it.is_ascii_lowercase() || it.is_ascii_digit() || it == '-';
    let is_reserved = DetectionClass::from_word(name).is_some() || ["objects", "vehicles"].contains(&name);
    if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(is_plain) || is_reserved {
        return Err(format!(
            "{name:?} is no name of a class: use a-z, 0-9 and -, at most {LONGEST_NAME} characters"
        ));
    }
    Ok(())
}

impl Serialize for AnnotationClass {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for AnnotationClass {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::written(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl fmt::Display for AnnotationClass {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(feature = "schemas")]
impl schemars::JsonSchema for AnnotationClass {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "AnnotationClass".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({"type": "string", "pattern": "^[a-z0-9-]+$"})
    }
}

/// A class that the user defines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OwnClass(&'static str);

/// The classes of users, by name, with what is known of them: `None` as long as that is only a name from a file of a run.
type OwnClasses = BTreeMap<&'static str, Option<&'static ClassTraits>>;

static OWN_CLASSES: Mutex<OwnClasses> = Mutex::new(BTreeMap::new());

fn own_classes() -> MutexGuard<'static, OwnClasses> {
    OWN_CLASSES.lock().unwrap_or_else(PoisonError::into_inner)
}

impl OwnClass {
    fn named(name: &str) -> Option<Self> {
        own_classes().get_key_value(name).map(|(name, _)| Self(name))
    }

    fn kept(name: &str) -> Self {
        let mut classes = own_classes();
        if let Some((known, _)) = classes.get_key_value(name) {
            return Self(known);
        }
        let name: &'static str = Box::leak(name.to_owned().into_boxed_str());
        classes.insert(name, None);
        Self(name)
    }

    fn definition(self) -> Option<&'static ClassTraits> {
        own_classes().get(self.0).copied().flatten()
    }
}

/// What a detector takes an object for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DetectionClass {
    /// A free-standing thing on the street that is not known to be a vehicle.
    Object,
    /// A car, van, truck or bus.
    Vehicle,
    /// This class, which its detector gives.
    Given(AnnotationClass),
}

impl DetectionClass {
    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Vehicle => "vehicle",
            Self::Given(class) => class.name(),
        }
    }

    /// The class that its detector gives.
    pub fn given(self) -> Option<AnnotationClass> {
        match self {
            Self::Given(class) => Some(class),
            Self::Object | Self::Vehicle => None,
        }
    }

    fn from_word(name: &str) -> Option<Self> {
        [Self::Object, Self::Vehicle].into_iter().find(|it| it.name() == name)
    }
}

impl Serialize for DetectionClass {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for DetectionClass {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        match Self::from_word(&name) {
            Some(known) => Ok(known),
            None => AnnotationClass::written(&name).map(Self::Given).map_err(D::Error::custom),
        }
    }
}

impl fmt::Display for DetectionClass {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

named! {
    /// How much of an object is hidden by others.
    pub enum Occlusion {
        /// Less than a tenth.
        None = "none",
        /// Up to a half.
        Partly = "partly",
        /// More than a half.
        Largely = "largely",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_of_the_user_is_read_back_and_defined_once() {
        let read: AnnotationClass = serde_json::from_str("\"pallet-1\"").unwrap();
        assert_eq!((read.name(), read.group()), ("pallet-1", None));
        assert_eq!(AnnotationClass::from_name("pallet-1"), None, "a file defines nothing");
        let vehicle = ClassTraits { group: Some(ClassGroup::Vehicle), ..ClassTraits::default() };
        let defined = AnnotationClass::define("pallet-1", vehicle.clone()).unwrap();
        assert_eq!((defined, defined.group()), (read, Some(ClassGroup::Vehicle)));
        assert_eq!(AnnotationClass::from_name("pallet-1"), Some(defined));
        let anything = ClassTraits::default();
        assert_eq!(AnnotationClass::define("pallet-1", vehicle), Ok(defined));
        assert!(AnnotationClass::define("pallet-1", anything.clone()).unwrap_err().contains("another one"));
        assert!(AnnotationClass::define("car", anything.clone()).unwrap_err().contains("already"));
        for name in ["", "Fork Lift", "object", "vehicle"] {
            assert!(
                AnnotationClass::define(name, anything.clone()).unwrap_err().contains("no name of a class"),
                "{name}"
            );
            assert!(AnnotationClass::written(name).is_err(), "{name}");
        }
    }

    #[test]
    fn a_class_may_stand_for_its_whole_group() {
        let of_group = |group, whole_group| ClassTraits { group, whole_group, ..ClassTraits::default() };
        let cycle = AnnotationClass::define("any-cycle", of_group(Some(ClassGroup::Cycle), true)).unwrap();
        assert!(cycle.includes(cycle) && cycle.includes(AnnotationClass::Cyclist));
        assert!(!cycle.includes(AnnotationClass::Car) && !AnnotationClass::Cyclist.includes(cycle));
        assert!(AnnotationClass::of_whole_groups().contains(&cycle));
        let refused = AnnotationClass::define("anything", of_group(None, true)).unwrap_err();
        assert_eq!(refused, "whole_group needs a group");
    }

    #[test]
    fn a_detection_has_a_class_of_its_detector_or_a_kind() {
        for (written, class) in [
            ("\"object\"", DetectionClass::Object),
            ("\"vehicle\"", DetectionClass::Vehicle),
            ("\"truck\"", DetectionClass::Given(AnnotationClass::Truck)),
        ] {
            assert_eq!(serde_json::from_str::<DetectionClass>(written).unwrap(), class);
            assert_eq!(serde_json::to_string(&class).unwrap(), written);
        }
    }
}
