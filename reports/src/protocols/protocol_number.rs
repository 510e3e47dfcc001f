//! One number of a protocol, with all that is needed to read it.

use serde::{Deserialize, Serialize};

use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
use crate::vocabulary::metric::Direction;
use crate::vocabulary::protocol::Protocol;

/// What numbers of all classes of a protocol together are said to be of, as its makers take the mean.
pub const ALL_CLASSES: &str = "all";

/// The same of those classes that the scans have annotations of.
pub const PRESENT_CLASSES: &str = "present";

/// What is measured under a protocol.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProtocolMetric {
    /// The class as the protocol calls it, [`ALL_CLASSES`] or [`PRESENT_CLASSES`].
    pub class: String,
    /// The name used in files, such as `ap` or `nds`; units are in it.
    pub id: String,
    /// The unit of its values.
    pub unit: &'static str,
    /// Which way is better.
    pub direction: Direction,
    /// What it is made of: the number of annotations that count.
    pub n: u64,
}

/// A number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "NumberRecord", try_from = "NumberRecord")]
pub struct ProtocolNumber {
    /// The protocol.
    pub protocol: Protocol,
    /// Id of the data set, or [`OVERALL`](crate::vocabulary::extent::OVERALL).
    pub dataset: String,
    /// Name of the detector.
    pub detector: String,
    /// What was measured.
    pub metric: ProtocolMetric,
    /// The value; `None` where it is undefined.
    pub value: Option<f64>,
    /// How sure it is, where that is known.
    pub interval: Option<Interval>,
}

/// The units of numbers of protocols.
const UNITS: [&str; 6] = ["ratio", "m", "rad", "m/s", "nats", "count"];

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NumberRecord {
    protocol: Protocol,
    dataset: String,
    detector: String,
    class: String,
    metric: String,
    #[serde(deserialize_with = "Option::deserialize")]
    value: Option<f64>,
    unit: String,
    #[serde(deserialize_with = "Option::deserialize")]
    higher_is_better: Option<bool>,
    n: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    interval_95: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    n_blocks: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    degrees_of_freedom: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    blocks: Option<String>,
    // For people; it follows from the blocks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    caveat: Option<String>,
}

impl From<ProtocolNumber> for NumberRecord {
    fn from(number: ProtocolNumber) -> Self {
        let ProtocolNumber { protocol, dataset, detector, metric, value, interval } = number;
        Self {
            protocol,
            dataset,
            detector,
            class: metric.class,
            metric: metric.id,
            value,
            unit: metric.unit.to_owned(),
            higher_is_better: metric.direction.higher_is_better(),
            n: metric.n,
            interval_95: interval.map(|it| it.ends),
            n_blocks: interval.map(|it| it.blocks.n_blocks),
            degrees_of_freedom: interval.map(|it| it.blocks.degrees_of_freedom),
            blocks: interval.map(|it| it.blocks.kind.name().to_owned()),
            caveat: interval.and_then(|it| it.caveat()),
        }
    }
}

impl TryFrom<NumberRecord> for ProtocolNumber {
    type Error = String;

    fn try_from(record: NumberRecord) -> Result<Self, String> {
        let NumberRecord { protocol, dataset, detector, class, metric: id, value, n, .. } = record;
        let unit = UNITS.into_iter().find(|it| *it == record.unit);
        let unit = unit.ok_or_else(|| format!("{id} has the unknown unit {:?}", record.unit))?;
        let direction = match record.higher_is_better {
            Some(true) => Direction::HigherIsBetter,
            Some(false) => Direction::LowerIsBetter,
            None => Direction::Neither,
        };
        let unknown = |it: String| format!("unknown blocks of scans {it:?}");
        let kind = record.blocks.map(|it| BlockKind::from_name(&it).ok_or_else(|| unknown(it)));
        let blocks = record.n_blocks.zip(record.degrees_of_freedom).zip(kind.transpose()?);
        let interval =
            record.interval_95.zip(blocks).map(|(ends, ((n_blocks, degrees_of_freedom), kind))| Interval {
                ends,
                blocks: BlockCount { n_blocks, degrees_of_freedom, kind },
            });
        let metric = ProtocolMetric { class, id, unit, direction, n };
        Ok(Self { protocol, dataset, detector, metric, value, interval })
    }
}
