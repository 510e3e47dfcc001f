//! The tasks of detectors.

use std::fmt;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::vocabulary::class::AnnotationClass;

/// What is asked of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Task {
    /// Find every free-standing object, whatever it is. Paper: HG section 5.
    Objects,
    /// Find the vehicles among everything else. Paper: VM section 6.
    Vehicles,
    /// Find the objects of a class, and say that they are of this class.
    Class(AnnotationClass),
}

impl Task {
    /// The tasks of every detector. Those of classes are for detectors that give classes.
    pub const ALL: [Self; 2] = [Self::Objects, Self::Vehicles];

    /// The name used in files and on screens: that of a class is the name of the class.
    pub fn name(self) -> &'static str {
        match self {
            Self::Objects => "objects",
            Self::Vehicles => "vehicles",
            Self::Class(class) => class.name(),
        }
    }

    /// The task of this name: one of [`Self::ALL`], or that of a known class.
    pub fn from_name(name: &str) -> Option<Self> {
        let of_all = Self::ALL.into_iter().find(|it| it.name() == name);
        of_all.or_else(|| AnnotationClass::from_name(name).map(Self::Class))
    }

    /// The class that it asks for, if it asks for one.
    pub fn class(self) -> Option<AnnotationClass> {
        match self {
            Self::Class(class) => Some(class),
            Self::Objects | Self::Vehicles => None,
        }
    }

    /// Whether its detections are ranked by score: a score says how sure a detector is of a vehicle or of the class that it
    /// gives, whatever is asked.
    pub fn ranks_detections(self) -> bool {
        self != Self::Objects
    }
}

impl Serialize for Task {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Task {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        match Self::ALL.into_iter().find(|it| it.name() == name) {
            Some(known) => Ok(known),
            None => AnnotationClass::written(&name).map(Self::Class).map_err(D::Error::custom),
        }
    }
}

impl fmt::Display for Task {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(feature = "schemas")]
impl schemars::JsonSchema for Task {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Task".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({"type": "string", "pattern": "^[a-z0-9-]+$"})
    }
}
