//! Numbers of detectors at the points of a sweep under protocols of others: `sweep_protocols.csv` and
//! `sweep_protocols.json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::files::csv_rows::csv_of_cells;
use crate::numbers::blocks::Interval;
use crate::numbers::sweep_curve::{Curve, Reached, curves};
use crate::numbers::sweep_score::{SweepSubject, subject_columns};
use crate::protocols::protocol_number::ProtocolNumber;
use crate::protocols::protocol_report::json_of_rows;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::metric::Direction;
use crate::vocabulary::protocol::Protocol;

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
    /// Point of the sweep, data sets and detector.
    pub subject: SweepSubject,
    /// The number.
    pub number: ProtocolNumber,
}

/// One number of one detector.
pub type NumberCurve<'a> = Curve<'a, SweptNumber>;

/// Columns of a number, after those of its subject.
const COLUMNS: [&str; 12] = [
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
    pub fn to_csv(&self) -> Vec<u8> {
        let mut columns = subject_columns(&self.parameters);
        columns.extend(COLUMNS.map(str::to_owned));
        csv_of_cells(columns, self.numbers.iter().map(SweptNumber::cells))
    }

    /// The content of `sweep_protocols.json`: one number a line, as `protocols.json` has it, with the point and its values.
    pub fn to_json(&self) -> String {
        json_of_rows(self.numbers.iter().map(|SweptNumber { subject, number }| {
            let names = self.parameters.iter().map(String::as_str);
            let values = names.zip(subject.values.iter().map(String::as_str)).collect();
            RowRecord { point: subject.point_idx, values, number }
        }))
    }

    /// The curves of those principal numbers that are defined somewhere, in the order of their first points.
    pub fn principal_curves(&self) -> Vec<NumberCurve<'_>> {
        let principal = self.numbers.iter().filter(|it| it.number.is_principal());
        let mut curves = curves(&self.parameters, self.n_swept, principal);
        curves.retain(|it| it.points.iter().any(|it| it.reached.number.value.is_some()));
        curves
    }

    /// The protocols, each with what it was evaluated on, in the order of the numbers.
    pub fn extents(&self) -> Vec<(Protocol, &Extent)> {
        let mut extents: Vec<(Protocol, &Extent)> = Vec::new();
        for it in &self.numbers {
            let extent = (it.number.protocol, &it.subject.extent);
            if !extents.contains(&extent) {
                extents.push(extent);
            }
        }
        extents
    }
}

#[derive(Serialize)]
struct RowRecord<'a> {
    point: usize,
    values: BTreeMap<&'a str, &'a str>,
    #[serde(flatten)]
    number: &'a ProtocolNumber,
}

impl Reached for SweptNumber {
    fn subject(&self) -> &SweepSubject {
        &self.subject
    }

    fn about(&self) -> Vec<&str> {
        let ProtocolNumber { protocol, metric, .. } = &self.number;
        vec![protocol.name(), &metric.class, &metric.id]
    }

    fn value(&self) -> Option<f64> {
        self.number.value
    }

    fn interval(&self) -> Option<Interval> {
        self.number.interval
    }

    fn direction(&self) -> Direction {
        self.number.metric.direction
    }
}

impl SweptNumber {
    fn cells(&self) -> Vec<String> {
        let Self { subject, number } = self;
        let metric = &number.metric;
        let digits = |it: Option<f64>| it.map(|it| it.to_string()).unwrap_or_default();
        let end = |index: usize| digits(number.interval.map(|it| it.ends[index]));
        let of_blocks = |text: fn(Interval) -> String| number.interval.map_or_else(String::new, text);
        let direction = metric.direction.higher_is_better();
        let mut cells = subject.cells_of_row();
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
    use crate::vocabulary::origin::Origin;

    /// A sweep of a probability, 0.1, 0.2 and so on: `map` has the mAP of the present classes at each point. Cars have an
    /// error, too.
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
        insta::assert_snapshot!(String::from_utf8(swept.to_csv()).unwrap(), @r"
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
    #[test]
    fn a_curve_is_of_a_principal_number_that_is_known() {
        let numbers = swept(&[Some(0.25), None, Some(0.5), Some(0.5)]);
        let curves = numbers.principal_curves();
        assert_eq!(curves.len(), 1);
        let xs: Vec<f64> = curves[0].points.iter().map(|it| it.x).collect();
        assert_eq!(xs, [0.1, 0.2, 0.3, 0.4]);
        let [best, worst] = [curves[0].best(), curves[0].worst()].map(|it| it.map(|it| it.x_text));
        assert_eq!((best, worst), (Some("0.3"), Some("0.1")));
        assert_eq!(swept(&[None, None]).principal_curves(), []);
        let street = Extent::Dataset("street".to_owned());
        assert_eq!(numbers.extents(), [(Protocol::Nuscenes, &street)]);
    }

    #[test]
    fn of_errors_the_least_is_best() {
        let mut numbers = swept(&[Some(0.25), Some(0.5)]);
        numbers.numbers.retain(|it| it.number.is_principal());
        for (direction, best) in [(Direction::LowerIsBetter, Some("0.1")), (Direction::Neither, None)] {
            for it in &mut numbers.numbers {
                it.number.metric.direction = direction;
            }
            assert_eq!(numbers.principal_curves()[0].best().map(|it| it.x_text), best);
        }
    }
}
