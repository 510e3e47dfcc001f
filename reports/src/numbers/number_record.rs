//! The fields of a number in `report.json` and `protocols.json`, whatever it is of.

use serde::{Deserialize, Serialize};

use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
use crate::vocabulary::metric::Direction;

/// The fields of a number. Flattened into the record of a row, whose unknown fields are refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub(crate) struct NumberRecord {
    // Spelled out, because serde lets an absent field pass for null otherwise.
    #[serde(deserialize_with = "Option::deserialize")]
    pub(crate) value: Option<f64>,
    pub(crate) unit: String,
    #[serde(deserialize_with = "Option::deserialize")]
    pub(crate) higher_is_better: Option<bool>,
    pub(crate) n: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    interval_95: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    n_blocks: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    degrees_of_freedom: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    blocks: Option<String>,
    // For people; it follows from the rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    caveat: Option<String>,
}

impl NumberRecord {
    /// `value`, made of `n`, in `unit`.
    pub(crate) fn new(value: Option<f64>, unit: &str, direction: Direction, n: u64) -> Self {
        Self {
            value,
            unit: unit.to_owned(),
            higher_is_better: direction.higher_is_better(),
            n,
            interval_95: None,
            n_blocks: None,
            degrees_of_freedom: None,
            blocks: None,
            caveat: None,
        }
    }

    /// This number with its `interval` and its caveat: `caveat`, or else that of the interval.
    pub(crate) fn within(self, interval: Option<Interval>, caveat: Option<&str>) -> Self {
        Self {
            interval_95: interval.map(|it| it.ends),
            n_blocks: interval.map(|it| it.blocks.n_blocks),
            degrees_of_freedom: interval.map(|it| it.blocks.degrees_of_freedom),
            blocks: interval.map(|it| it.blocks.kind.name().to_owned()),
            caveat: caveat.map(str::to_owned).or_else(|| interval?.caveat()),
            ..self
        }
    }

    /// Interval of the number; `None` if it has none.
    ///
    /// # Errors
    ///
    /// A sentence if its kind of blocks is unknown.
    pub(crate) fn interval(&self) -> Result<Option<Interval>, String> {
        let unknown = |it: &str| format!("unknown blocks of scans {it:?}");
        let kind = self.blocks.as_ref().map(|it| BlockKind::from_name(it).ok_or_else(|| unknown(it)));
        let blocks = self.n_blocks.zip(self.degrees_of_freedom).zip(kind.transpose()?);
        let interval = |(ends, ((n_blocks, degrees_of_freedom), kind))| Interval {
            ends,
            blocks: BlockCount { n_blocks, degrees_of_freedom, kind },
        };
        Ok(self.interval_95.zip(blocks).map(interval))
    }

    /// Whether higher or lower is better.
    pub(crate) fn direction(&self) -> Direction {
        match self.higher_is_better {
            Some(true) => Direction::HigherIsBetter,
            Some(false) => Direction::LowerIsBetter,
            None => Direction::Neither,
        }
    }
}
