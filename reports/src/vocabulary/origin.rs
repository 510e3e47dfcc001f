//! Whether scans were recorded or simulated.

use serde::{Deserialize, Serialize};

/// Where scans come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// All from a sensor.
    Recorded,
    /// All from a simulator.
    Simulated,
    /// Some from a sensor, some from a simulator.
    #[serde(rename = "partly simulated")]
    PartlySimulated,
}

impl Origin {
    /// The name used in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Recorded => "recorded",
            Self::Simulated => "simulated",
            Self::PartlySimulated => "partly simulated",
        }
    }

    /// Where the scans of two collections together come from.
    pub fn with(self, other: Self) -> Self {
        if self == other { self } else { Self::PartlySimulated }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary::tests::check_names;

    #[test]
    fn origins_are_read_by_the_names_they_are_written_with() {
        check_names(&[Origin::Recorded, Origin::Simulated, Origin::PartlySimulated], Origin::name);
    }
}
