//! What detectors are asked to do.

use serde::{Deserialize, Serialize};

/// What is asked of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// Find every free-standing object, whatever it is. Paper: HG section 5.
    Objects,
    /// Find the vehicles among everything else. Paper: VM section 6.
    Vehicles,
}

impl Task {
    /// All tasks, in the order in which tables list them.
    pub const ALL: [Self; 2] = [Self::Objects, Self::Vehicles];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Objects => "objects",
            Self::Vehicles => "vehicles",
        }
    }

    /// The task of this name; `None` if there is none.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }

    /// Whether its detections are ranked by score: a score says how sure a detector is of a vehicle, whatever is asked.
    pub fn ranks_detections(self) -> bool {
        self == Self::Vehicles
    }
}

impl std::fmt::Display for Task {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn tasks_are_read_by_the_names_they_are_written_with() {
        check_names(&Task::ALL, Task::name);
        assert_eq!(Task::from_name("vehicles"), Some(Task::Vehicles));
        assert_eq!(Task::from_name("Vehicles"), None);
    }
}
