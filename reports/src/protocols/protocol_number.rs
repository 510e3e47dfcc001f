//! One number of a protocol, with all that is needed to read it.

use serde::{Deserialize, Serialize};

use crate::numbers::blocks::Interval;
use crate::numbers::number_record::NumberRecord;
use crate::vocabulary::metric::Direction;
use crate::vocabulary::protocol::Protocol;

/// Class of numbers over all classes of a protocol together, averaged as its makers do.
pub const ALL_CLASSES: &str = "all";

/// Class of numbers over those classes that the scans have annotations of.
pub const PRESENT_CLASSES: &str = "present";

/// A metric of a protocol.
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
    /// Number of annotations that count, or of instances, segments, points or scans, that it is made of.
    pub n: u64,
}

impl ProtocolMetric {
    /// The number called `id` of `class`.
    pub(super) fn new(class: &str, (id, unit, direction): (&str, &'static str, Direction), n: u64) -> Self {
        Self { class: class.to_owned(), id: id.to_owned(), unit, direction, n }
    }
}

/// A number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "RowRecord", try_from = "RowRecord")]
pub struct ProtocolNumber {
    /// The protocol.
    pub protocol: Protocol,
    /// Id of the data set, or the name of an [`Extent`](crate::vocabulary::extent::Extent) of several.
    pub dataset: String,
    /// Name of the detector.
    pub detector: String,
    /// The metric.
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
struct RowRecord {
    protocol: Protocol,
    dataset: String,
    detector: String,
    class: String,
    metric: String,
    #[serde(flatten)]
    number: NumberRecord,
}

impl From<ProtocolNumber> for RowRecord {
    fn from(number: ProtocolNumber) -> Self {
        let ProtocolNumber { protocol, dataset, detector, metric, value, interval } = number;
        Self {
            protocol,
            dataset,
            detector,
            class: metric.class,
            metric: metric.id,
            number: NumberRecord::new(value, metric.unit, metric.direction, metric.n).within(interval, None),
        }
    }
}

impl TryFrom<RowRecord> for ProtocolNumber {
    type Error = String;

    fn try_from(record: RowRecord) -> Result<Self, String> {
        let RowRecord { protocol, dataset, detector, class, metric: id, number } = record;
        let unit = UNITS.into_iter().find(|it| *it == number.unit);
        let unit = unit.ok_or_else(|| format!("{id} has the unknown unit {:?}", number.unit))?;
        let interval = number.interval()?;
        let metric = ProtocolMetric { class, id, unit, direction: number.direction(), n: number.n };
        Ok(Self { protocol, dataset, detector, metric, value: number.value, interval })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_that_nobody_knows_is_refused() {
        let written = r#"{"protocol":"nuscenes","dataset":"a","detector":"b","class":"car","metric":"ap","value":0.5,"unit":"ratio","higher_is_better":true,"n":3}"#;
        let number: ProtocolNumber = serde_json::from_str(written).unwrap();
        assert_eq!(serde_json::to_string(&number).unwrap(), written);
        for (from, to) in [("\"n\":3", "\"n\":3,\"m\":4"), ("\"value\":0.5,", ""), ("\"n\":3", "\"n\":-3")] {
            let damaged = written.replacen(from, to, 1);
            assert!(serde_json::from_str::<ProtocolNumber>(&damaged).is_err(), "{damaged}");
        }
    }
}
