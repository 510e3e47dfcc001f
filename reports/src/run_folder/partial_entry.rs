//! Entries of a manifest that only a result of `scanbench partial` has.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// How partly seen objects were classified.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PartialEntry {
    /// The objects, in the order of the tables.
    pub sets: Vec<PartialSet>,
    /// Methods whose results are those of another program, with the SHA-256 of their files.
    pub peers: BTreeMap<String, String>,
    /// What else was asked for; `None` of results of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings: Option<PartialSettings>,
}

/// What was asked for beside objects and models.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PartialSettings {
    /// Whether objects that are none of the four are judged, too.
    pub others: bool,
    /// Whether objects are shown as a drive does, and not step by step.
    pub drives: bool,
    /// Whether the method is compared with itself without each part, instead of with rivals.
    pub ablation: bool,
    /// What methods learned from, in turn.
    pub trained_on: Vec<String>,
}

/// Objects that were judged, and what methods have learned from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PartialSet {
    /// The objects.
    pub judged: ObjectSetEntry,
    /// Objects that were learned from; none if a model was taken.
    pub learned_from: Option<ObjectSetEntry>,
    /// Whether both are the same recorded objects: half of them learned from, and the others judged.
    pub halves: bool,
    /// The model that was taken.
    pub model: Option<ModelEntry>,
}

/// A set of objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ObjectSetEntry {
    /// The name used in tables.
    pub id: String,
    /// Whether a simulator made them.
    pub simulated: bool,
    /// What the simulator was asked for.
    pub simulation: Option<serde_json::Value>,
    /// How many there are of each class.
    pub objects: BTreeMap<String, usize>,
}

/// A model that had learned before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ModelEntry {
    /// `shipped`, or the file that was named.
    pub name: String,
    /// The command that made it.
    pub made_by: String,
    /// What it was made of.
    pub data: Vec<String>,
}

impl ObjectSetEntry {
    fn named(&self) -> String {
        let simulated = if self.simulated { " (simulated)" } else { "" };
        format!("{}{simulated}", self.id)
    }
}

impl PartialEntry {
    /// The judged objects, with the objects or the model that methods learned from, in words.
    pub fn title(&self) -> String {
        let of_set = |it: &PartialSet| {
            let judged = it.judged.named();
            let half = if it.halves { ", the other half of it" } else { "" };
            match (&it.learned_from, &it.model) {
                (Some(learned_from), _) => format!("{judged}, learned from {}{half}", learned_from.named()),
                (None, Some(model)) if model.name == SHIPPED => {
                    format!("{judged}, classified by the shipped model")
                }
                (None, Some(model)) => format!("{judged}, classified by the model {}", model.name),
                (None, None) => judged,
            }
        };
        format!("Partial clouds: {}.", self.sets.iter().map(of_set).collect::<Vec<_>>().join("; "))
    }
}

/// The name of the model that comes with the program.
pub const SHIPPED: &str = "shipped";

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The entry of the rows that tests have, classified by the shipped model.
    pub(crate) fn entry() -> PartialEntry {
        let judged = ObjectSetEntry {
            id: "street".to_owned(),
            simulated: true,
            simulation: None,
            objects: [("tree".to_owned(), 2), ("pole".to_owned(), 1)].into_iter().collect(),
        };
        let model = ModelEntry { name: SHIPPED.to_owned(), made_by: "train".to_owned(), data: Vec::new() };
        let set = PartialSet { judged, learned_from: None, halves: false, model: Some(model) };
        PartialEntry { sets: vec![set], ..PartialEntry::default() }
    }

    #[test]
    fn titles_say_what_is_simulated() {
        let mut entry = entry();
        assert_eq!(entry.title(), "Partial clouds: street (simulated), classified by the shipped model.");
        let set = &mut entry.sets[0];
        set.learned_from = Some(ObjectSetEntry { simulated: false, ..set.judged.clone() });
        (set.halves, set.model) = (true, None);
        let title = "Partial clouds: street (simulated), learned from street, the other half of it.";
        assert_eq!(entry.title(), title);
    }
}
