//! Whether scans were recorded or simulated.

/// Where scans come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// All from a sensor.
    Recorded,
    /// All from a simulator.
    Simulated,
    /// Some from a sensor, some from a simulator.
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
