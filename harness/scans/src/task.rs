//! What detectors are asked to do.

/// What is asked of a detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
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
}
