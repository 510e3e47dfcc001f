//! Whether scans were recorded or simulated.

use crate::vocabulary::named::named;

named! {
    /// Where scans come from.
    pub enum Origin {
        /// All from a sensor.
        Recorded = "recorded",
        /// All from a simulator.
        Simulated = "simulated",
        /// Some from a sensor, some from a simulator.
        PartlySimulated = "partly simulated",
    }
}

impl Origin {
    /// Where the scans of two collections together come from.
    pub fn with(self, other: Self) -> Self {
        if self == other { self } else { Self::PartlySimulated }
    }

    /// Text after a name: empty where scans were recorded.
    pub fn in_brackets(self) -> String {
        match self {
            Self::Recorded => String::new(),
            Self::Simulated | Self::PartlySimulated => format!(" ({})", self.name()),
        }
    }
}
