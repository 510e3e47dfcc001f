//! Rows of protocols, gathered by detector and scan.

use std::collections::BTreeMap;

use super::drawn_scans::DrawnScans;
use super::ground::{Ground, ScoredGround};
use super::kitti_object::numbers::KittiMatches;
use super::kitti_object::scan::KittiScan;
use super::protocol_number::ProtocolNumber;
use super::ranked_classes::RankedScan;
use super::semantic_kitti::{ScoredLabels, SemanticKitti};
use super::under_protocol::{DrawnValues, UnderProtocol};
use super::under_ranked;
use crate::numbers::tally::Tally;
use crate::rows::kitti_object_row::{KittiFact, KittiObjectRow};
use crate::rows::label_score_row::LabelScoreRow;
use crate::rows::official_rows::OfficialRows;
use crate::rows::ranked_box_row::RankedBoxRow;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::protocol::{Protocol, ProtocolFamily};

/// Rows of protocols, in whatever order they came.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ProtocolTally {
    ranked: BTreeMap<(Protocol, String), BTreeMap<ScanName, RankedScan>>,
    // By detector.
    kitti: BTreeMap<String, BTreeMap<ScanName, Vec<KittiFact>>>,
    // By detector.
    labels: BTreeMap<String, BTreeMap<ScanName, ScoredLabels>>,
    ground: BTreeMap<String, BTreeMap<ScanName, ScoredGround>>,
}

/// Protocol and detector of the numbers that are asked for.
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

    /// Adds a row of KITTI's evaluation.
    pub fn add_kitti_object(&mut self, row: &KittiObjectRow) {
        let scans = self.kitti.entry(row.detector.clone()).or_default();
        scans.entry(row.scan.clone()).or_default().push(row.fact);
    }

    /// Adds rows of any kind.
    pub fn add(&mut self, rows: &OfficialRows) {
        for row in &rows.boxes {
            self.add_ranked_box(row);
        }
        for row in &rows.kitti {
            self.add_kitti_object(row);
        }
        for row in &rows.labels {
            self.add_label_score(row);
        }
    }

    /// Checks that the rows of each scan fit together.
    ///
    /// # Errors
    ///
    /// A sentence that names the scan whose rows do not, and says how.
    pub fn check(&self) -> Result<(), String> {
        for (detector, scans) in &self.kitti {
            for (name, facts) in scans {
                KittiScan::of(facts.iter().copied()).map_err(|problem| {
                    let ScanName { dataset, sequence, scan } = name;
                    format!("of scan {sequence}/{scan:06} of {dataset:?}, detector {detector:?}: {problem}")
                })?;
            }
        }
        Ok(())
    }

    /// Adds a score of labels.
    pub fn add_label_score(&mut self, row: &LabelScoreRow) {
        let (detector, scan) = (row.detector.clone(), row.scan.clone());
        match row.score.protocol() {
            Protocol::Ground => {
                self.ground.entry(detector).or_default().entry(scan).or_default().add(&row.score);
            }
            _ => self.labels.entry(detector).or_default().entry(scan).or_default().add(&row.score),
        }
    }

    /// Protocols with rows, in the order of tables.
    pub fn protocols(&self) -> Vec<Protocol> {
        let has_rows = |protocol: &Protocol| match protocol.family() {
            ProtocolFamily::KittiObjects => !self.kitti.is_empty(),
            ProtocolFamily::Instances => !self.labels.is_empty(),
            ProtocolFamily::Ground => !self.ground.is_empty(),
            ProtocolFamily::RankedBoxes => self.ranked.keys().any(|(it, _)| it == protocol),
        };
        Protocol::ALL.into_iter().filter(has_rows).collect()
    }

    /// Rows of `question` on `scans`; `None` if there are none.
    pub fn rows(
        &self,
        question: ProtocolQuestion<'_>,
        scans: &DrawnScans,
    ) -> Option<Box<dyn UnderProtocol + '_>> {
        let ProtocolQuestion { protocol, detector } = question;
        Some(match protocol.family() {
            ProtocolFamily::KittiObjects => {
                let facts = self.kitti.get(detector)?.iter();
                // Rows that are read from files were checked.
                let of_scan = |(name, facts): (&ScanName, &Vec<KittiFact>)| {
                    Some((name.clone(), KittiScan::of(facts.iter().copied()).ok()?))
                };
                let of_scans = facts.filter_map(of_scan).collect();
                Box::new(KittiMatches::named(scans.names(), &of_scans))
            }
            ProtocolFamily::Instances => {
                Box::new(SemanticKitti::new(scans.names(), self.labels.get(detector)?))
            }
            ProtocolFamily::Ground => Box::new(Ground::new(scans.names(), self.ground.get(detector)?)),
            ProtocolFamily::RankedBoxes => {
                let rows = self.ranked.get(&(protocol, detector.to_owned()))?;
                return under_ranked(protocol, scans.names(), rows);
            }
        })
    }

    /// All numbers with their intervals: protocol by protocol, data set by data set and then those of one origin together,
    /// detector by detector. `tally` has the scans, and which of them are drawn together.
    pub fn numbers(&self, tally: &Tally) -> Vec<ProtocolNumber> {
        let pools = tally.pools();
        let several = pools.iter().filter(|it| it.is_of_several()).map(|it| it.extent.name());
        let datasets = tally.datasets().iter().map(String::as_str).chain(several);
        let drawn: Vec<(&str, DrawnScans)> = datasets.map(|it| (it, DrawnScans::of(tally, it))).collect();
        let detectors: Vec<&str> = tally.detectors().iter().map(String::as_str).collect();
        self.numbers_on(&drawn, &detectors)
    }

    /// All numbers of `detectors` on `drawn`, in this order: scans, each with the name of their data set or data sets.
    pub fn numbers_on(&self, drawn: &[(&str, DrawnScans)], detectors: &[&str]) -> Vec<ProtocolNumber> {
        let mut numbers = Vec::new();
        for protocol in self.protocols() {
            for (dataset, scans) in drawn {
                for detector in detectors {
                    if let Some(rows) = self.rows(ProtocolQuestion { protocol, detector }, scans) {
                        numbers.extend(numbers_of(&*rows, scans, protocol, dataset, detector));
                    }
                }
            }
        }
        numbers
    }
}

/// Numbers of `rows` on `scans`: those of `detector` on `dataset` under `protocol`.
fn numbers_of(
    rows: &dyn UnderProtocol,
    scans: &DrawnScans,
    protocol: Protocol,
    dataset: &str,
    detector: &str,
) -> Vec<ProtocolNumber> {
    let drawn = DrawnValues::new(rows, scans);
    let number = |(index, metric)| ProtocolNumber {
        protocol,
        dataset: dataset.to_owned(),
        detector: detector.to_owned(),
        metric,
        value: drawn.values[index],
        interval: drawn.interval(index, scans),
    };
    rows.metrics().into_iter().enumerate().map(number).collect()
}
