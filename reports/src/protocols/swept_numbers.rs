//! What detectors reach at the points of a sweep under protocols of others: `sweep_protocols.csv` and
//! `sweep_protocols.json`.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use crate::files::archive::SCHEMA;
use crate::numbers::blocks::Interval;
use crate::numbers::sweep_score::SweepSubject;
use crate::protocols::protocol_number::ProtocolNumber;

/// All numbers of a sweep under protocols of others.
#[derive(Debug, Clone, PartialEq)]
pub struct SweptNumbers {
    /// Full names of the parameters that differ from point to point: first the axis of plots, then what else is swept, then
    /// what is tied to these.
    pub parameters: Vec<String>,
    /// How many of these are swept.
    pub n_swept: usize,
    /// Point by point; at each by protocol, by data set and then all together, and by detector.
    pub numbers: Vec<SweptNumber>,
}

/// A number at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct SweptNumber {
    /// Where.
    pub subject: SweepSubject,
    /// The number.
    pub number: ProtocolNumber,
}

/// What is written of the scans and of a number, beside the point.
const COLUMNS: [&str; 16] = [
    "dataset",
    "origin",
    "sensor",
    "detector",
    "protocol",
    "class",
    "metric",
    "value",
    "low",
    "high",
    "unit",
    "higher_is_better",
    "n",
    "n_blocks",
    "blocks",
    "few_blocks",
];

impl SweptNumbers {
    /// The content of `sweep_protocols.csv`: the same sweep gives the same bytes. Values have all digits.
    ///
    /// # Errors
    ///
    /// None while memory lasts.
    pub fn to_csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let point = std::iter::once("point").chain(self.parameters.iter().map(String::as_str));
        writer.write_record(point.chain(COLUMNS))?;
        for it in &self.numbers {
            writer.write_record(it.cells())?;
        }
        Ok(writer.into_inner().expect("memory takes all that is written"))
    }

    /// The content of `sweep_protocols.json`: one number a line, as `protocols.json` has it, with the point and its values.
    pub fn to_json(&self) -> String {
        let mut json = format!("{{\n  \"schema\": {SCHEMA},\n  \"rows\": [");
        for (index, SweptNumber { subject, number }) in self.numbers.iter().enumerate() {
            let separator = if index == 0 { "" } else { "," };
            let names = self.parameters.iter().map(String::as_str);
            let values = names.zip(subject.values.iter().map(String::as_str)).collect();
            let row = RowRecord { point: subject.point_idx, values, number };
            let row = serde_json::to_string(&row).expect("a row has text keys and finite numbers");
            write!(json, "{separator}\n    {row}").expect("a string takes all that is written");
        }
        json.push_str("\n  ]\n}\n");
        json
    }
}

#[derive(Serialize)]
struct RowRecord<'a> {
    point: usize,
    values: BTreeMap<&'a str, &'a str>,
    #[serde(flatten)]
    number: &'a ProtocolNumber,
}

impl SweptNumber {
    fn cells(&self) -> Vec<String> {
        let Self { subject, number } = self;
        let metric = &number.metric;
        let digits = |it: Option<f64>| it.map(|it| it.to_string()).unwrap_or_default();
        let end = |index: usize| digits(number.interval.map(|it| it.ends[index]));
        let of_blocks = |text: fn(Interval) -> String| number.interval.map_or_else(String::new, text);
        let direction = metric.direction.higher_is_better();
        let mut cells = vec![subject.point_idx.to_string()];
        cells.extend(subject.values.iter().cloned());
        let texts = [subject.extent.name(), subject.origin.name(), &subject.sensor, &subject.detector];
        cells.extend(texts.map(str::to_owned));
        cells.extend([number.protocol.name(), &metric.class, &metric.id].map(str::to_owned));
        cells.extend([digits(number.value), end(0), end(1), metric.unit.to_owned()]);
        cells.extend([direction.map(|it| it.to_string()).unwrap_or_default(), metric.n.to_string()]);
        cells.push(of_blocks(|it| it.blocks.n_blocks.to_string()));
        cells.push(of_blocks(|it| it.blocks.kind.name().to_owned()));
        cells.push(of_blocks(|it| it.blocks.decide_nothing().to_string()));
        cells
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind};
    use crate::protocols::protocol_number::ProtocolMetric;
    use crate::vocabulary::extent::Extent;
    use crate::vocabulary::metric::Direction;
    use crate::vocabulary::origin::Origin;
    use crate::vocabulary::protocol::Protocol;

    /// A sweep of a probability over as many values as there are of mAP of the present classes, 0.1 and up, with an error of
    /// cars.
    pub(crate) fn swept(map: &[Option<f64>]) -> SweptNumbers {
        let numbers_at = |(point_idx, map): (usize, &Option<f64>)| {
            let number = |class: &str, id: &str, direction, value: Option<f64>| SweptNumber {
                subject: SweepSubject {
                    point_idx,
                    extent: Extent::Dataset("street".to_owned()),
                    origin: Origin::Simulated,
                    sensor: "vlp-16".to_owned(),
                    detector: "hierarchical".to_owned(),
                    values: vec![format!("{:.1}", 0.1 * (point_idx + 1) as f64)],
                },
                number: ProtocolNumber {
                    protocol: Protocol::Nuscenes,
                    dataset: "street".to_owned(),
                    detector: "hierarchical".to_owned(),
                    metric: ProtocolMetric {
                        class: class.to_owned(),
                        id: id.to_owned(),
                        unit: "ratio",
                        direction,
                        n: 9,
                    },
                    value,
                    interval: value.map(|it| Interval {
                        ends: [it - 0.125, it + 0.125],
                        blocks: BlockCount::of_dataset(3, BlockKind::Seconds),
                    }),
                },
            };
            [
                number("present", "ap", Direction::HigherIsBetter, *map),
                number("car", "ase", Direction::LowerIsBetter, map.map(|it| 1.0 - it)),
            ]
        };
        SweptNumbers {
            parameters: vec!["hierarchical.grouping.ranked_probability".to_owned()],
            n_swept: 1,
            numbers: map.iter().enumerate().flat_map(numbers_at).collect(),
        }
    }

    #[test]
    fn rows_stand_alone_with_all_digits() {
        let swept = swept(&[Some(0.25), None]);
        insta::assert_snapshot!(String::from_utf8(swept.to_csv().unwrap()).unwrap(), @r"
        point,hierarchical.grouping.ranked_probability,dataset,origin,sensor,detector,protocol,class,metric,value,low,high,unit,higher_is_better,n,n_blocks,blocks,few_blocks
        0,0.1,street,simulated,vlp-16,hierarchical,nuscenes,present,ap,0.25,0.125,0.375,ratio,true,9,3,seconds,true
        0,0.1,street,simulated,vlp-16,hierarchical,nuscenes,car,ase,0.75,0.625,0.875,ratio,false,9,3,seconds,true
        1,0.2,street,simulated,vlp-16,hierarchical,nuscenes,present,ap,,,,ratio,true,9,,,
        1,0.2,street,simulated,vlp-16,hierarchical,nuscenes,car,ase,,,,ratio,false,9,,,
        ");
        let json: serde_json::Value = serde_json::from_str(&swept.to_json()).unwrap();
        let rows = json["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 4);
        assert_eq!(rows[2]["values"]["hierarchical.grouping.ranked_probability"], "0.2");
        assert_eq!((&rows[2]["point"], &rows[2]["value"]), (&1.into(), &serde_json::Value::Null));
        assert_eq!(rows[0]["interval_95"][1], 0.375);
    }
}
