//! How files write the objects that a data set labels: `"every-object"` or a list of classes.

use std::collections::BTreeSet;
use std::fmt;

use reports::vocabulary::class::AnnotationClass;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error as _, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::AnnotatedClasses;
use super::class_table::all_classes;

/// The word for all objects.
const EVERY_OBJECT: &str = "every-object";

impl Serialize for AnnotatedClasses {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::EveryObject => serializer.serialize_str(EVERY_OBJECT),
            Self::Only(classes) => classes.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for AnnotatedClasses {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnnotatedClassesVisitor)
    }
}

/// A class of ours or of the user, by its name.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct KnownClass(AnnotationClass);

impl<'de> Deserialize<'de> for KnownClass {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let known = AnnotationClass::from_name(&name).map(Self);
        known.ok_or_else(|| {
            D::Error::custom(format!("{name:?} is not a class; classes are {}", all_classes()))
        })
    }
}

struct AnnotatedClassesVisitor;

impl<'de> Visitor<'de> for AnnotatedClassesVisitor {
    type Value = AnnotatedClasses;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("\"every-object\" or a list of classes")
    }

    fn visit_str<E: serde::de::Error>(self, keyword: &str) -> Result<AnnotatedClasses, E> {
        match keyword {
            EVERY_OBJECT => Ok(AnnotatedClasses::EveryObject),
            _ => Err(E::invalid_value(Unexpected::Str(keyword), &self)),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<AnnotatedClasses, A::Error> {
        let classes: BTreeSet<KnownClass> = Deserialize::deserialize(SeqAccessDeserializer::new(list))?;
        if classes.is_empty() {
            return Err(A::Error::invalid_length(0, &"at least one class"));
        }
        Ok(AnnotatedClasses::Only(classes.into_iter().map(|it| it.0).collect()))
    }
}
