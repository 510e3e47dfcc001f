//! What is known of each class: `classes.toml`, and what a user says of one in `scanbench.toml`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::named::named;

named! {
    /// Classes that belong together.
    pub enum ClassGroup {
        /// Cars, vans, trucks and buses.
        Vehicle = "vehicle",
        /// People on foot or sitting.
        Person = "person",
        /// Bicycles and motorcycles, with a rider or without.
        Cycle = "cycle",
    }
}

/// What is known of a class: its table in `classes.toml`, or of a class of the user in `scanbench.toml`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClassTraits {
    /// The group that it belongs to.
    pub group: Option<ClassGroup>,
    /// Whether it stands for every class of its group: detectors that do not tell these apart give it.
    pub whole_group: bool,
    /// What labels and detectors call it, in any spelling.
    pub names: Vec<String>,
    /// Words in unknown names that make it likely.
    pub hints: Vec<String>,
    /// Whether the task *objects* ignores it where it is tall; `None` if its group says so.
    pub may_be_tall: Option<bool>,
    /// Whether the task *vehicles* ignores it: it is neither a vehicle nor background.
    pub may_be_vehicle: bool,
    /// Its words in the files of others.
    pub written: WrittenWords,
}

/// Words for a class in the files of others; `None` where they have none.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WrittenWords {
    /// In labels and results of KITTI.
    pub kitti: Option<String>,
    /// In results of nuScenes.
    pub nuscenes: Option<String>,
    /// In results of Argoverse 2.
    pub argoverse2: Option<String>,
}

impl ClassTraits {
    /// Whether the task *objects* ignores it where it is tall: of what has no group, unless it says otherwise.
    pub fn may_be_tall(&self) -> bool {
        self.may_be_tall.unwrap_or(self.group.is_none())
    }
}

/// The tables of `classes.toml`, by class.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShippedClasses {
    class: BTreeMap<String, ClassTraits>,
}

/// What is known of the classes of ours, by their names.
pub fn shipped_classes() -> &'static BTreeMap<String, ClassTraits> {
    static SHIPPED: LazyLock<ShippedClasses> =
        LazyLock::new(|| toml::from_str(include_str!("classes.toml")).expect("the embedded file is tested"));
    &SHIPPED.class
}
