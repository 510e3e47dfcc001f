//! Rows of protocols, gathered by detector and scan.

use std::collections::BTreeMap;

use super::argoverse2::Argoverse2;
use super::drawn_scans::DrawnScans;
use super::nuscenes::Nuscenes;
use super::protocol_number::ProtocolNumber;
use super::ranked_classes::RankedScan;
use super::under_protocol::{DrawnValues, UnderProtocol};
use crate::numbers::tally::Tally;
use crate::rows::ranked_box_row::RankedBoxRow;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::extent::OVERALL;
use crate::vocabulary::protocol::Protocol;
use crate::vocabulary::ranked_protocol::RankedProtocol;

/// Rows of protocols, in whatever order they came.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ProtocolTally {
    ranked: BTreeMap<(RankedProtocol, String), BTreeMap<ScanName, RankedScan>>,
}

/// What numbers of a protocol are asked about.
#[derive(Debug, Clone, Copy)]
pub struct ProtocolQuestion<'a> {
    /// The protocol.
    pub protocol: Protocol,
    /// Name of the detector.
    pub detector: &'a str,
}

impl ProtocolTally {
    /// Adds an annotation or a detection.
    pub fn add_ranked_box(&mut self, row: &RankedBoxRow) {
        let scans = self.ranked.entry((row.protocol, row.detector.clone())).or_default();
        if !scans.contains_key(&row.scan) {
            scans.insert(row.scan.clone(), RankedScan::default());
        }
        let scan = scans.get_mut(&row.scan).expect("it is there now");
        scan.add(row.protocol, &row.ranked_box);
    }

    /// The protocols that there are rows of, in the order of tables.
    pub fn protocols(&self) -> Vec<Protocol> {
        let has_rows = |protocol: &Protocol| self.ranked.keys().any(|(it, _)| it.protocol() == *protocol);
        Protocol::ALL.into_iter().filter(has_rows).collect()
    }

    /// What is asked about, on `scans`; `None` if there are no rows of it.
    pub fn rows(
        &self,
        question: ProtocolQuestion<'_>,
        scans: &DrawnScans,
    ) -> Option<Box<dyn UnderProtocol + '_>> {
        let ProtocolQuestion { protocol, detector } = question;
        let ranked = RankedProtocol::ALL.into_iter().find(|it| it.protocol() == protocol)?;
        let rows = self.ranked.get(&(ranked, detector.to_owned()))?;
        Some(match ranked {
            RankedProtocol::Nuscenes => Box::new(Nuscenes::new(scans.names(), rows)),
            RankedProtocol::Argoverse2 => Box::new(Argoverse2::new(scans.names(), rows)),
        })
    }

    /// All numbers, with how sure they are: protocol by protocol, data set by data set and then all together, detector by detector.
    /// Which scans there are, and which are drawn together, is known from `tally`.
    pub fn numbers(&self, tally: &Tally) -> Vec<ProtocolNumber> {
        let mut datasets: Vec<&str> = tally.datasets().iter().map(String::as_str).collect();
        if datasets.len() > 1 {
            datasets.push(OVERALL);
        }
        let drawn: Vec<(&str, DrawnScans)> =
            datasets.into_iter().map(|it| (it, DrawnScans::of(tally, it))).collect();
        let mut numbers = Vec::new();
        for protocol in self.protocols() {
            for (dataset, scans) in &drawn {
                for detector in tally.detectors() {
                    let Some(rows) = self.rows(ProtocolQuestion { protocol, detector }, scans) else {
                        continue;
                    };
                    let drawn = DrawnValues::new(&*rows, scans);
                    for (place, metric) in rows.metrics().into_iter().enumerate() {
                        numbers.push(ProtocolNumber {
                            protocol,
                            dataset: (*dataset).to_owned(),
                            detector: detector.clone(),
                            metric,
                            value: drawn.values[place],
                            interval: drawn.interval(place, scans),
                        });
                    }
                }
            }
        }
        numbers
    }
}
